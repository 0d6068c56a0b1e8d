"""Which weight should I choose? What the curve over the prior's weight owes to damping, stop rule, start and place; and
thirty keyframes of real recordings."""
import numpy as np

from . import gauge_paper, style
from .gauge import ERRORS, METHODS, over_weight, sweep_line
from .style import BLUE, GREEN, INK, ORANGE, VERMILION, plt

USUAL = {"start": "perturbed", "place": "gauge", "damping": "diagonal", "stop": "relative"}
FACTORS = {  # what is varied: (title, {value: label})
    "damping": ("damping", {"diagonal": "λ diag(H)", "identity": "λ I (the course)", "radius": "radius (Dogleg)"}),
    "stop": ("stop rule", {"relative": "cost falls < 10⁻⁶ of itself", "absolute": "‖Δx‖² < 10⁻⁶ (the course)"}),
    "start": ("start", {"perturbed": "poses perturbed", "truth": "true poses (the course)"}),
    "place": ("the prior holds", {"gauge": "the gauge: 4 for 4 freedoms", "pose 0": "pose 0: 6",
                                  "poses 0 and 1": "poses 0, 1: 12 (the course)"})}
LOOKS = ((BLUE, "o"), (VERMILION, "s"), (ORANGE, "^"))
RECORDINGS = {"euroc_v1_01_easy": "EuRoC V1_01", "tango_walk": "Tango"}


def usual(table, **changes):
    return table.where(**{**USUAL, **changes})


def right_weights(table):
    """(least, greatest) weight right of the peak at which no damping needs 5 % more than its fewest there."""
    good = None
    for damping in FACTORS["damping"][1]:
        weights, mean, _ = over_weight(usual(table, damping=damping), "iterations")
        right = weights >= 100
        near = right & (mean <= 1.05 * mean[right].min())
        good = near if good is None else good & near
    if not good.any():
        raise style.TableError("prior_choice: no weight suits all dampings")
    return weights[good].min(), weights[good].max()


def error_ratio(table, place, start="perturbed"):
    """Weights, and the mean error of the position at each next to that without a prior."""
    weights, mean, _ = over_weight(usual(table, place=place, start=start), "position_m")
    return weights, mean / mean[weights == 0]


def band(axes, table):
    axes.axvspan(*right_weights(table), color=GREEN, alpha=0.14, linewidth=0, zorder=0)


def draw_factor(axes, table, factor):
    title, values = FACTORS[factor]
    for (value, label), (colour, marker) in zip(values.items(), LOOKS):
        sweep_line(axes, usual(table, **{factor: value}), "iterations", colour, marker, label, band=False)
    axes.set_title(f"iterations: {title}")
    axes.set_ylim(0, 44)
    axes.legend(loc="upper right", fontsize=10.5)


def draw_error(axes, table, start, title):
    for (place, label), (colour, marker) in zip(FACTORS["place"][1].items(), LOOKS):
        weights, ratio = error_ratio(table, place, start)
        x = style.weight_axis(axes, weights)
        axes.plot(x[1:], ratio[1:], color=colour, marker=marker, markersize=4, label=label)
        axes.plot(x[:1], ratio[:1], color=colour, marker=marker, markersize=4)
    axes.set_title(title)
    style.plain_log(axes.yaxis, [0.5, 1, 2, 5, 10, 20, 50])
    axes.set_ylim(0.3, 60)


def prior_choice(directory):
    table = style.read(directory, "prior_choice")
    fig, panels = plt.subplots(2, 3, figsize=(11.0, 7.2), layout="constrained")
    for axes, factor in zip(panels.flat, FACTORS):
        draw_factor(axes, table, factor)
    draw_error(panels[1, 1], table, "perturbed", "RMSE / free: prior at a wrong value")
    draw_error(panels[1, 2], table, "truth", "RMSE / free: prior at the truth")
    for axes in panels.flat:
        band(axes, table)
        axes.set_xlabel("prior weight w" if axes in panels[1] else "")
    fig.suptitle(answer(table), x=0.01, ha="left", fontsize=13, fontweight="bold")
    style.save(fig, directory, "gauge_prior_choice")


def answer(table):
    """The finding, in the table's numbers."""
    low, high = right_weights(table)
    ratio = error_ratio(table, "gauge")
    moved = np.abs(ratio[1] - 1).max()
    wrong = error_ratio(table, "poses 0 and 1")[1].max()
    return (f"Hold the gauge alone, with any w from {style.number(low, 1)} to {style.number(high, 1)} (green): few "
            f"iterations, whatever the damping.\nThe answer moves by {style.number(100 * moved, 1)} % at most. "
            f"A strong prior on two wrong poses makes it {style.number(wrong, 2)} times worse.")


def recordings(directory):
    """Table III: median and quartiles of each method."""
    table = style.read(directory, "recordings")
    fig, panels = plt.subplots(1, 4, figsize=(11.0, 4.4), layout="constrained")
    for axes, (column, title) in zip(panels, {"iterations": "iterations", **ERRORS}.items()):
        for k, method in enumerate(("fixation", "free", "prior")):
            label, colour, marker = METHODS[method]
            for i, name in enumerate(RECORDINGS):
                low, middle, high = np.percentile(table.where(recording=name, method=method)[column], (25, 50, 75))
                axes.errorbar(i + 0.2 * (k - 1), middle, [[middle - low], [high - middle]], color=colour, marker=marker,
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
    style.legend_above(fig, panels[0])
    style.save(fig, directory, "gauge_recordings")
