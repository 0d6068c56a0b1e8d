#!/usr/bin/python3
"""Draws a solved bundle adjustment before and after, and how its cost fell: DIR/figures/before_after.png, .svg and .pdf.

usage: bal.py DIR        the folder that ch5_bal FILE --out DIR has filled

Reads DIR/points.csv, DIR/cameras.csv, DIR/trace.csv and DIR/summary.csv. Both panels show the same cut of the world
from the same place, behind and above the cameras, in parallel projection; color tells height.
"""
import numpy as np

from . import style
from .style import GRAY, SKY, plt
from .tables import read, read_summary

ELEVATION = np.radians(40.0)  # of the viewer above the horizon
TURN = np.radians(12.0)       # off the scene's long side, which would look flat head-on
NIGHT = "#12141c"
HEIGHTS = plt.matplotlib.colors.ListedColormap(plt.get_cmap("viridis")(np.linspace(0.22, 1.0, 256)))


class View:
    """A parallel projection that suits the scene: the cameras' mean up is up, the long side lies across the picture,
    and the viewer looks the way that the cameras look."""

    def __init__(self, cameras, points):
        centers = cameras.matrix("x", "y", "z")
        self.up = up = unit(np.mean(vectors(cameras, "up"), axis=0))
        across = unit(self.long_side(points, centers))
        ahead = np.cross(up, across)
        if ahead @ np.mean(vectors(cameras, "d"), axis=0) < 0:
            across, ahead = -across, -ahead
        across, ahead = np.cos(TURN) * across + np.sin(TURN) * ahead, np.cos(TURN) * ahead - np.sin(TURN) * across
        self.axes = np.array([across, np.cos(ELEVATION) * up + np.sin(ELEVATION) * ahead])
        self.depth = np.cos(ELEVATION) * ahead - np.sin(ELEVATION) * up
        self.set_limits(self.flat(points), self.flat(centers))
        self.heights = np.percentile(points @ up, [5, 95])

    def long_side(self, points, centers):
        """The horizontal direction in which the scene's bulk spreads most."""
        near = np.linalg.norm(points - np.median(points, axis=0), axis=1)
        bulk = np.vstack([points[near <= np.percentile(near, 90)], centers])
        bulk = bulk - bulk.mean(axis=0)
        horizontal = bulk - np.outer(bulk @ self.up, self.up)
        return np.linalg.svd(horizontal, full_matrices=False)[2][0]

    def set_limits(self, points, centers):
        """All cameras and the middle of the points: strays would shrink all else to a dot."""
        low, high = np.percentile(points, 3, axis=0), np.percentile(points, 97, axis=0)
        low, high = np.minimum(low, centers.min(axis=0)), np.maximum(high, centers.max(axis=0))
        margin = 0.05 * (high - low).max() or 1.0
        self.low, self.high = low - margin, high + margin
        self.size = self.high - self.low

    def widen(self, aspect):
        """Grows the picture to the given width / height."""
        size = np.array([max(self.size[0], aspect * self.size[1]), max(self.size[1], self.size[0] / aspect)])
        middle = 0.5 * (self.low + self.high)
        self.low, self.high, self.size = middle - 0.5 * size, middle + 0.5 * size, size

    def flat(self, p):
        return p @ self.axes.T

    def inside(self, p):
        u = self.flat(p)
        return np.all((u > self.low) & (u < self.high), axis=1)


def unit(v):
    return v / max(np.linalg.norm(v), 1e-300)


def vectors(cameras, name):
    return cameras.matrix(f"{name}_x", f"{name}_y", f"{name}_z")


def draw_cameras(axes, view, cameras, size):
    """Each camera as the outline of a pyramid that opens in the direction of its sight."""
    c, right, up, ahead = cameras.matrix("x", "y", "z"), *(vectors(cameras, name) for name in ("right", "up", "d"))
    corners = [c + size * (0.8 * sx * right + 0.6 * sy * up + 1.2 * ahead)
               for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    lines = [np.stack([a, b], axis=1) for a, b in zip(corners, corners[1:] + corners[:1])]
    lines += [np.stack([c, corner], axis=1) for corner in corners]
    segments = np.concatenate([view.flat(line) for line in lines])
    axes.add_collection(plt.matplotlib.collections.LineCollection(segments, colors=SKY, linewidths=0.8, zorder=3))


def panel(axes, view, points, cameras, title, error):
    shown = points[view.inside(points)]
    shown = shown[np.argsort(-(shown @ view.depth), kind="stable")]  # the far ones first
    axes.set_facecolor(NIGHT)
    axes.scatter(*view.flat(shown).T, c=shown @ view.up, s=np.clip(30000.0 / max(len(shown), 1), 0.7, 12.0),
                 linewidths=0, cmap=HEIGHTS, vmin=view.heights[0], vmax=view.heights[1], rasterized=True)
    draw_cameras(axes, view, cameras, 0.014 * view.size.max() * min(1.0, (100 / len(cameras))**0.5))
    axes.set_xlim(view.low[0], view.high[0])
    axes.set_ylim(view.low[1], view.high[1])
    style.bare(axes)
    axes.set_title(f"{title}: mean error {error:.2f} px", weight="bold")
    if len(shown) < len(points):
        axes.text(0.99, 0.02, f"{len(points) - len(shown)} of {len(points)} points lie outside the picture", ha="right", color=GRAY,
                  transform=axes.transAxes, fontsize=11.5)


def layout(view):
    """Panels side by side, or one above the other for a wide scene; the cost to the right of them."""
    if view.size[0] > 1.7 * view.size[1]:
        size = 12.5, 6.6
        places = (0.01, 0.515, 0.66, 0.435), (0.01, 0.02, 0.66, 0.435), (0.735, 0.09, 0.255, 0.86)
    else:
        size = 14.5, 4.8
        places = (0.01, 0.03, 0.355, 0.89), (0.38, 0.03, 0.355, 0.89), (0.79, 0.12, 0.2, 0.8)
    fig = plt.figure(figsize=size)
    view.widen(places[0][2] * size[0] / (places[0][3] * size[1]))
    return fig, dict(zip(("before", "after", "cost"), map(fig.add_axes, places)))


def draw(directory):
    points, cameras, trace = (read(directory, name, folder="") for name in ("points", "cameras", "trace"))
    summary = read_summary(directory)
    after = points.matrix("x_after", "y_after", "z_after")
    before = points.matrix("x_before", "y_before", "z_before")
    view = View(cameras.where(state="after"), after)
    fig, panels = layout(view)
    for state, p in (("before", before), ("after", after)):
        error = float(summary[f"mean_error_{state}_px"])
        panel(panels[state], view, p, cameras.where(state=state), state, error)
    title = "cost ½ Σ ρ(‖r‖²) [px²]" if float(summary["huber_px"]) > 0 else "cost ½ Σ ‖r‖² [px²]"
    style.cost_panel(panels["cost"], trace, summary, title)
    style.save(fig, directory, "before_after")


if __name__ == "__main__":
    style.main(draw)
