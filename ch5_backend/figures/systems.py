"""What OKVIS, VINS-Mono and g2o are tested for, as curves: of the kept tables of ch5_systems, and of the chapter's.

Each panel draws into given axes, so that the report and the decks show the same; `names` says a label in the reader's words.
"""
from pathlib import Path

import numpy as np

from . import page, style
from .evaluation import boxes
from .numbers import systems as numbers
from .numbers.systems import BACK_ENDS, DATA_SETS, SOLVERS, WAYS
from .numbers.windows import KEPT
from .odometry import COLORS, NAMES
from .style import BLUE, GRAY, GREEN, INK, ORANGE, PALE, PINK, VERMILION, plt
from .tables import Tables
from .words import Labels

LABELS = Labels("en")  # of the report's figures, which translate.py turns
MARKS = {"vins": ("o", -0.14), "okvis": ("s", 0.14)}
OF_BACK_END = {"schur": (BLUE, "-"), "eigen okvis": (ORANGE, "--"), "eigen vins": (PINK, ":"), "qr": (GREEN, "-"),
               "qr float": (VERMILION, "-")}
OF_QUANTITY = {"position": BLUE, "rotation": ORANGE, "velocity": GREEN}
OF_ALGORITHM = {"Gauss-Newton": (ORANGE, "--"), "Levenberg-Marquardt": (BLUE, "-"), "Dogleg": (GREEN, ":")}


def ablation(axes, tables, column, names, size=4):
    """One value a flight, way and policy; crosses: EuRoC's V1_01."""
    for policy, (mark, shift) in MARKS.items():
        for k, way in enumerate(WAYS):
            flights = tables("ablation", policy=policy, way=way)[column]
            spread = shift + np.linspace(-0.08, 0.08, len(flights))
            axes.plot(k + spread, flights, mark, color=COLORS[policy], alpha=0.55, markersize=size,
                      label=NAMES[policy] if k == 0 else None)
            real = tables("ablation_recording", policy=policy, way=way)[column]
            axes.plot(np.full(len(real), k + shift), real, "x", color=INK, markersize=2 * size, markeredgewidth=2,
                      label=names("EuRoC V1_01") if k == 0 and policy == "okvis" else None)
    axes.set_xlim(-0.5, len(WAYS) - 0.5)
    axes.set_xticks(range(len(WAYS)), [names(way) for way in WAYS])
    style.log_axis(axes.yaxis)


def back_end_errors(axes, tables, names):
    for back_end, (color, dashes) in OF_BACK_END.items():
        rows = tables("back_ends", window="simulated", back_end=back_end)
        axes.plot(1 / rows["weakness"], rows["worst_error"], dashes, color=color, marker="o", markersize=4,
                  label=names(BACK_ENDS[back_end]))
    style.log_axis(axes.xaxis)
    style.log_axis(axes.yaxis)
    axes.axhline(1, color=GRAY, linewidth=1)


def back_end_times(axes, tables, names):
    for back_end, (color, dashes) in OF_BACK_END.items():
        rows = [tables("back_ends", window=window, back_end=back_end).rows()[0] for window in numbers.WINDOWS]
        axes.plot([row["landmarks"] for row in rows], [row["microseconds"] / 1e3 for row in rows], dashes, color=color,
                  marker="o", markersize=4)
    style.plain_log(axes.yaxis)


def calibration(axes, tables, quantity, names):
    """The error in each flight, thin, and the median over the flights."""
    for policy in NAMES:
        rows = tables("calibration", policy=policy, quantity=quantity)
        for trial in np.unique(rows["trial"]):
            one = rows.where(trial=trial)
            axes.plot(one["t_s"], one["error"], color=COLORS[policy], linewidth=0.7, alpha=0.5)
        times, medians = numbers.median_over_flights(rows)
        axes.plot(times, medians, color=COLORS[policy], label=NAMES[policy])
    style.plain_log(axes.yaxis)


def preintegration_length(axes, tables, names):
    """Lines: claimed; dots: measured."""
    for quantity, color in OF_QUANTITY.items():
        rows = tables("preintegration", quantity=quantity, rate_hz=200)
        axes.plot(rows["seconds"], rows["claimed"], color=color, label=names(quantity))
        axes.plot(rows["seconds"], rows["measured"], "o", color=color)
    style.plain_log(axes.xaxis, [0.05, 0.1, 0.2, 0.5, 1, 2, 5])
    style.log_axis(axes.yaxis)


