"""The report's first picture: what a back end does, with points and with a flight."""
import numpy as np

from . import style
from .odometry import COLORS, NAMES
from .scene import XYZ, decorate, length, panel
from .style import GRAY, plt
from .tables import read


def draw(directory):
    """The large scene before and after bundle adjustment, and a flight from above."""
    fig = plt.figure(figsize=(11.0, 4.1))
    of = {"scene": "large"}
    frames, points, row = (read(directory, f"mono_ba_{name}").where(**of) for name in ("frames", "points", "summary"))
    row = row.row()
    truth = np.vstack([table.where(state="truth").matrix(*XYZ) for table in (frames, points)])
    limits = truth.min(axis=0) - 1.0, truth.max(axis=0) + 1.0
    parts = (("initial", f"start: {length(row['initial_rmse_landmark_m'])} from the truth"),
             ("final", f"after {row['iterations']:.0f} iterations: {length(row['final_rmse_landmark_m'])}"))
    for k, (state, title) in enumerate(parts):
        axes = fig.add_axes([0.32 * k, -0.12, 0.32, 1.1], projection="3d")
        panel(axes, frames, points, state, limits)
        decorate(axes, limits, zoom=1.55)
        axes.set_axis_off()
        fig.text(0.02 + 0.32 * k, 0.92, title, fontsize=13, weight="bold")
    path, summary = read(directory, "odometry_path"), read(directory, "odometry_policies")
    above = fig.add_axes([0.71, 0.13, 0.275, 0.74])
    rows = path.where(policy="truth")
    above.plot(rows["x_m"], rows["y_m"], color=GRAY, linewidth=6.0, alpha=0.5, label="truth")
    for name in NAMES:
        rows = path.where(policy=name)
        above.plot(rows["x_m"], rows["y_m"], color=COLORS[name], linewidth=1.5,
                   label=f"{NAMES[name]}: {100 * summary.row(policy=name)['ate_m']:.1f} cm")
    above.set_aspect("equal", adjustable="datalim")
    above.set(xlabel="x [m]", ylabel="y [m]")
    above.legend(loc="best", fontsize=11)
    fig.text(0.69, 0.92, "a flight, from above", fontsize=13, weight="bold")
    style.save(fig, directory, "hero")


def caption(directory, say):
    row = read(directory, "mono_ba_summary").row(scene="large")
    return say("hero", cameras=f"{row['frames']:.0f}", points=f"{row['points']:.0f}")
