"""Are the estimators as certain as they may be? NEES of pose and yaw with their 95 % bands, the yaw claimed, and leaks.

Modes of first estimates: none; in the prior only; full, in the prior and the solve. What may make an estimator too
certain besides its linearization: observations used twice, and hosts whose bearing is taken for exact.
"""
import numpy as np

from . import page, style
from .numbers.systems import RECORDINGS
from .numbers.windows import FLIGHTS, KEPT, consistency, kept_summary, paired
from .odometry import NAMES
from .style import BLUE, GREEN, INK, ORANGE, PALE, VERMILION
from .tables import read

MODES = {"none": ("no first estimates", ORANGE, "-"), "prior_only": ("in the prior only", BLUE, "--"),
         "full": ("full first estimates", GREEN, "-")}
CAUSES = {("twice", "exact"): ("used twice, host exact", VERMILION, "-."),
          ("once", "exact"): ("used once, host exact", VERMILION, ":"),
          ("twice", "noisy"): ("used twice, host noisy", BLUE, "-"),
          ("once", "noisy"): ("used once, host noisy", BLUE, "--"),
          ("twice", "published"): ("used twice, as published", INK, "-"),
          ("once", "published"): ("used once, as published", INK, "--")}


def curve(axes, rows, values, color, label, dashes="-", band=None, **look):
    """One mode's values over time; `band` names the band of 95 % that is shaded behind them."""
    axes.plot(rows["t_s"], values, dashes, color=color, label=label, **look)
    if band:
        axes.fill_between(rows["t_s"], rows[f"{band}_low"], rows[f"{band}_high"], color=PALE, zorder=0)


def cause_lines(axes, tables, policy, names, **look):
    """NEES of the pose without constraints, over observations used once and twice and hosts exact and noisy."""
    for (observations, hosts), (label, color, dashes) in CAUSES.items():
        if policy == "okvis" and (observations == "twice" or hosts == "published"):
            continue  # it never uses them twice; the published weights are VINS-Mono's
        rows = consistency(tables, policy, "none", hosts=hosts, observations=observations)
        curve(axes, rows, rows["nees_pose"], color, names(label), dashes, "pose", **look)


@style.drawn("consistency", 2, 4, (11.0, 5.6), legend=4, sharex=True, sharey="col")
def modes(panels, tables):
    columns = (("nees_pose", "pose", "NEES of the pose (6)"), ("nees_yaw", "yaw", "NEES of yaw (1)"),
               ("yaw_information", None, "yaw claimed [rad⁻²]"), ("yaw_leak", None, "the prior's leak [rad⁻²]"))
    for line, (policy, name) in zip(panels, NAMES.items()):
        for axes, (column, band, title) in zip(line, columns):
            for mode, (label, color, dashes) in MODES.items():
                rows = consistency(tables, policy, mode)
                curve(axes, rows, np.abs(rows[column]), color, label, dashes, band, linewidth=1.5)
            axes.set_title(f"{name}: {title}" if axes is line[0] else title, fontsize=11)
            if column == "yaw_leak":
                axes.set_yscale("symlog", linthresh=1e-6)
                axes.set_yticks([0, 1e-3, 1, 1e3])
            else:
                style.plain_log(axes.yaxis)
    for axes in panels[1]:
        axes.set_xlabel("time [s]")
    panels[1, 0].set_xlabel(f"time [s], mean of {rows['runs'][0]:.0f} flights")


@style.drawn("consistency_causes", 1, 2, (11.0, 4.4), legend=3, sharey=True)
def causes(panels, tables):
    for axes, (policy, name) in zip(panels, NAMES.items()):
        cause_lines(axes, tables, policy, str, linewidth=1.5)
        axes.set_title(f"{name}: NEES of the pose (6)")
        axes.set_xlabel(f"time [s], mean of {tables('consistency', policy=policy)['runs'][0]:.0f} flights")
        style.plain_log(axes.yaxis)


def draw(directory, tables=KEPT):
    causes(directory, tables)
    modes(directory, tables)


def draw_own(directory):
    """From the table of this folder."""
    table = read(directory, "consistency")
    draw(directory, lambda _, **where: table.where(**where))