def preintegration_rate(axes, tables, names):
    """Claimed by measured, over the rate: densities, and VINS-Mono's σ of a sample."""
    for column, dashes, label in (("claimed", "-", "densities"), ("claimed_per_sample", "--", "a sample's σ, VINS-Mono")):
        for quantity, color in OF_QUANTITY.items():
            rows = tables("preintegration", quantity=quantity, seconds=0.5)
            order = np.argsort(rows["rate_hz"])
            axes.plot(rows["rate_hz"][order], (rows[column] / rows["measured"])[order], dashes, color=color, marker="o",
                      markersize=4)
        axes.plot([], [], dashes, color=INK, label=names(label))
    style.plain_log(axes.xaxis, [50, 100, 200, 400, 800, 1600])
    style.plain_log(axes.yaxis)


def segments_path(axes, tables, names):
    """From above: the truth, and each segment aligned by itself."""
    truth = tables("restart", policy="truth")
    axes.plot(truth["x_m"], truth["y_m"], color=GRAY, linewidth=4, alpha=0.5, label=names("truth"))
    for policy in NAMES:
        rows = tables("restart", policy=policy)
        for segment in np.unique(rows["segment"]):
            one = rows.where(segment=segment)
            axes.plot(one["x_m"], one["y_m"], color=COLORS[policy], label=NAMES[policy] if segment == 0 else None)
    axes.set_aspect("equal", adjustable="datalim")


def segments_error(axes, tables, names):
    """The error over time: each segment aligned by itself, and both with one alignment, thin."""
    for policy in NAMES:
        rows = tables("restart", policy=policy)
        axes.axvspan(*numbers.SILENT, color=PALE, linewidth=0)
        for segment in np.unique(rows["segment"]):
            one = rows.where(segment=segment)
            axes.plot(one["t_s"], one["error_m"], color=COLORS[policy])
            axes.plot(one["t_s"], one["joint_error_m"], color=COLORS[policy], linewidth=0.8)
    style.plain_log(axes.yaxis)


def distance(axes, tables, recording):
    boxes(axes, {policy: tables("distance", recording=recording, policy=policy) for policy in NAMES})


def window_size(axes, tables, recording, column, names):
    for temporal, color in zip(numbers.TEMPORAL, (PINK, ORANGE, BLUE, GREEN)):
        keyframes, values = numbers.over_keyframes(tables, recording, temporal, column)
        axes.plot(keyframes, values, color=color, marker="o", markersize=4, label=names("{n} newest frames", n=temporal))
    axes.set_xticks(keyframes)
    style.plain_log(axes.yaxis)


def okvis_case(axes, tables, case, stage):
    """Largest entry of each block of H, and what goes marked."""
    rows = tables("film_blocks", case=case, stage=stage)
    size = int(rows["size"][0])
    matrix = np.zeros((size, size))
    for block in rows.rows():
        i, j, height, width = (int(block[key]) for key in ("row", "column", "rows", "columns"))
        matrix[i:i + height, j:j + width] = matrix[j:j + width, i:i + height] = block["largest"]
    low, high = np.log10([rows["largest"][rows["largest"] > 0].min(), rows["largest"].max()])
    style.magnitudes(axes, matrix, low - 1, high, cmap="Greys")
    if stage == "window":
        for vertex in tables("film_vertices", case=case, fate="marginalized").rows():
            first, last = vertex["row"] - 0.5, vertex["row"] + vertex["rows"] - 0.5
            for span in (axes.axhspan, axes.axvspan):
                span(first, last, color=VERMILION, alpha=0.3, linewidth=0)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.grid(False)


def solver_column(axes, tables, column, names):
    """A value of each linear solver, over the unknowns."""
    for solver, (label, color) in SOLVERS.items():
        points = sorted(numbers.solves(tables, solver=solver, algorithm="Levenberg-Marquardt"), key=lambda one: one["unknowns"])
        axes.plot([one["unknowns"] for one in points], [one[column] for one in points], color=color, marker="o",
                  markersize=5, label=names(label))
    style.plain_log(axes.xaxis, [2500, 5000, 10000, 15000])
    (style.log_axis if column == "milliseconds" else style.plain_log)(axes.yaxis)


