"""Are the estimators as certain as they may be? NEES of pose and yaw with their 95 % bands, the yaw claimed, and leaks.

Modes of first estimates: none; in the prior only; full, in the prior and the solve. "twice" is VINS-Mono's use of
observations that the prior has swallowed already.
"""
import numpy as np

from . import style
from .style import BLUE, GREEN, ORANGE, PALE, VERMILION, plt
from .tables import read

POLICIES = {"vins": "VINS", "okvis": "OKVIS"}
MODES = {"none": ("no first estimates", ORANGE, "-"), "prior_only": ("in the prior only", BLUE, "--"),
         "full": ("full first estimates", GREEN, "-")}


def curve(axes, rows, values, color, label, dashes="-", band=None, **look):
    """One mode's values over time; `band` names the band of 95 % that is shaded behind them."""
    axes.plot(rows["t_s"], values, dashes, color=color, label=label, **look)
    if band:
        axes.fill_between(rows["t_s"], rows[f"{band}_low"], rows[f"{band}_high"], color=PALE, zorder=0)


def draw(directory):
    table = read(directory, "consistency")
    fig, panels = plt.subplots(2, 4, figsize=(11.0, 5.6), layout="constrained", sharex=True)
    columns = (("nees_pose", "pose", "NEES of the pose (6)"), ("nees_yaw", "yaw", "NEES of yaw (1)"),
               ("yaw_information", None, "yaw claimed [rad⁻²]"), ("yaw_leak", None, "the prior's leak [rad⁻²]"))
    for line, (policy, name) in zip(panels, POLICIES.items()):
        curves = {label: (table.where(policy=policy, mode=mode), color, dashes)
                  for mode, (label, color, dashes) in MODES.items()}
        if policy == "vins":
            curves = {"observations used twice": (table.where(policy="vins twice"), VERMILION, ":"), **curves}
        for axes, (column, band, title) in zip(line, columns):
            for label, (rows, color, dashes) in curves.items():
                curve(axes, rows, np.abs(rows[column]), color, label, dashes, band, linewidth=1.5)
            axes.set_title(f"{name}: {title}" if axes is line[0] else title, fontsize=11)
            if column == "yaw_leak":
                axes.set_yscale("symlog", linthresh=1e-6)
                axes.set_yticks([0, 1e-3, 1, 1e3])
            else:
                style.plain_log(axes.yaxis)
    for axes in panels[1]:
        axes.set_xlabel("time [s]")
    style.legend_above(fig, panels[0, 0], columns=4)
    style.save(fig, directory, "consistency")


def captions(directory, say):
    """{figure: its words}, with every number taken from the tables."""
    summary = read(directory, "consistency_summary")
    tell = {"nees": lambda row: f"{row['nees_pose']:.1f}", "inside": lambda row: f"{100 * row['pose_inside']:.0f} %",
            "gain": lambda row: f"{row['yaw_information_gain']:.2f}",
            "leak": lambda row: style.number(abs(row["yaw_leak"]), 2)}
    numbers = {f"{mode}_{what}": say("both", **{policy: of(summary.row(policy=policy, mode=mode)) for policy in POLICIES})
               for mode in MODES for what, of in tell.items()}
    twice = summary.row(policy="vins twice")
    return {"consistency": say("consistency", runs=f"{summary['runs'][0]:.0f}", **numbers,
                               twice_nees=f"{twice['nees_pose']:.0f}", twice_leak=style.number(twice["yaw_leak"], 2))}


if __name__ == "__main__":
    style.main(draw)
