"""bench_cost and bench_size: how fast each side goes down, and how its time grows with the problem."""
import numpy as np

from . import style
from .tables import read

SIDES = {"ours": style.BLUE, "Ceres": style.VERMILION}
PANELS = 6


def cost_figure(directory, traces):
    """Cost above the best one against time, a panel for each of the last problems, which are the largest."""
    problems = list(dict.fromkeys(traces["problem"]))[-PANELS:]
    rows, columns = (len(problems) + 2) // 3, min(3, len(problems))
    with style.panels(directory, "bench_cost", rows, columns, (4.4 * columns, 3.4 * rows), legend=3, squeeze=False) as panels:
        for axes, name in zip(panels.flat, problems):
            here = traces.where(problem=name, threads=1.0)
            best = here["cost"].min()
            for side, color in SIDES.items():
                run = here.where(side=side)
                if len(run):
                    excess = np.maximum(run["cost"] / best - 1.0, 1e-9)
                    axes.plot(1e3 * run["seconds"], excess, color=color, marker="o", markersize=3, label=side)
            style.plain_log(axes.xaxis)
            axes.tick_params(axis="x", labelsize=10.5)
            style.log_axis(axes.yaxis)
            axes.axhline(1e-3, color=style.GRAY, linewidth=0.8, linestyle=":")
            axes.set_title(name)
            axes.set_xlabel("time [ms]")
        for axes in panels.flat[len(problems):]:
            axes.set_visible(False)
        for axes in panels[:, 0]:
            axes.set_ylabel("cost / best − 1")
        panels[0, 0].text(0.02, 1.3e-3, "0.1 %", color=style.GRAY, fontsize=10.5, transform=panels[0, 0].get_yaxis_transform())


def size_figure(directory, rows):
    """Time per iteration against the observations of the course's scenes, both sides told the same, with the exponents of a fit."""
    rows = rows.where(threads=1.0, setting="same problem")
    words = [name.split() for name in rows["problem"]]
    scenes = [(i, [int(n) for n in word[0][len("scene/"):].split("x")]) for i, word in enumerate(words)
              if word[0].startswith("scene/") and word[1:] == ["iteration"]]
    if len(scenes) < 2:
        return
    index = np.array([i for i, _ in scenes])
    observations = np.array([(frames - 1.0) * points for _, (frames, points) in scenes])
    with style.panels(directory, "bench_size", 1, 1, (6.5, 4.6)) as axes:
        for side, column in (("ours", "ours_ms"), ("Ceres", "peer_ms")):
            ms = rows[column][index]
            if not np.isfinite(ms.astype(float)).all():
                continue
            slope, offset = np.polyfit(np.log(observations), np.log(ms), 1)
            axes.plot(observations, ms, "o", color=SIDES[side], label=f"{side}: time ∝ $n^{{{slope:.2f}}}$")
            axes.plot(observations, np.exp(offset) * observations**slope, color=SIDES[side], linewidth=1.0)
        style.log_axis(axes.xaxis)
        style.log_axis(axes.yaxis)
        axes.set_xlabel("observations n of the course's scene")
        axes.set_ylabel("time of an iteration [ms]")
        axes.legend()


def draw(directory):
    cost_figure(directory, read(directory, "traces", folder=""))
    size_figure(directory, read(directory, "rows", folder=""))


if __name__ == "__main__":
    style.main(draw)
