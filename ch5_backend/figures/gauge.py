"""The gauge paper's experiments as pictures: iterations, time and errors of the ways to handle a gauge."""
import numpy as np

from . import style
from .numbers import gauge_paper
from .numbers.gauge import READINGS, STARTS, as_the_paper, differences, of_scene, over_weight
from .style import BLUE, GREEN, GRAY, INK, ORANGE, PINK, SKY, VERMILION

METHODS = {"fixation": ("fixation", BLUE, "o"), "free": ("free, damped", GREEN, "^"),
           "prior": ("prior, w = 10⁵", VERMILION, "s"), "pseudo-inverse": ("free, pseudo-inverse", PINK, "D")}
ERRORS = {"position_m": "position [m]", "rotation_deg": "rotation [deg]", "velocity_m_s": "velocity [m/s]"}
PATHS = ("sine", "arc", "rec")
POINTS = {"planes": ("points on planes", BLUE, "o"), "random": ("points along the path", ORANGE, "^")}
STEP = 0.16  # between the methods of a scene


def scene_axis(axes):
    axes.set_xticks(range(6), ["sine", "arc\nplanes", "rec", "sine", "arc\nrandom", "rec"], fontsize=10.5)
    axes.grid(axis="x", visible=False)


def dots(axes, table, column, methods, names=None, spread=np.std):
    """Mean and standard deviation of each method in each scene; a deck has its own names and no deviation. Times are
    of an iteration: the median, from quartile to quartile."""
    for k, method in enumerate(methods):
        label, color, marker = METHODS[method]
        label = names[method] if names else label
        rows = [of_scene(table, scene).where(method=method) for scene in gauge_paper.SCENES]
        if column == "milliseconds":
            low, middle, high = np.array([np.quantile(r[column] / r["iterations"], (0.25, 0.5, 0.75)) for r in rows]).T
            bars = [middle - low, high - middle]
        else:
            middle, bars = [np.mean(r[column]) for r in rows], spread and [spread(r[column]) for r in rows]
        axes.errorbar(np.arange(6) + STEP * (k - (len(methods) - 1) / 2), middle, bars, color=color, marker=marker,
                      linestyle="none", elinewidth=1.2, markersize=6, label=label)


def paper_iterations(axes, methods, label):
    """Fig. 7 of the paper as bars, behind the dots of so many methods."""
    for i, scene in enumerate(gauge_paper.SCENES):
        for k, method in enumerate(("fixation", "free", "prior")):
            low, high = gauge_paper.ITERATIONS[scene][method]
            at = i + STEP * (k - (methods - 1) / 2)
            axes.plot([at, at], [low - 0.06, high + 0.06], color="#bdbdbd", linewidth=11, solid_capstyle="butt", zorder=1,
                      label=label if i + k == 0 else None)


@style.drawn("gauge_methods", 2, 1, (10.0, 6.4), legend=5, sharex=True)
def methods(panels, table):
    """Fig. 7."""
    top, bottom = panels
    paper_iterations(top, len(METHODS), "the paper's")
    dots(top, table, "iterations", METHODS)
    dots(bottom, table, "milliseconds", METHODS)
    top.set_ylabel("iterations")
    style.plain_log(bottom.yaxis)
    bottom.set_ylabel("time an iteration [ms]")
    scene_axis(bottom)


@style.drawn("gauge_errors", 2, 3, (10.5, 6.8), legend=4, sharex=True)
def errors(panels, table):
    """Table II: at convergence."""
    for k, (axes, (column, title)) in enumerate(zip(panels[0], ERRORS.items())):
        for at, scene in enumerate(gauge_paper.SCENES):
            axes.plot([at - 0.35, at + 0.35], 2 * [gauge_paper.RMSE[scene]["fixation"][k]], color=INK, linewidth=1.5,
                      label="the paper's, all methods" if at == 0 else None)
        dots(axes, table, column, ("fixation", "free", "prior"))
        axes.set_title(title)
    for k, (axes, column) in enumerate(zip(panels[1], ERRORS)):
        draw_differences(axes, table, column, k)
    panels[0, 0].set_ylabel("mean RMSE at convergence")
    panels[1, 0].set_ylabel("largest |RMSE / fixation's − 1|")
    panels[1, 0].text(0.02, 0.96, "△ free, the paper's means", transform=panels[1, 0].transAxes, fontsize=10.5,
                      va="top")