def algorithm_costs(axes, tables, data_set, names):
    """χ² after each iteration, by the least that is known."""
    every = tables("pose_graphs", data_set=data_set, solver="sparse")
    least = numbers.least_cost(tables, data_set)
    for algorithm, (color, dashes) in OF_ALGORITHM.items():
        rows = every.where(algorithm=algorithm)
        axes.plot(rows["iteration"], rows["cost"] / least, dashes, color=color, label=names(algorithm))
    style.log_axis(axes.yaxis)
    axes.xaxis.set_major_locator(plt.MaxNLocator(integer=True))


# ---- the report's figures


@style.drawn("systems_ablation", 1, 2, (11.0, 4.6), legend=3)
def draw_ablation(panels, tables):
    for axes, (column, title) in zip(panels, (("ate_m", "error of the position, ATE [m]"),
                                              ("nees_motion", "NEES of the motion across the window (6)"))):
        ablation(axes, tables, column, lambda key: key.replace(" ", "\n") if key in WAYS else key)
        axes.set_title(title)
    panels[1].axhline(6, color=GRAY, linewidth=1)


@style.drawn("systems_back_ends", 1, 2, (11.0, 4.6), legend=5)
def draw_back_ends(panels, tables):
    back_end_errors(panels[0], tables, LABELS)
    panels[0].set(xlabel="old prior's σ, times", title="worst relative error of an information")
    back_end_times(panels[1], tables, LABELS)
    panels[1].set(xlabel="landmarks that leave", title="time [ms]")


@style.drawn("systems_calibration", 1, 2, (11.0, 4.2), legend=3)
def draw_calibration(panels, tables):
    for axes, (quantity, title) in zip(panels, (("offset_ms", "error of the clock's offset [ms]"),
                                                ("rotation_deg", "error of the camera's rotation [deg]"))):
        calibration(axes, tables, quantity, LABELS)
        axes.axhline(numbers.CALIBRATION_GOALS[quantity], color=GRAY, linewidth=1)
        axes.set(xlabel="time [s]", title=title)


@style.drawn("systems_preintegration", 1, 2, (11.0, 4.6))
def draw_preintegration(panels, tables):
    preintegration_length(panels[0], tables, LABELS)
    panels[0].set(xlabel="length [s]", title="σ [m, rad, m/s]: claimed, and measured (dots)")
    panels[0].legend()
    preintegration_rate(panels[1], tables, LABELS)
    panels[1].set(xlabel="rate of the IMU [Hz]", title="claimed σ / measured σ")
    panels[1].legend()


@style.drawn("systems_restart", 1, 2, (11.0, 4.6), legend=3, gridspec_kw={"width_ratios": (1, 1.4)})
def draw_restart(panels, tables):
    segments_path(panels[0], tables, LABELS)
    panels[0].set(xlabel="x [m]", ylabel="y [m]", title="from above")
    segments_error(panels[1], tables, LABELS)
    panels[1].set(xlabel="time [s]", title="position error [m]; thin: segments aligned as one")


@style.drawn("systems_distance", 1, 3, (11.0, 4.4), legend=3)
def draw_distance(panels, tables):
    for axes, (recording, name) in zip(panels, numbers.RECORDINGS.items()):
        distance(axes, tables, recording)
        axes.set(title=name, xlabel="part of the path [%]\ndistance [m]")
    panels[0].set_ylabel("error over the distance [m]")


@style.drawn("systems_window_size", 1, 3, (11.0, 4.2), legend=4)
def draw_window_size(panels, tables):
    for axes, recording, column, title in zip(panels, ("euroc_v1_01_easy", "simulated", "euroc_v1_01_easy"),
                                              ("ate_m", "ate_m", "milliseconds"),
                                              ("EuRoC V1_01: ATE [m]", "simulated: ATE [m]", "EuRoC: time of an image [ms]")):
        window_size(axes, tables, recording, column, LABELS)
        axes.set(xlabel="keyframes", title=title)


@style.drawn("systems_okvis_cases", 1, 4, (11.0, 3.3))
def draw_okvis_cases(panels, tables):
    titles = iter(("a frame leaves: window", "its prior", "a keyframe leaves: window", "its prior"))
    for k, case in enumerate(("no keyframe", "keyframe")):
        for axes, stage in zip(panels[2 * k:2 * k + 2], ("window", "prior")):
            okvis_case(axes, tables, case, stage)
            axes.set_title(next(titles), fontsize=12)


