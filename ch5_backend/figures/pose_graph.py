#!/usr/bin/python3
"""Draws a pose graph before and after it was optimized, and how its cost fell: DIR/figures/pose_graph.png, .svg and .pdf.

usage: pose_graph.py DIR        the folder that ch5_pose_graph FILE --out DIR has filled

Reads DIR/poses.csv, DIR/edges.csv, DIR/trace.csv and DIR/summary.csv. Both panels have the same scale and are seen from
the same place in parallel projection, a planar graph from above. The path goes from dark to bright; gray lines are the
measurements that close loops, and dots are landmarks.
"""
import numpy as np

from . import style
from .style import plt
from .tables import read, read_summary

ELEVATION = np.radians(35.0)  # of the viewer above the horizon
TURN = np.radians(25.0)       # off the graph's long side


def axes_of_view(p):
    """The picture's axes in the world: across and up."""
    flat = p - p.mean(axis=0)
    long_side = np.linalg.svd(flat[:, :2], full_matrices=False)[2][0]
    if np.ptp(p[:, 2]) <= 1e-9 * np.ptp(p[:, :2]):
        across, ahead = np.array([*long_side, 0.0]), np.array([-long_side[1], long_side[0], 0.0])
        return np.array([across, ahead])
    c, s = np.cos(TURN), np.sin(TURN)
    across = np.array([c * long_side[0] - s * long_side[1], s * long_side[0] + c * long_side[1], 0.0])
    ahead = np.array([-across[1], across[0], 0.0])
    return np.array([across, np.cos(ELEVATION) * np.array([0.0, 0.0, 1.0]) + np.sin(ELEVATION) * ahead])


def positions(poses, state):
    rows = poses.where(state=state)
    return {int(name): np.array(p) for name, *p in zip(rows["id"], rows["x"], rows["y"], rows["z"])}


def segments(edges, position, view):
    i, j = edges["i"].astype(int), edges["j"].astype(int)
    return np.stack([[position[k] @ view.T for k in i], [position[k] @ view.T for k in j]], axis=1)


def panel(axes, lines, on_path, title, chi2):
    kind = plt.matplotlib.collections.LineCollection
    axes.add_collection(kind(lines[~on_path], colors=style.GRAY, linewidths=0.4, alpha=0.45, rasterized=True))
    path = kind(lines[on_path], cmap=style.SHADES, linewidths=1.1, rasterized=True)
    path.set_array(np.arange(on_path.sum()))
    axes.add_collection(path)
    style.bare(axes)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_title(f"{title}: χ² = {style.number(chi2, 4)}", weight="bold")


def draw(directory):
    poses, edges, trace = (read(directory, name, folder="") for name in ("poses", "edges", "trace"))
    summary = read_summary(directory)
    position = {state: positions(poses, state) for state in ("before", "after")}
    after = position["after"]
    view = axes_of_view(np.array(list(after.values())))
    # The path is made of the edges between poses that follow each other in the file.
    place = {int(name): k for k, name in enumerate(poses.where(state="after", kind="pose")["id"])}
    landmarks = [name for name in after if name not in place]
    is_step = lambda i, j: i in place and j in place and place[j] - place[i] == 1
    on_path = np.array([is_step(int(i), int(j)) for i, j in zip(edges["i"], edges["j"])])
    lines = {state: segments(edges, position[state], view) for state in position}

    fig = plt.figure(figsize=(14.5, 4.8))
    places = (0.01, 0.03, 0.355, 0.87), (0.38, 0.03, 0.355, 0.87), (0.79, 0.12, 0.2, 0.78)
    panels = [fig.add_axes(place) for place in places]
    everything = np.concatenate([*lines["before"], *lines["after"]])
    low, high = everything.min(axis=0), everything.max(axis=0)
    margin = 0.03 * (high - low).max() or 1.0
    for axes, state, chi2 in zip(panels, ("before", "after"), ("chi2_before", "chi2")):
        panel(axes, lines[state], on_path, state, float(summary[chi2]))
        if landmarks:
            axes.plot(*(view @ np.transpose([position[state][name] for name in landmarks])), ".", color=style.BLUE, markersize=3)
        axes.set_xlim(low[0] - margin, high[0] + margin)
        axes.set_ylim(low[1] - margin, high[1] + margin)
    style.cost_panel(panels[2], trace, summary, "cost ½ Σ ρ(rᵀWr)" if float(summary["huber"]) > 0 else "cost ½ Σ rᵀWr")
    style.save(fig, directory, "pose_graph")


if __name__ == "__main__":
    style.main(draw)
