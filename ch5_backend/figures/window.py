#!/usr/bin/python3
"""Draws a window before and after its solve, and how its cost fell: DIR/figures/window.png, .svg and .pdf.

usage: window.py DIR        the folder that ch5_window FILE --out DIR has filled

Reads DIR/frames.csv, DIR/trace.csv and DIR/summary.csv.
"""
import numpy as np

from . import style
from .style import BLUE, GRAY, SKY
from .tables import read, read_summary


def draw(directory):
    frames, trace, summary = read(directory, "frames", folder=""), read(directory, "trace", folder=""), read_summary(directory)
    with style.panels(directory, "window", 1, 3, (13.0, 4.4)) as (above, apart, cost):
        looks = {"truth": dict(color=GRAY, linewidth=5.0, alpha=0.45), "before": dict(color=SKY, marker="o"),
                 "after": dict(color=BLUE, marker="o")}
        truth = frames.where(state="truth")
        for state, look in looks.items():
            rows = frames.where(state=state)
            above.plot(rows["x_m"], rows["y_m"], markersize=4, label=state, **{"linewidth": 1.5, **look})
            if state != "truth":
                distance = np.sqrt(sum((rows[axis] - truth[axis])**2 for axis in ("x_m", "y_m", "z_m")))
                apart.plot(rows["frame"], 100 * distance, markersize=4, **{"linewidth": 1.5, **look})
        above.set(xlabel="x [m]", ylabel="y [m]", title=f"{summary['problem']}: frames from above")
        above.legend(loc="best", fontsize=11)
        apart.set(xlabel="frame", ylabel="[cm]", title="distance from the truth, not aligned")
        apart.set_ylim(bottom=0)
        style.cost_panel(cost, trace, summary, "cost ½ Σ ρ(rᵀWr)")


if __name__ == "__main__":
    style.main(draw)