@style.drawn("systems_pose_graphs", 2, 3, (11.0, 7.0), legend=4)
def draw_pose_graphs(panels, tables):
    for axes, (column, title) in zip(panels[0], (("milliseconds", "time of an iteration [ms]"), ("megabytes", "memory [MB]"))):
        solver_column(axes, tables, column, LABELS)
        axes.set(xlabel="unknowns", title=title)
    for axes, data_set in zip([panels[0, 2], *panels[1]], DATA_SETS):
        algorithm_costs(axes, tables, data_set, LABELS)
        axes.set(xlabel="iteration", title=f"{data_set}: cost / least")
    panels[1, 0].legend(fontsize=10)


OF_CHAPTER = (draw_restart, draw_okvis_cases)
OF_SYSTEMS = (draw_ablation, draw_back_ends, draw_calibration, draw_preintegration, draw_distance, draw_window_size, draw_pose_graphs)


def tables_of(directory):
    """The chapter's tables in this folder, and the kept ones."""
    return Tables(Path(directory) / "csv", KEPT.folder)


def draw(directory):
    for one in (*OF_SYSTEMS, *OF_CHAPTER):
        one(directory, tables_of(directory))


def captions(directory, say):
    """{figure: its words}, which ask the tables for their numbers."""
    usual, constrained = (np.median(KEPT("ablation", policy="vins", way=way)["milliseconds"]) for way in WAYS[-2:])
    imu = KEPT("preintegration")
    names = {"kept": KEPT, "table": tables_of(directory), "usual": usual, "constrained": constrained, "qr": numbers.lost_to_schur(KEPT),
             "slower": numbers.qr_by_schur(KEPT), "medians": numbers.median_over_flights, "claims": imu["claimed"] / imu["measured"],
             "share": numbers.rotation_by_sample(KEPT), "silent": numbers.SILENT, "rms": lambda values: np.sqrt(np.mean(values**2)),
             "ates": lambda keyframes: [numbers.over_keyframes(KEPT, "euroc_v1_01_easy", temporal, "ate_m")[1][keyframes]
                                        for temporal in numbers.TEMPORAL],
             "largest": numbers.solves(KEPT, solver="sparse", algorithm="Levenberg-Marquardt")[-1],
             "by_sparse": numbers.by_sparse, "end_by_least": numbers.end_by_least}
    return {f"systems_{figure}": say(f"systems_{figure}", **names) for figure in (
        "ablation", "back_ends", "calibration", "preintegration", "restart", "distance", "window_size", "okvis_cases", "pose_graphs")}


def nees_of(flights):
    """The median, large ones in two digits, or a dash where a covariance was not positive definite."""
    known = flights["nees_motion"][~np.isnan(flights["nees_motion"])]
    nees = np.median(known) if len(known) else np.nan
    return style.number(nees if nees < 1000 else float(f"{nees:.2g}"), 2) if nees > 0 else "–"


def ablation_table(say):
    """Medians over the flights, and EuRoC's V1_01, across both policies."""
    quantities = {"ATE [m]": lambda of: f"{np.nanmedian(of['ate_m']):.3f}", say("consistency.nees_motion"): nees_of,
                  say("ablation.lost"): lambda of: style.percent((of["restarts"] > 0).mean())}
    recordings = {"simulated": "ablation", "euroc_v1_01_easy": "ablation_recording"}
    return page.crossed([say("ablation.case")], [(say(f"recording.{name}"), list(NAMES.values())) for name in recordings],
                        [(title, [(say(f"ablation.{way}"), *(cell(KEPT(table, policy=policy, way=way)) for table in recordings.values() for policy in NAMES))
                                  for way in WAYS]) for title, cell in quantities.items()])


def starts_table(say):
    """Where each start of a pose graph leads to: ½χ² at the start and at the end."""
    graphs = {}
    for row in KEPT("pose_graph_starts").rows():
        graphs.setdefault(row["data_set"], []).append(
            (say(f"starts.{row['start']}"), style.number(row["first_cost"], 3), style.number(row["cost"], 4), f"{row['iterations']:.0f}",
             f"{row['seconds_to_start'] + row['seconds']:.2f}"))
    return page.crossed([say("starts.start")], [(say(name), ()) for name in ("first_cost", "last_cost", "iterations", "starts.seconds")],
                        [(say(name) if name == "simulated sphere" else name, rows) for name, rows in graphs.items()])


def draw_own(directory):
    """From ch5_systems' tables in this folder."""
    for one in OF_SYSTEMS:
        one(directory, Tables(Path(directory) / "csv"))


if __name__ == "__main__":
    style.main(draw_own)
