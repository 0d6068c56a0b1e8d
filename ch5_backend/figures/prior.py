"""The prior-weight experiment: convergence, answer and drift against the weight."""
import numpy as np

from . import style
from .style import BLUE, GREEN, GRAY, INK, ORANGE, PINK, SKY, VERMILION, plt
from .tables import Table, read

VARIANTS = {  # name: (label, color)
    "course": ("course: starts at the truth, W = I", VERMILION),
    "perturbed": ("perturbed start, W = 1/σ²", BLUE),
    "minimal": ("the same, minimal gauge", GREEN),
}

OTHERS = (ORANGE, SKY, PINK)
CAPPED = "maximum of iterations"
TICKS = [digit * 10.0**exponent for exponent in range(-4, 8) for digit in (1, 2, 5)]


def curves(table, labels):
    """(rows, label, color) of each variant; those that are not the chapter's go by their own name."""
    if labels:
        return [(table.where(variant=name), labels[name], VARIANTS[name][1]) for name in labels]
    if "variant" not in table.columns:
        return [(table, None, BLUE)]
    names = list(dict.fromkeys(table["variant"]))
    known = [name for name in VARIANTS if name in names]
    others = [name for name in names if name not in VARIANTS]
    return [(table.where(variant=name), *VARIANTS[name]) for name in known] + [
        (table.where(variant=name), str(name), OTHERS[i % len(OTHERS)]) for i, name in enumerate(others)]


def lines(axes, table, column, scale=lambda rows, values: values, names=None, marks=True):
    """One line a variant against the weight; w = 0 stands apart, and open marks did not converge.

    A deck names its variants, {variant: label}, and may leave the marks out.
    """
    table = Table({**table.columns, "x": style.weight_axis(axes, table["weight"])})
    for rows, label, color in curves(table, names):
        x, y, free = rows["x"], scale(rows, rows[column]), rows["weight"] == 0
        axes.plot(x[~free], y[~free], color=color, marker="o" if marks else None, label=label)
        axes.plot(x[free], y[free], color=color, marker="o")
        if marks and "termination" in rows.columns:
            capped = rows["termination"] == CAPPED
            axes.plot(x[capped], y[capped], linestyle="none", marker="o", color=color, markerfacecolor="white")


def sweep_figure(table):
    """Iterations, time and RMSE of the positions against the weight."""
    fig, panels = plt.subplots(1, 3, figsize=style.WIDE, layout="constrained")
    lines(panels[0], table, "iterations")
    lines(panels[1], table, "milliseconds")
    lines(panels[2], table, "rmse_position", scale=lambda rows, values: 1e3 * values)
    style.plain_log(panels[0].yaxis, TICKS)
    style.plain_log(panels[1].yaxis, TICKS)
    panels[2].set_ylim(bottom=0)
    if "termination" in table.columns and (table["termination"] == CAPPED).any():
        panels[0].text(0.98, 0.97, "open: stopped there,\nnot converged", transform=panels[0].transAxes, ha="right",
                       va="top", fontsize=10.5, color=GRAY)
    for axes, title in zip(panels, ("iterations", "time [ms]", "RMSE, aligned by cameras [mm]")):
        axes.set_title(title)
    style.legend_above(panels[0])
    return fig


@style.drawn("prior_costs", 1, 3, legend=3)
def costs(panels, table):
    per_free = lambda rows, values: values / rows["reprojection_cost"][0]  # of w = 0, the first row
    lines(panels[0], table, "reprojection_cost", scale=per_free)
    positive = lambda rows, values: np.where(values > 0, per_free(rows, values), np.nan)
    lines(panels[1], table, "prior_cost", scale=positive)
    lines(panels[2], table, "drift_position")
    for axes, title in zip(panels, ("reprojection cost", "prior cost", "drift of frame 0 [m]")):
        axes.set_title(title)
    for axes in panels[:2]:
        axes.set_ylabel("/ reprojection cost at w = 0")
    for axes in panels[1:]:  # below lies rounding
        style.log_axis(axes.yaxis)
        axes.set_ylim(bottom=1e-12)


@style.drawn("prior_traces", 1, 3, sharey=True)
def traces(panels, table):
    decades = np.array([w for w in np.unique(table["weight"]) if w > 0 and abs(np.log10(w) % 1) < 1e-9])
    norm = plt.matplotlib.colors.LogNorm(decades.min(), decades.max())
    for axes, (variant, (label, color)) in zip(panels, VARIANTS.items()):
        rows = table.where(variant=variant)
        for weight in (*decades, 0.0):
            cost, k = (rows.where(weight=weight)[name] for name in ("cost", "iteration"))
            excess = (cost - cost[-1]) / cost[0]
            keep = excess > 0
            shade = INK if weight == 0 else style.SHADES(norm(weight))
            axes.plot(k[keep] + 1, excess[keep], color=shade, linewidth=1.5, linestyle=":" if weight == 0 else "-",
                      label="w = 0" if weight == 0 else None)
        axes.set_title(label, color=color, fontsize=11)
        style.plain_log(axes.xaxis, (1, 3, 10, 30, 100))
        style.log_axis(axes.yaxis)
        axes.set_xlabel("iteration + 1")
    panels[0].set_ylabel("(cost − final cost) / first cost")
    panels[0].legend(loc="lower left")
    bar = panels[0].figure.colorbar(plt.cm.ScalarMappable(norm, style.SHADES), ax=list(panels), label="prior weight w", pad=0.02)
    bar.set_ticks(decades[::2], labels=[style.power_of_ten(round(np.log10(w))) for w in decades[::2]])
    bar.minorticks_off()


@style.drawn("prior_trials", 1, 2, legend=3)
def trials(panels, table):
    lines(panels[0], table, "mean_iterations")
    lines(panels[1], table, "mean_drift_position")
    panels[0].set_ylim(bottom=0)
    style.log_axis(panels[1].yaxis)
    panels[0].set_title(f"iterations, mean of {int(table['trials'][0])} scenes")
    panels[1].set_title("drift of frame 0 at the end [m]")


DAMPINGS = {"identity": "H + λ I (Levenberg, the course)", "diagonal": "H + λ diag(H) (Marquardt)"}


def damping_lines(axes, table, column, names):
    """One line a damping against the weight."""
    for name, color in (("identity", VERMILION), ("diagonal", BLUE)):
        rows = table.where(damping=name)
        x = style.weight_axis(axes, rows["weight"])
        axes.plot(x[1:], rows[column][1:], color=color, marker="o", label=names[name])
        axes.plot(x[:1], rows[column][:1], color=color, marker="o")


@style.drawn("prior_damping", 1, 2, legend=3)
def damping(panels, table):
    for axes, column in zip(panels, ("lambda0", "iterations")):
        damping_lines(axes, table, column, DAMPINGS)
    style.log_axis(panels[0].yaxis)
    panels[1].set_ylim(bottom=0)
    panels[1].yaxis.set_major_locator(plt.MaxNLocator(integer=True))
    panels[0].set_title("first damping λ₀")
    panels[1].set_title("iterations")


def draw(directory):
    table = read(directory, "prior_sweep")
    style.save(sweep_figure(table), directory, "prior_sweep")
    costs(directory, table)
    traces(directory, read(directory, "prior_trace"))
    trials(directory, read(directory, "prior_trials"))
    damping(directory, read(directory, "prior_damping"))
