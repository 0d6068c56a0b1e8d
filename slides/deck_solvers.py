"""Deck 2, linear solvers, steps and robust losses: pictures of small computations, and plots of the tables of ch5_solvers."""

from math import cos, pi, sin

import numpy as np

from ch5_backend.figures import prior
from ch5_backend.figures.slide import CROSS, FAINT, INK, LANDMARK, MUTED, POSE, PRIOR, Figures, decades, mix

from .deck_solvers_facts import facts  # noqa: F401
from .toy_graph import ordering, pattern, width

FIGURES = Figures({  # what the tables' words read as
    "none": "M = I", "blocks": "6 × 6 blocks", "nielsen": "Nielsen, the course", "ceres": "without the limit ⅔",
    "tenfold": "Marquardt, ×10 and ÷10", "curve": "curve fitting", "valley": "Rosenbrock's valley", "bundle": "bundle adjustment",
    "gauss-newton": "Gauss-Newton", "levenberg-marquardt": "Levenberg–Marquardt",
    "huber": "Huber", "cauchy": "Cauchy", "tukey": "Tukey", "half_rho": "cost ½ρ", "weight": "weight ρ′",
    "second": "curvature ρ′ + 2ρ″s"})
QUESTIONS = (("eliminate what first?", "Schur complement"), ("factorize or iterate?", "Cholesky, PCG"),
             ("how long a step?", "λ, radius Δ"), ("which direction?", "LM, dogleg"), ("whom to believe?", "robust loss ρ"))
PRECONDITIONERS = {"none": PRIOR, "diagonal": LANDMARK, "blocks": POSE}
RULES = {"nielsen": POSE, "ceres": CROSS, "tenfold": LANDMARK}
STEPS = {"steepest descent": PRIOR, "dogleg": LANDMARK, "Gauss-Newton": POSE}
LOSSES = {"none": PRIOR, "huber": LANDMARK, "cauchy": POSE, "tukey": CROSS}
RESIDUALS = (1e-10, 1e2)


@FIGURES.figure(1130, 190, "Five questions to a solver")
def questions(slide, tables, say):
    """The five decisions of the lecture on their way from H to the next state."""
    for k, (question, answer) in enumerate(QUESTIONS):
        x, shade = 8 + 226 * k, (POSE, POSE, CROSS, CROSS, PRIOR)[k]
        slide.rect(x, 40, 196, 96, mix(shade, 0.16), shade, radius=10, line=1.6)
        slide.text(x + 98, 80, say(question), 17, weight="bold")
        slide.text(x + 98, 112, say(answer), 14.5, MUTED)
        if k:
            slide.line(x - 26, 88, x - 5, 88, arrow=True)


def eliminate(order):
    """Blocks of the Cholesky factor of the toy graph in this order, and which of them are not in H: symbolic."""
    filled = {pair for pair in pattern()}
    place = {vertex: k for k, vertex in enumerate(order)}
    for vertex in order:
        later = [other for other in order if place[other] > place[vertex] and (other, vertex) in filled]
        filled |= {(a, b) for a in later for b in later}
    return filled, filled - set(pattern())


@FIGURES.figure(1130, 380, "The order of elimination")
def order(slide, tables, say):
    """H as an arrow, and its Cholesky factor in both orders: fill-in dashed."""
    poses_first = list(ordering())
    landmarks_first = sorted(poses_first, key=lambda vertex: vertex[0] != "l")
    cell, top = 19, 40
    for panel, (name, sequence) in enumerate((("H", landmarks_first), ("landmarks first", landmarks_first), ("poses first", poses_first))):
        left, start, places = 60 + 370 * panel, 0, {}
        for vertex in sequence:
            places[vertex] = start
            start += width(vertex)
        blocks, fill = eliminate(sequence)
        for a, b in sorted(blocks):
            if panel and places[a] < places[b] or not panel and (a, b) in fill:
                continue
            x, y = left + places[b] * cell, top + places[a] * cell
            shade = PRIOR if panel and (a, b) in fill else POSE if a[0] == b[0] == "p" else LANDMARK if a[0] == b[0] else CROSS
            slide.rect(x + 1, y + 1, width(b) * cell - 2, width(a) * cell - 2, mix(shade, 0.55), radius=3)
        slide.rect(left, top, start * cell, start * cell, stroke=MUTED, radius=3)
        slide.text(left + start * cell / 2, top - 14, say(name), 18)
        if panel:
            count = len(fill & {(a, b) for a, b in blocks if places[a] >= places[b]})
            slide.text(left + start * cell / 2, top + start * cell + 32, f"{say('filled in')}: {count}", 17,
                     PRIOR if count > 3 else MUTED)


