"""Deck 4, gauge freedom, drawn by what draws the report of ./course plots gauge; what the paper reports stands beside it."""

from math import ceil

import numpy as np

from ch5_backend.figures import gauge, gauge_choice, gauge_covariance, style
from ch5_backend.figures.numbers import gauge_paper
from ch5_backend.figures.numbers.gauge import STARTS, over_weight, of_scene, relative_spectrum, usual
from ch5_backend.figures.slide import CROSS, INK, LANDMARK, MUTED, POSE, PRIOR, Figures, decades, mix

from . import gauge_examples as toy
from .deck_gauge_facts import facts  # noqa: F401

FIGURES = Figures({  # what the tables' words read as
    "prior": "prior, w = 10⁵", "stated": "our start", "fixed to free": "fixed, transformed", "free to fixed": "free, transformed",
    "identity": "λ I (the course)", "diagonal": "λ diag(H)", "radius": "radius (Dogleg)", "gauge": "gauge: 4", "pose 0": "pose 0: 6",
    "poses 0 and 1": "poses 0 and 1: 12", "rec": "rectangle"})
GAUGE = "../gauge/csv/"  # its tables, beside the chapter's
ARRIVAL = {10.0: mix(PRIOR, 0.45), 100.0: PRIOR, 1000.0: LANDMARK, 1e5: POSE}