def draw_differences(axes, table, column, k):
    """Of prior and free from fixation, and what is asked of them."""
    for method, asked in (("prior", 1e-5), ("free", 1e-2)):
        _, color, marker = METHODS[method]
        worst = differences(table, column, method).reshape(6, -1).max(axis=1)
        axes.plot(range(6), worst, color=color, marker=marker, linestyle="none", markersize=7)
        axes.axhline(asked, color=color, linewidth=1.0)
    paper = [gauge_paper.RMSE[scene] for scene in gauge_paper.SCENES]
    theirs = np.array([abs(rmse["free"][k] / rmse["fixation"][k] - 1) for rmse in paper])
    axes.plot(np.arange(6)[theirs > 0], theirs[theirs > 0], color=INK, marker="^", linestyle="none",
              markerfacecolor="white", markersize=7)
    style.log_axis(axes.yaxis)
    axes.set_ylim(3e-9, 1)
    scene_axis(axes)


def weight_line(axes, weights, values, color, marker, label=None, **look):
    """Values against the weight; w = 0 stands apart. Returns where each weight is drawn."""
    x = style.weight_axis(axes, weights)
    axes.plot(x[1:], values[1:], color=color, marker=marker, markersize=5, label=label, **look)
    axes.plot(x[:1], values[:1], color=color, marker=marker or "o", markersize=5)
    return x


def sweep_line(axes, table, column, color, marker, label=None, band=True, **look):
    weights, mean, spread = over_weight(table, column)
    x = weight_line(axes, weights, mean, color, marker, label, **look)
    if band:
        axes.fill_between(x[1:], (mean - spread)[1:], (mean + spread)[1:], color=color, alpha=0.15, linewidth=0)
        axes.errorbar(x[:1], mean[:1], spread[:1], color=color, elinewidth=1.2)


def change(rows, column, weight):
    """How far the mean RMSE at this weight is from that at the greatest [%]."""
    last = np.mean(rows.where(weight=rows["weight"].max())[column])
    return 100 * (np.mean(rows.where(weight=weight)[column]) / last - 1)


def sweep_errors(panels, table):
    weights = np.unique(table["weight"])
    for axes, (error, title) in zip(panels, ERRORS.items()):
        x = style.weight_axis(axes, weights)
        for path, color in zip(PATHS, (VERMILION, GREEN, SKY)):
            for name, fill in (("planes", "full"), ("random", "none")):
                relative = [change(of_scene(table, (path, name)), error, weight) for weight in weights]
                for part, label in ((slice(1, None), f"{path}: {name}"), (slice(1), None)):
                    axes.plot(x[part], np.array(relative)[part], marker="o", fillstyle=fill, markersize=5, color=color, linewidth=1,
                              label=label)
        axes.set_title(title.rpartition(" ")[0])
    panels[0].set_ylabel("mean RMSE − that at 10⁸ [%]")


def paper_sweep(axes, table, label):
    """The paper's Fig. 5."""
    theirs = np.array(list(gauge_paper.SWEEP))
    free_at = style.weight_axis(axes, np.unique(table["weight"]))[0]
    axes.plot(np.where(theirs > 0, theirs, free_at), list(gauge_paper.SWEEP.values()), linestyle="none", marker="s",
              markersize=6, markerfacecolor="none", color=INK, label=label)