# The model of the picture below, m(h) = ½ hᵀHh − bᵀh.
H, B = np.array([[1.0, 0.75], [0.75, 3.0]]), np.array([2.6, 3.4])


def solve(damping):
    return np.linalg.solve(H + damping * np.eye(2), B)


@FIGURES.figure(1040, 400, "Damped steps and the dogleg")
def trust(slide, tables, say):
    """Level lines of the model, the steps of all λ, and the two pieces of the dogleg."""
    ox, oy, unit = 210, 320, 165

    def at(h):
        return ox + unit * h[0], oy - unit * h[1]
    newton = solve(0.0)
    sizes, axes = np.linalg.eigh(H)
    circle = [(cos(t), sin(t)) for t in np.linspace(0, 2 * pi, 121)]
    for level in (0.08, 0.35, 0.9, 1.8, 3.1):
        slide.polyline([at(newton + axes @ (np.sqrt(2 * level / sizes) * point)) for point in circle], FAINT, 1.4)
    radius = 1.15
    slide.circle(ox, oy, radius * unit, "none", mix(PRIOR, 0.7), 1.6)
    path = [solve(10 ** (k / 20)) for k in range(-60, 61)]
    slide.polyline([at(h) for h in [newton, *path, (0, 0)]], CROSS, 3)
    steepest = (B @ B) / (B @ H @ B) * B
    slide.polyline([at((0, 0)), at(steepest), at(newton)], LANDMARK, 3, dash="9 6")
    for h, color in (((0, 0), INK), (steepest, LANDMARK), (newton, POSE)):
        slide.circle(*at(h), 7, color)
    slide.text(ox - 14, oy + 24, say("here"), 17, anchor="end")
    slide.text(at(newton)[0] + 14, at(newton)[1] + 6, say("Gauss-Newton"), 17, POSE, anchor="start")
    slide.text(at(steepest)[0] + 2, at(steepest)[1] - 16, say("steepest descent"), 17, LANDMARK)
    for k, (name, color, dash) in enumerate((("all λ", CROSS, None), ("dogleg", LANDMARK, "9 6"), ("radius Δ", PRIOR, None))):
        slide.line(800, 120 + 34 * k, 836, 120 + 34 * k, color, 3, dash)
        slide.text(848, 126 + 34 * k, say(name), 17, anchor="start")