@FIGURES.figure(1060, 380, "Three ways into a valley")
def three_ways(slide, tables, say):
    """Damped steps on two numbers with one measured difference, and how many there are for each weight of a prior."""
    axes = slide.axes((60, 38, 420, 272), (-1.05, 0.55), (-0.1, 1.3), "b", "a", "", (-1, -0.5, 0, 0.5), (0, 0.5, 1))
    for shift in (-0.45, -0.2, 0.2, 0.45):  # level lines b = a + 1 + shift
        axes.axline((0, 1 + shift), slope=1, color=mix(POSE, 0.3), linewidth=1)
    axes.axline((0, 1), slope=1, color=LANDMARK, linewidth=3.75, linestyle=style.SOLID)
    axes.text(-1.0, 1.18, say("b − a = 1: the valley"), color=LANDMARK, fontsize=12.75)
    for weight, name, color in ((None, "fixation", POSE), (0.0, "free", CROSS), (toy.WEAK, "weak prior", PRIOR)):
        axes.plot(*zip(*toy.walk(weight)), "o-", color=color, label=say(name), clip_on=False)
    axes.plot(0, 0, "o", color=INK, markersize=10.5, zorder=3)
    axes.annotate(say("start"), (0, 0), (10, 5), textcoords="offset points", fontsize=12.75)
    slide.legend(axes, 378, 160)
    weights = np.array([0.0] + [10.0 ** (k / 4) for k in range(-20, 13)])
    counts = np.array([len(toy.walk(weight)) - 1 for weight in weights])
    top = 10 * (counts.max() // 10 + 1)
    axes = slide.axes((600, 45, 430, 265), y=(0, top), title=say("iterations of this walk"), yticks=range(0, top + 1, 10))
    gauge.weight_line(axes, weights, counts, PRIOR, None, linestyle=style.SOLID)
    axes.set_xlabel(say("weight w"))


@FIGURES.figure(1080, 360, "Zero eigenvalues with and without an IMU")
def gauge_zeros(slide, tables, say):
    for panel, problem in enumerate(("camera and IMU", "camera alone")):
        axes = slide.axes((80 + 545 * panel, 45, 430, 240), title=f"{say(problem)}: {say('|λ| / largest')}", below=say("eigenvalue, ascending"))
        gauge_covariance.spectrum_dots(axes, relative_spectrum(tables(GAUGE + "spectrum"), problem))
        axes.set_ylim(1e-20, 2)


@FIGURES.figure(1080, 360, "Iterations of three ways to handle the gauge")
def gauge_iterations(slide, tables, say):
    """Fig. 7: mean iterations of each method in each scene, the paper's as gray bars."""
    methods = ("fixation", "free", "prior")
    axes = slide.axes((70, 40, 800, 235), (-0.6, 5.6), (3, 8), say("mean iterations"), xticks=(), yticks=range(3, 9))
    gauge.paper_iterations(axes, len(methods), say("the paper"))
    gauge.dots(axes, tables(GAUGE + "methods"), "iterations", methods, {method: say(method) for method in methods}, spread=None)
    for at, scene in enumerate(gauge_paper.SCENES):
        for word, y, color in zip(scene, (300, 324), (INK, MUTED)):
            slide.text(70 + 800 * (at + 0.6) / 6.2, y, say(word), 17, color)
    slide.legend(axes, 895, 80, handlelength=1.2)


@FIGURES.figure(1080, 370, "Iterations against the weight of the prior")
def gauge_weights(slide, tables, say):
    """Figs. 4 and 5: mean iterations against the weight, all scenes; the paper's as squares."""
    table = tables(GAUGE + "sweep")
    axes = slide.axes((70, 40, 760, 260), y=(0, 16), title=say("mean iterations"), yticks=range(0, 17, 4))
    for path, color in zip(gauge.PATHS, (PRIOR, CROSS, POSE)):
        for points, fill in (("planes", "full"), ("random", "none")):
            gauge.sweep_line(axes, of_scene(table, (path, points)), "iterations", color, "o", f"{say(path)}, {say(points)}",
                             band=False, fillstyle=fill)
    gauge.paper_sweep(axes, table, say("the paper"))
    axes.set_xlabel(say("weight w"))
    slide.legend(axes, 860, 70)


@FIGURES.figure(1080, 290, "Two readings of the paper's weight")
def gauge_readings(slide, tables, say):
    """Fig. 5, sine among planes: ours in two readings of w, from three starts."""
    table = tables(GAUGE + "near_start")
    names = {"the cost": "w ‖r‖²", "the residual": "‖w r‖²"}
    for panel, start in enumerate(STARTS):
        axes = slide.axes((50 + 295 * panel, 40, 245, 180), y=(0, 15), title=say(start), yticks=range(0, 16, 5))
        gauge.reading_lines(axes, table, start, names.get, say("the paper"))
        axes.set_xlabel(say("weight w"))
    slide.legend(axes, 935, 60, handlelength=1.2)


@FIGURES.figure(1080, 360, "First the pixels, then the frame")
def gauge_arrival(slide, tables, say):
    """Fig. 6: when the reprojection error and the prior error have arrived, trial 0."""
    table = tables(GAUGE + "convergence", trial=0)
    last = max(table.where(weight=weight)["iteration"].max() for weight in ARRIVAL)
    for panel, (column, name, limits) in enumerate((("reprojection_px", "reprojection error [px]", (1.0, 100.0)),
                                                    ("prior_error", "prior error [m, rad]", (1e-5, 1.0)))):
        axes = slide.axes((75 + 470 * panel, 40, 380, 245), (0, last), limits, say(name), say("iteration"), "y",
                          range(0, int(last) + 1, 2), decades(limits))
        for (weight, color), mark in zip(ARRIVAL.items(), style.MARKS):
            gauge.arrival_line(axes, table.where(weight=weight), column, color=color, marker=mark,
                               label=f"10{'⁰¹²³⁴⁵'[round(np.log10(weight))]}")
    slide.legend(axes, 965, 80)
    slide.text(965, 66, "w", 17, anchor="start", italic=True)


@FIGURES.figure(1080, 360, "Damping and the weight of the prior")
def choice_damping(slide, tables, say):
    """The same problem and prior with three dampings."""
    table = tables(GAUGE + "prior_choice")
    names = {name: say(name) for name in ("diagonal", "identity", "radius")}
    top = 4 * ceil(max(over_weight(usual(table, damping=name), "iterations")[1].max() for name in names) / 4)
    axes = slide.axes((70, 40, 740, 245), y=(0, 1.03 * top), title=say("mean iterations"), yticks=range(0, top + 1, 4))
    gauge_choice.factor_lines(axes, table, "damping", names)
    axes.set_xlabel(say("weight w"))
    slide.legend(axes, 840, 80)


@FIGURES.figure(1080, 340, "What the prior holds, and the error")
def choice_place(slide, tables, say):
    """What a prior at a wrong value does to the answer, by what it holds."""
    axes = slide.axes((70, 40, 740, 225), title=say("RMSE of the position / that without a prior"))
    gauge_choice.error_lines(axes, tables(GAUGE + "prior_choice"), "perturbed",
                             {place: say(place) for place in ("gauge", "pose 0", "poses 0 and 1")})
    axes.set_xlabel(say("weight w"))
    slide.legend(axes, 840, 80)


@FIGURES.figure(1060, 340, "The uncertainty of the positions in two gauges")
def gauge_sigma(slide, tables, say):
    """Fig. 9: the uncertainty of the positions, in each gauge and transformed into the other."""
    table = tables(GAUGE + "deviations")
    top, last = ceil(100 * table["position_m"].max()), table["keyframe"].max()
    axes = slide.axes((70, 40, 730, 230), (-0.2, last + 0.2), (-0.1, top + 0.1), say("σ of the position [cm]"), say("keyframe"), "",
                      range(int(last) + 1), range(top + 1))
    gauge_covariance.deviation_lines(axes, table, "position_m", {name: say(name) for name in gauge_covariance.GAUGES}, 100)
    slide.legend(axes, 830, 80)


def block_norms(covariance):
    """Norms of its 3×3 blocks."""
    size = len(covariance) // 3
    return np.sqrt((covariance.reshape(size, 3, size, 3)**2).sum(axis=(1, 3)))


@FIGURES.figure(1090, 310, "Covariances in two gauges")
def gauge_covariances(slide, tables, say):
    """Figs. 8 and 10: the keyframes' positions; fixed, free, free transformed, and the difference, all in the same shades."""
    covariances = {name: gauge_covariance.matrix_of(tables(GAUGE + "matrices"), name)
                   for name in ("fixed", "free", "free to fixed")}
    covariances["difference"] = covariances["free to fixed"] - covariances["fixed"]
    norms = {name: block_norms(matrix)[::3, ::3] for name, matrix in covariances.items()}  # position, rotation, velocity
    largest = max(map(np.max, norms.values()))
    for k, (name, matrix) in enumerate(norms.items()):
        slide.cells(10 + 272 * k, 12, 250, np.where(matrix > 1e-2 * largest, matrix, 0), largest, decades=2)
        slide.text(10 + 272 * k + 125, 292, say(name), 18)
        if matrix.max() < 1e-2 * largest:
            slide.text(10 + 272 * k + 125, 142, say("all below 1 %"), 18, MUTED)