def sweep(directory, table):
    """Figs. 4 and 5."""
    with style.panels(directory, "gauge_sweep", 3, 3, (10.5, 8.8), sharey="row", sharex=True) as panels:
        for (iterations, time), path in zip(panels[:2].T, PATHS):
            for name, (label, color, marker) in POINTS.items():
                rows = of_scene(table, (path, name))
                sweep_line(iterations, rows, "iterations", color, marker, label)
                sweep_line(time, rows, "milliseconds", color, marker)
            paper_sweep(iterations, table, "the paper's")
            iterations.set_title(path)
        sweep_errors(panels[2], table)
        for axes in panels.flat:
            axes.axvline(gauge_paper.RECOMMENDED, color=GRAY, linewidth=1.0, linestyle=(0, (4, 3)), zorder=0)
            axes.set_xlabel("prior weight w" if axes in panels[2] else "")
        for axes, title in zip(panels[:2, 0], ("iterations", "processor time [ms]")):
            axes.set_ylabel(title)
        style.legend_above(panels[0, 0])
        style.space(panels.flat[0].figure, rect=(0, 0.04, 1, 0.91))
        panels.flat[0].figure.legend(*panels[2, 0].get_legend_handles_labels(), loc="lower left", ncol=6, fontsize=11, columnspacing=1.4)


def reading_lines(axes, table, start, names, paper):
    """Fig. 5 of the paper, and our sweep at its weights by what they multiply."""
    weights, mean, _ = over_weight(table.where(start=start), "iterations")
    style.log_axis(axes.xaxis)
    for (reading, power), color in zip(READINGS.items(), (BLUE, VERMILION)):
        at, theirs, ours = as_the_paper(weights, mean, power)
        axes.plot(at, ours, color=color, marker="o", markersize=4, label=names(reading))
    axes.plot(at, theirs, linestyle="none", marker="s", markersize=6, markerfacecolor="none", color=INK, label=paper)


@style.drawn("gauge_readings", 1, 3, (10.5, 4.2), legend=3, sharey=True)
def readings(panels, table):
    """Fig. 5, sine among planes, by the start and by what w multiplies."""
    for axes, start in zip(panels, STARTS):
        reading_lines(axes, table, start, "w multiplies {}".format, "the paper's")
        axes.set(title=f"{start}: {table.where(start=start, weight=0)['start_px'].mean():.0f} px", xlabel="the paper's w")
        axes.set_ylim(0, 15)
    panels[0].set_ylabel("iterations")


def arrival_line(axes, rows, column, **look):
    """An error against the iteration, at one weight."""
    axes.plot(rows["iteration"], np.where(rows[column] > 0, rows[column], np.nan), **look)


@style.drawn("gauge_convergence", 1, 3, (10.5, 4.6), legend=7)
def convergence(panels, table):
    """Fig. 6, of trial 0."""
    table, (path, left, right) = table.where(trial=0), panels
    weights = np.unique(table["weight"])
    for k, weight in enumerate(weights):
        rows = table.where(weight=weight)
        look = dict(color=style.SHADES(k / (len(weights) - 1)), marker=style.MARKS[k % len(style.MARKS)], markersize=5,
                    linewidth=1.5)
        path.plot(rows["prior_error"], rows["reprojection_px"], label=f"w = {style.number(weight, 1)}", **look)
        arrival_line(left, rows, "reprojection_px", **look)
        arrival_line(right, rows, "prior_error", **look)
    for axes in (path, left):
        style.plain_log(axes.yaxis, [1, 2, 5, 10, 20, 50])
    style.log_axis(right.yaxis)
    path.set(xlabel="prior error [m, rad]", title="reprojection error [px]")
    path.annotate("start", (0, table["reprojection_px"].max()), (8, -4), textcoords="offset points", fontsize=11)
    left.set(xlabel="iteration", title="reprojection error [px]")
    right.set(xlabel="iteration", title="prior error [m, rad]")
