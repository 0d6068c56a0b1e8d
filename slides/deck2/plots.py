"""Plots of deck 2 about linear solvers, steps and robust losses, from the tables of ch5_solvers."""

import numpy as np

from ch5_backend.figures.slide import CROSS, FAINT, INK, LANDMARK, MUTED, POSE, PRIOR, Figures, decades, mix

FIGURES = Figures("solvers.")
PRECONDITIONERS = {"none": PRIOR, "diagonal": LANDMARK, "blocks": POSE}
RULES = {"nielsen": POSE, "ceres": CROSS, "tenfold": LANDMARK}
STEPS = {"steepest descent": PRIOR, "dogleg": LANDMARK, "Gauss-Newton": POSE}
LOSSES = {"none": PRIOR, "huber": LANDMARK, "cauchy": POSE, "tukey": CROSS}
RESIDUALS = (1e-10, 1e2)


def residual_axes(slide, say, box, last, step):
    """Of the relative residual against the iteration."""
    return slide.axes(box, (0, last), RESIDUALS, say("residual"), say("iteration"), "y", range(0, int(last) + 1, step),
                      decades(RESIDUALS, 2))


@FIGURES.figure(1080, 420, "Conjugate gradients with three preconditioners")
def pcg(slide, tables, say):
    """The residual of every iteration, three preconditioners."""
    axes = residual_axes(slide, say, (90, 45, 780, 300), tables("solver_pcg")["iteration"].max(), 50)
    for name, color in PRECONDITIONERS.items():
        rows = tables("solver_pcg", preconditioner=name)
        axes.plot(rows["iteration"], rows["relative_residual"], color=color, label=say(name))
    slide.legend(axes, 900, 70)


@FIGURES.figure(1080, 420, "Eigenvalues of the preconditioned system")
def conditioning(slide, tables, say):
    """The eigenvalues that conjugate gradients see."""
    count = len(tables("solver_spectrum", preconditioner="none"))
    ticks = decades(tables("solver_spectrum")["eigenvalue"])
    axes = slide.axes((90, 45, 780, 300), (0, count), ticks[[0, -1]], say("eigenvalue"), say("index"), "y",
                      range(0, count + 1, 20), ticks[::3])
    for name, color in PRECONDITIONERS.items():
        axes.plot(np.arange(count) + 0.5, tables("solver_spectrum", preconditioner=name)["eigenvalue"], "o", color=color,
                  label=say(name))
    slide.legend(axes, 900, 70)


@FIGURES.figure(1080, 390, "Conjugate gradients without their first step")
def first_step(slide, tables, say):
    """What is left of the residual if α₀p₀ is never added."""
    rows = tables("solver_pcg", preconditioner="blocks")
    axes = residual_axes(slide, say, (90, 45, 740, 270), rows["iteration"][-1], 10)
    for column, name, color in (("relative_residual", "full", POSE), ("without_first_step", "missing", PRIOR)):
        axes.plot(rows["iteration"], rows[column], color=color, label=say(name))
    slide.legend(axes, 850, 70)


@FIGURES.figure(1080, 400, "Rules for the damping")
def factors(slide, tables, say):
    """What the three rules make of a gain ratio."""
    axes = slide.axes((90, 45, 640, 280), (0, 1.5), (0, 2), say("factor"), say("rho"), "", (0, 0.5, 1, 1.5),
                      (0, 0.5, 1, 1.5, 2))
    rho = np.linspace(0, 1.5, 151)
    cubic = np.maximum(1 / 3, 1 - (2 * rho - 1) ** 3)
    for name, values in (("nielsen", np.minimum(2 / 3, cubic)), ("ceres", cubic), ("tenfold", 0.1 + 0 * rho)):
        axes.plot(rho, values, color=RULES[name], label=say(name), zorder=2.5 if name == "nielsen" else 2)
    slide.legend(axes, 760, 80)


@FIGURES.figure(1130, 285, "Rules for the damping on three problems")
def rules(slide, tables, say):
    """The cost after every trial, three rules on three problems."""
    for panel, problem in enumerate(("curve", "valley", "bundle")):
        every = tables("solver_rules", problem=problem)
        first, last = every["cost"][0], every["trial"].max()
        axes = slide.axes((75 + 375 * panel, 75, 290, 145), (0, last), (1e-9 * first, first), say(problem), say("trial"), "y",
                          range(0, int(last) + 1, 10), decades((1e-9 * first, first), 3))
        axes.set_ylim(1e-9 * first, first)
        for name, color in RULES.items():
            rows = every.where(rule=name)
            axes.plot(rows["trial"], np.maximum(rows["cost"] - every["cost"].min(), 1e-9 * first), color=color,
                      linestyle=(0, (3, 2)) if name == "ceres" else "-", label=say(name))
    slide.legend(axes, 90, 12, columns=3)


