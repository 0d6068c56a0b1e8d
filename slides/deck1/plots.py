"""The deck's plots, drawn from the experiments' tables."""

import numpy as np

from ch5_backend.figures import prior
from ch5_backend.figures.slide import INK, LANDMARK, MUTED, PAPER, POSE, PRIOR, Figures, decades, mix
from ch5_backend.figures.tables import dense

FIGURES = Figures("backend.")


@FIGURES.figure(1130, 450, "The scene from above")
def scene(slide, tables, say):
    """The large scene from above: truth, start and result."""
    truth = mix(INK, 0.22)
    for panel, (state, name, color) in enumerate((("initial", "before.plots", PRIOR), ("final", "after", POSE))):
        axes = slide.axes((70 + 560 * panel, 40, 460, 345), (-12.5, 5.5), (-5, 9.5), say(name), say("x"),
                          xticks=range(-12, 5, 4), yticks=range(-4, 9, 4))
        for table, shade, size in (("mono_ba_points", LANDMARK, 2.2), ("mono_ba_frames", color, 5)):
            for which, of, radius in (("truth", truth, size + 1.2), (state, shade, size)):
                rows = tables(table, scene="large", state=which)
                axes.plot(rows["x_m"], rows["y_m"], "o", color=of, markersize=1.5 * radius, markeredgewidth=0)
    for i, (name, color) in enumerate((("truth", truth), ("cameras", POSE), ("points", LANDMARK))):
        slide.circle(800 + 110 * i, 21, 5, color)
        slide.text(813 + 110 * i, 26, say(name), 16, MUTED, anchor="start")


def hessians(tables):
    """H of the course's scene and its Schur complement, from the solver."""
    return [dense(tables("hessian", scene="course", matrix=name)) for name in "HS"]


@FIGURES.figure(1000, 430, "H and its Schur complement")
def sparsity(slide, tables, say):
    H, S = hessians(tables)
    slide.cells(60, 20, 370, H)
    split = 370 * len(S) / len(H)
    slide.line(60, 20 + split, 430, 20 + split, INK, 1)
    slide.line(60 + split, 20, 60 + split, 390, INK, 1)
    slide.line(480, 205, 545, 205, arrow=True)
    slide.cells(600, 20 + (370 - 300) / 2, 300, S)
    slide.text(245, 420, f"H  {len(H)} × {len(H)}", 18, italic=True)
    slide.text(750, 392, f"S  {len(S)} × {len(S)}", 18, italic=True)


@FIGURES.figure(1100, 400, "Cost and damping per iteration")
def convergence(slide, tables, say):
    """Cost and damping of every iteration, the course's scene."""
    rows = tables("mono_ba_trace", scene="course")
    for panel, (column, color) in enumerate((("cost", POSE), ("lambda", PRIOR))):
        used = rows[column] > 0
        ticks = decades(rows[column][used])
        axes = slide.axes((90 + 540 * panel, 45, 420, 280), (0, rows["iteration"][-1]), ticks[[0, -1]], say(column),
                          say("iteration"), "y", rows["iteration"], ticks)
        axes.plot(rows["iteration"][used], rows[column][used], "o-", color=color, clip_on=False)


@FIGURES.figure(1000, 420, "Eigenvalues of H")
def spectrum(slide, tables, say):
    """Eigenvalues of H with a free gauge and with the smallest prior that holds it."""
    values = {name: np.abs(tables("spectrum", gauge=gauge)["eigenvalue"])
              for name, gauge in (("held", "minimal prior"), ("free", "free"))}
    ticks = decades(np.maximum(np.concatenate(list(values.values())), 1e-12))
    axes = slide.axes((90, 40, 860, 310), (0, len(values["free"])), ticks[[0, -1]], say("eigenvalue"), say("index"), "y",
                      range(0, len(values["free"]) + 1, 5), ticks[::4])
    for name, color, size in (("held", POSE, 6), ("free", PRIOR, 8)):
        axes.plot(np.arange(len(values[name])) + 0.5, values[name], "o", color=color, markersize=size, label=say(name))
    slide.legend(axes, 640, 240)


def variants(say, *names):
    return {name: say(name) for name in names}


@FIGURES.figure(1080, 430, "Iterations against the weight of the prior")
def prior_iterations(slide, tables, say):
    """Mean iterations against the weight, three variants."""
    axes = slide.axes((80, 45, 800, 310), None, None, say("mean"))
    prior.lines(axes, tables("prior_trials"), "mean_iterations", names=variants(say, "course", "perturbed", "minimal"))
    axes.set(ylim=(0, None), xlabel=say("weight"))
    slide.legend(axes, 905, 70)


@FIGURES.figure(1080, 400, "Damping and the weight of the prior")
def prior_damping(slide, tables, say):
    """The course's variant with identity and with diagonal damping."""
    axes = slide.axes((80, 45, 800, 280), None, None, say("iterations"))
    prior.damping_lines(axes, tables("prior_damping"), "iterations", variants(say, "identity", "diagonal"))
    axes.set(ylim=(0, None), xlabel=say("weight"), yticks=range(0, 21, 5))
    slide.legend(axes, 905, 70)


@FIGURES.figure(1130, 420, "What the weight does to the answer")
def prior_answer(slide, tables, say):
    """What the weight does to the answer: reprojection cost and drift, full and minimal priors."""
    for panel, (column, name, limits, log) in enumerate((("reprojection_cost", "reprojection", None, ""),
                                                         ("drift_position", "drift", (1e-12, 1.0), "y"))):
        axes = slide.axes((80 + 560 * panel, 60, 460, 275), None, limits, say(name), "", log)
        prior.lines(axes, tables("prior_sweep"), column, names=variants(say, "perturbed", "minimal"), marks=False)
        axes.set_xlabel(say("weight"))
    slide.legend(axes, 820, 12, columns=2)


def side_view(slide, box, tables, state, color):
    """The course's scene from the side, x to the right and z up: truth in gray, `state` in color."""
    axes = slide.axes(box, (-5.5, 5.5), (-1.2, 9.8))
    axes.set_axis_off()
    for which, shade, size in (("truth", mix(INK, 0.25), 9), (state, LANDMARK, 5.4)):
        rows = tables("mono_ba_points", scene="course", state=which)
        axes.plot(rows["x_m"], rows["z_m"], "o", color=shade, markersize=size, markeredgewidth=0)
    rows = tables("mono_ba_frames", scene="course", state=state)
    axes.plot(rows["x_m"], rows["z_m"] + 0.35, "v", color=mix(color, 0.3), markeredgecolor=color, markersize=15)


@FIGURES.figure(1180, 330, "From a noisy start to a solved bundle adjustment")
def overview(slide, tables, say):
    """The README's picture: start, H, Schur complement, result of the course's scene."""
    H, S = hessians(tables)
    slide.rect(0, 0, 1180, 330, PAPER)
    side_view(slide, (20, 25, 250, 250), tables, "initial", PRIOR)
    slide.cells(330, 40, 220, H)
    slide.cells(645, 40 + (220 - 200) / 2, 200, S)
    side_view(slide, (915, 25, 250, 250), tables, "final", POSE)
    for x in (275, 578, 873):
        slide.line(x, 150, x + 36, 150, arrow=True)
    slide.text(145, 305, say("before.plots"))
    slide.formula(440, 305, r"H = \Sigma\, J^T W J", 17)
    slide.formula(745, 305, r"H_{pp} - H_{pm}\, H_{mm}^{-1} H_{mp}", 17)
    slide.text(1040, 305, say("after"))