def cases_table(say):
    """Every case, a row each, those of a policy together."""
    blocks = {}
    for row in KEPT("consistency_summary").rows():
        words = (say(f"consistency.{row[key]}") for key in ("observations", "hosts", "mode"))
        blocks.setdefault(NAMES[row["policy"]], []).append(
            (*words, f"{row['nees_pose']:.1f} ± {row['nees_pose_error']:.1f}", style.percent(row["pose_inside"]),
             f"{row['nees_yaw']:.2f} ± {row['nees_yaw_error']:.2f}", style.percent(row["yaw_inside"]),
             f"{row['yaw_information_gain']:.2f}", f"{row['position_rmse_m']:.3f}"))
    corners, quantities = ("observations", "host", "mode"), ("nees_pose", "inside", "nees_yaw", "inside", "gain", "position")
    return page.crossed([say(f"consistency.{name}") for name in corners], [(say(f"consistency.{name}"), ()) for name in quantities],
                        list(blocks.items()))


def hosts_table(say):
    """Recordings with hosts exact, with and without the loss, and noisy, across both policies."""
    cells = {"images": lambda row: f"{row['images']:.0f}", "restarts": lambda row: f"{row['restarts']:.0f}", "ATE [m]": lambda row: f"{row['ate_m']:.3f}",
             "scale_error": lambda row: f"{100 * row['scale_error']:+.1f}", "consistency.rotation": lambda row: f"{row['rotation_error_deg']:.2f}"}
    kept = KEPT("host_noise")
    of = lambda **where: [cell(kept.row(policy=policy, **where)) for cell in cells.values() for policy in NAMES]  # noqa: E731
    hosts = dict.fromkeys(kept["hosts"].tolist())
    return page.crossed([say("consistency.host")], [(title if "[m]" in title else say(title), list(NAMES.values())) for title in cells],
                        [(say(f"recording.{recording}"), [(say(f"consistency.{host}"), *of(recording=recording, hosts=host)) for host in hosts])
                         for recording in dict.fromkeys(kept["recording"].tolist())])


def first_estimates_table(say):
    """Recordings and simulated flights (means) with no first estimates, with them in the prior only, and in full, across both policies."""
    quantities = {"ATE [m]": lambda of: f"{of['ate_m'].mean():.3f}", say("consistency.nees_motion"): lambda of: f"{of['nees_motion'].mean():.0f}",
                  say("consistency.leak"): lambda of: style.number(abs(of["yaw_leak"].mean()), 2)}
    modes = {"none": "none", "prior": "prior_only", "full": "full"}
    of = lambda **where: KEPT("consistency_recording", **where)  # noqa: E731
    return page.crossed([say("consistency.recording")], [(name, [say(f"consistency.{mode}") for mode in modes.values()]) for name in NAMES.values()],
                        [(title, [(say(f"recording.{recording}"), *(cell(of(recording=recording, policy=policy, setting=setting))
                                                                   for policy in NAMES for setting in modes)) for recording in RECORDINGS])
                         for title, cell in quantities.items()])


def paired_table(say):
    """What first estimates change of the error, over flights of each kind."""
    modes = {"prior": "prior_only", "full": "full"}
    return page.crossed([say("consistency.paired")], [(name, [say(f"consistency.{mode}") for mode in modes.values()]) for name in NAMES.values()],
                        [("", [(say(f"flight.{kind}"), *(paired(kind, policy, setting) for policy in NAMES for setting in modes)) for kind in FLIGHTS])])


def why_none(say):
    """Why no first estimates are the default."""
    nees = lambda setting, policy: f"{KEPT('consistency_recording', recording='euroc_v1_01_easy', setting=setting).row(policy=policy)['nees_motion']:.0f}"  # noqa: E731
    flights = len(KEPT("consistency_recording", recording="simulated", setting="none", policy="vins").rows())
    return say("consistency.default", flights=flights, kept=len(KEPT("first_estimates", recording=FLIGHTS[0], policy="vins", setting="none")), **{policy: nees("both x 5", policy) for policy in NAMES},
               **{f"{policy}_truth": nees("truth errs too", policy) for policy in NAMES})


def captions(say):
    """{figure: its words}, which ask the kept tables for their numbers."""
    names = {"case": kept_summary, "first": consistency(KEPT, "vins", "none").rows()[0]}
    return {figure: say(figure, **names) for figure in ("consistency_causes", "consistency")}


if __name__ == "__main__":
    style.main(draw_own)
