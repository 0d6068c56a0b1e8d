"""Which weight should I choose? What the curve over the prior's weight owes to damping, stop rule, start and place; and
thirty keyframes of real recordings."""
import numpy as np

from . import style
from .gauge import ERRORS, METHODS, sweep_line, weight_line
from .numbers import gauge_paper
from .numbers.gauge import error_ratio, right_weights, usual
from .style import BLUE, GREEN, INK, ORANGE, VERMILION

FACTORS = {  # what is varied: (title, {value: label})
    "damping": ("damping", {"diagonal": "λ diag(H)", "identity": "λ I (the course)", "radius": "radius (Dogleg)"}),
    "stop": ("stop rule", {"relative": "cost falls < 10⁻⁶ of itself", "absolute": "‖Δx‖² < 10⁻⁶ (the course)"}),
    "start": ("start", {"perturbed": "poses perturbed", "truth": "true poses (the course)"}),
    "place": ("the prior holds", {"gauge": "the gauge: 4 for 4 freedoms", "pose 0": "pose 0: 6",
                                  "poses 0 and 1": "poses 0, 1: 12 (the course)"})}
LOOKS = ((BLUE, "o"), (VERMILION, "s"), (ORANGE, "^"))
RECORDINGS = {"euroc_v1_01_easy": "EuRoC V1_01", "tango_walk": "Tango"}


def band(axes, table):
    axes.axvspan(*right_weights(table), color=GREEN, alpha=0.14, linewidth=0, zorder=0)


def factor_lines(axes, table, factor, names):
    """Iterations against the weight, a line for each value of the factor."""
    for (value, label), (color, marker) in zip(names.items(), LOOKS):
        sweep_line(axes, usual(table, **{factor: value}), "iterations", color, marker, label, band=False)


def error_lines(axes, table, start, names):
    """The error of the position by that without a prior against the weight, a line for each place of the prior."""
    for (place, label), (color, marker) in zip(names.items(), LOOKS):
        weight_line(axes, *error_ratio(table, place, start), color, marker, label)
    style.plain_log(axes.yaxis, [0.5, 1, 2, 5, 10, 20, 50])


def draw_error(axes, table, start, title):
    error_lines(axes, table, start, FACTORS["place"][1])
    if start == "truth":  # all are near 1
        axes.set_yscale("linear")
    axes.set_title(title)


@style.drawn("gauge_prior_choice", 2, 3, (11.0, 7.2))
def prior_choice(panels, table):
    for axes, (factor, (title, values)) in zip(panels.flat, FACTORS.items()):
        factor_lines(axes, table, factor, values)
        style.legend_over(axes, f"iterations: {title}")
    draw_error(panels[1, 1], table, "perturbed", "RMSE / free: prior at a wrong value")
    draw_error(panels[1, 2], table, "truth", "RMSE / free: prior at the truth")
    for axes in panels.flat:
        band(axes, table)
        axes.set_xlabel("prior weight w" if axes in panels[1] else "")
    panels[0, 0].figure.suptitle(answer(table), x=0.01, ha="left", fontsize=13, fontweight="bold")


def answer(table):
    """The finding, in the table's numbers."""
    low, high = right_weights(table)
    ratio = error_ratio(table, "gauge")
    moved = np.abs(ratio[1] - 1).max()
    wrong = error_ratio(table, "poses 0 and 1")[1].max()
    return (f"Hold the gauge alone, with any w from {style.number(low, 1)} to {style.number(high, 1)} (green): few "
            f"iterations, whatever the damping.\nThe answer moves by {style.number(100 * moved, 1)} % at most. "
            f"A strong prior on two wrong poses makes it {style.number(wrong, 2)} times worse.")


@style.drawn("gauge_recordings", 1, 4, (11.0, 4.4), legend=3)
def recordings(panels, table):
    """Table III: median and quartiles of each method."""
    for axes, (column, title) in zip(panels, {"iterations": "iterations", **ERRORS}.items()):
        for k, method in enumerate(("fixation", "free", "prior")):
            label, color, marker = METHODS[method]
            for i, name in enumerate(RECORDINGS):
                low, middle, high = np.percentile(table.where(recording=name, method=method)[column], (25, 50, 75))
                axes.errorbar(i + 0.2 * (k - 1), middle, [[middle - low], [high - middle]], color=color, marker=marker,
                              linestyle="none", elinewidth=1.2, markersize=6, label=None if i else label)
            if column in ERRORS:
                error = gauge_paper.EUROC.get(method, gauge_paper.EUROC["fixation"])[list(ERRORS).index(column)]
                axes.plot(2 + 0.2 * (k - 1), error, color=INK, marker=marker, markerfacecolor="none", linestyle="none")
        ticks = [*RECORDINGS.values(), "the paper's\nEuRoC MH"] if column in ERRORS else RECORDINGS.values()
        axes.set_xticks(range(len(ticks)), [tick.replace(" ", "\n", 1) for tick in ticks], fontsize=10)
        axes.set_xlim(-0.6, len(ticks) - 0.4)
        axes.grid(axis="x", visible=False)
        axes.set_ylim(bottom=0)
        axes.set_title(title)