@FIGURES.figure(1130, 400, "Damping without the landmarks")
def half_damped(slide, tables, say):
    """Step and gain ratio against λ: all of H damped, and the poses alone."""
    rows = tables("solver_half_damped")
    ticks = decades(rows["relative_lambda"], 2)
    for panel, (column, name, limits, marks, log) in enumerate((
            ("step", "step", (1e-4, 1), decades((1e-4, 1)), "xy"), ("gain_ratio", "rho", (0, 1.2), (0, 0.5, 1), "x"))):
        axes = slide.axes((90 + 540 * panel, 60, 430, 260), ticks[[0, -1]], limits, say(name), say("lambda"), log, ticks, marks)
        for prefix, whole, color in (("", "whole", POSE), ("half_damped_", "half", PRIOR)):
            axes.plot(rows["relative_lambda"], rows[prefix + column], color=color, label=say(whole))
    slide.legend(axes, 330, 12, columns=2)


@FIGURES.figure(1080, 410, "Dogleg on a bundle adjustment")
def dogleg(slide, tables, say):
    """The cost of every iteration for several first radii; a dot's color is the kind of the step."""
    rows = tables("solver_dogleg")
    ticks, last = decades(rows["cost"]), int(rows["iteration"].max())
    axes = slide.axes((90, 45, 740, 290), (0, last), ticks[[0, -1]], say("cost"), say("iteration"), "y", range(last + 1), ticks)
    for k, radius in enumerate(np.unique(rows["first_radius"])):
        mine = rows.where(first_radius=radius)
        axes.plot(mine["iteration"], mine["cost"], color=mix(INK, 0.25 + 0.18 * k), linewidth=1.5)
        axes.annotate(f"Δ = {radius:g}", (3, mine["cost"][3]), (9, 4.5), textcoords="offset points", color=MUTED)
    for name, color in STEPS.items():
        taken = rows.where(step=name)
        after = taken["iteration"] > 0
        axes.plot(taken["iteration"][after], taken["cost"][after], "o", color=color, markersize=9, label=say(name), clip_on=False)
    slide.legend(axes, 852, 80)


@FIGURES.figure(1130, 430, "Through Rosenbrock's valley")
def paths(slide, tables, say):
    """Three ways through Rosenbrock's valley, over its level lines."""
    for panel, (name, color) in enumerate((("gauss-newton", PRIOR), ("levenberg-marquardt", POSE), ("dogleg", LANDMARK))):
        x, y = (-1.6, 1.4), (-4.0, 1.6) if panel == 0 else (-0.4, 1.6)
        axes = slide.axes((55 + 375 * panel, 60, 315, 320), x, y, xticks=(), yticks=())
        axes.spines[:].set_visible(True)
        at = np.meshgrid(np.linspace(*x, 301), np.linspace(*y, 1201))
        axes.contour(*at, (10 * (at[1] - at[0]**2))**2 + (1 - at[0])**2, (0.1, 1.0, 4.0, 10.0), colors=FAINT, linewidths=1)
        rows = tables("solver_paths", algorithm=name)
        axes.plot(rows["x"], rows["y"], "o-", color=color, linewidth=1.5)
        axes.plot(1, 1, "o", color=INK, markerfacecolor="none", markersize=12, markeredgewidth=1.5)
        slide.text(212 + 375 * panel, 40, say(name), 18, color)
        slide.text(212 + 375 * panel, 412, f"{len(rows) - 1} {say('steps')}", 17, MUTED)


def curves(slide, tables, say, panels):
    """One panel a column: (column, range of y, ticks)."""
    wide = 900 / len(panels) - 70
    for panel, (column, limits, ticks) in enumerate(panels):
        axes = slide.axes((60 + (wide + 85) * panel, 45, wide, 275), (0, 8), limits, say(column), say("r"), "",
                          range(0, 9, 2), ticks)
        for name, color in LOSSES.items():
            rows = tables("solver_losses", loss=name)
            axes.plot(rows["r"], rows[column], color=color, label=say("none.losses" if name == "none" else name))
    slide.legend(axes, 960, 90)


@FIGURES.figure(1130, 400, "Robust losses")
def losses(slide, tables, say):
    curves(slide, tables, say, (("half_rho", (0, 12), (0, 4, 8, 12)), ("weight", (0, 1.05), (0, 0.5, 1))))


@FIGURES.figure(1130, 400, "The second derivative of a loss")
def curvature(slide, tables, say):
    curves(slide, tables, say, (("second", (-0.85, 1.05), (-0.5, 0, 0.5, 1)),))


@FIGURES.figure(1080, 420, "Bundle adjustment with outliers")
def outliers(slide, tables, say):
    """The error against the fraction of outliers."""
    ticks = decades(tables("solver_outliers")["rmse_position_m"])
    axes = slide.axes((90, 45, 740, 300), (0, 40), ticks[[0, -1]], say("error"), say("fraction"), "y", range(0, 41, 10), ticks)
    for name, color in LOSSES.items():
        rows = tables("solver_outliers", loss=name)
        axes.plot(100 * rows["fraction"], rows["rmse_position_m"], "o-", color=color, clip_on=False,
                  label=say("none.losses" if name == "none" else name))
    slide.legend(axes, 860, 80)