def residual_axes(slide, say, box, last, step):
    """Of the relative residual against the iteration."""
    return slide.axes(box, (0, last), RESIDUALS, say("relative residual ‖b − Sx‖ / ‖b‖"), say("iteration"), "y", range(0, int(last) + 1, step),
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
    axes = slide.axes((90, 45, 780, 300), (0, count), ticks[[0, -1]], say("eigenvalue"), say("eigenvalue of M⁻¹S, ascending"), "y",
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
    for column, name, color in (("relative_residual", "correct", POSE), ("without_first_step", "first step missing", PRIOR)):
        axes.plot(rows["iteration"], rows[column], color=color, label=say(name))
    slide.legend(axes, 850, 70)


@FIGURES.figure(1080, 400, "Rules for the damping")
def factors(slide, tables, say):
    """What the three rules make of a gain ratio."""
    axes = slide.axes((90, 45, 640, 280), (0, 1.5), (0, 2), say("factor of λ after a success"), say("gain ratio ρ"), "", (0, 0.5, 1, 1.5),
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
            ("step", "‖Δx‖", (1e-4, 1), decades((1e-4, 1)), "xy"), ("gain_ratio", "gain ratio ρ", (0, 1.2), (0, 0.5, 1), "x"))):
        axes = slide.axes((90 + 540 * panel, 60, 430, 260), ticks[[0, -1]], limits, say(name), say("λ / max diag(H)"), log, ticks, marks)
        for prefix, whole, color in (("", "all of H damped", POSE), ("half_damped_", "poses alone damped", PRIOR)):
            axes.plot(rows["relative_lambda"], rows[prefix + column], color=color, label=say(whole))
    slide.legend(axes, 650, 240)


@FIGURES.figure(1080, 410, "Dogleg on a bundle adjustment")
def dogleg(slide, tables, say):
    """The cost of every iteration for several first radii; a dot's color is the kind of the step."""
    rows = tables("solver_dogleg")
    ticks, last = decades(rows["cost"]), int(rows["iteration"].max())
    axes = slide.axes((90, 45, 740, 290), (0, last), ticks[[0, -1]], say("cost"), say("iteration"), "y", range(last + 1), ticks)
    for k, radius in enumerate(np.unique(rows["first_radius"])):
        mine = rows.where(first_radius=radius)
        axes.plot(mine["iteration"], mine["cost"], color=mix(INK, 0.25 + 0.18 * k), linewidth=1.5)
        axes.annotate(f"Δ = {radius:g}", (mine["iteration"][-1], mine["cost"][-1]), (0, -6), textcoords="offset points", color=MUTED,
                      ha="center", va="top")
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
        axes = slide.axes((60 + (wide + 85) * panel, 45, wide, 275), (0, 8), limits, say(column), say("residual r [σ]"), "",
                          range(0, 9, 2), ticks)
        for name, color in LOSSES.items():
            rows = tables("solver_losses", loss=name)
            axes.plot(rows["r"], rows[column], color=color, label=say("least squares" if name == "none" else name))
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
    axes = slide.axes((90, 45, 740, 300), (0, 40), ticks[[0, -1]], say("RMSE of positions, aligned by cameras [m]"), say("outliers [%]"), "y", range(0, 41, 10), ticks)
    for name, color in LOSSES.items():
        rows = tables("solver_outliers", loss=name)
        axes.plot(100 * rows["fraction"], rows["rmse_position_m"], "o-", color=color, clip_on=False,
                  label=say("least squares" if name == "none" else name))
    slide.legend(axes, 860, 80)


@FIGURES.figure(1080, 430, "Iterations against the weight of the prior")
def prior_iterations(slide, tables, say):
    """Mean iterations against the weight, three variants."""
    axes = slide.axes((80, 45, 800, 310), None, None, say("mean iterations"))
    prior.lines(axes, tables("prior_trials"), "mean_iterations", names={name: say(name) for name in ("course", "perturbed", "minimal")})
    axes.set(ylim=(0, None), xlabel=say("weight w"))
    slide.legend(axes, 905, 70)


@FIGURES.figure(1080, 400, "Damping and the weight of the prior")
def prior_damping(slide, tables, say):
    """The course's variant with identity and with diagonal damping."""
    axes = slide.axes((80, 45, 800, 280), None, None, say("iterations"))
    prior.damping_lines(axes, tables("prior_damping"), "iterations", {"identity": "λI", "diagonal": "λ diag(H)"})
    axes.set(ylim=(0, None), xlabel=say("weight w"), yticks=range(0, 21, 5))
    slide.legend(axes, 905, 70)


@FIGURES.figure(1130, 420, "What the weight does to the answer")
def prior_answer(slide, tables, say):
    """What the weight does to the answer: reprojection cost and drift, full and minimal priors."""
    for panel, (column, name, limits, log) in enumerate((("reprojection_cost", "reprojection cost", None, ""),
                                                         ("drift_position", "drift of frame 0 [m]", (1e-12, 1.0), "y"))):
        axes = slide.axes((80 + 560 * panel, 60, 460, 275), None, limits, say(name), "", log)
        prior.lines(axes, tables("prior_sweep"), column, names={name: say(name) for name in ("perturbed", "minimal")}, marks=False)
        axes.set_xlabel(say("weight w"))
    slide.legend(axes, 820, 12, columns=2)
