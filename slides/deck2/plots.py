"""Plots of deck 2 about linear solvers and steps, from the tables of ch5_solvers."""

from ..chart import Axes, decades, legend
from ..svg import CROSS, FAINT, INK, LANDMARK, MUTED, POSE, PRIOR, Svg, mix

WORDS = {
    "en": {"iteration": "iteration", "trial": "trial", "residual": "relative residual ‖b − Sx‖ / ‖b‖", "none": "M = I",
           "diagonal": "diagonal", "blocks": "6 × 6 blocks", "index": "eigenvalue of M⁻¹S, ascending", "eigenvalue": "eigenvalue",
           "full": "correct", "missing": "first step missing", "factor": "factor of λ after a success", "rho": "gain ratio ρ",
           "nielsen": "Nielsen, the course", "ceres": "without the limit ⅔", "tenfold": "Marquardt, ×10 and ÷10",
           "curve": "curve fitting", "valley": "Rosenbrock's valley", "bundle": "bundle adjustment", "cost": "cost",
           "lambda": "λ / max diag(H)", "step": "‖Δx‖", "whole": "all of H damped", "half": "poses alone damped", "radius": "first radius",
           "newton": "Gauss–Newton", "dogleg": "dogleg", "steepest descent": "steepest descent", "Gauss-Newton": "Gauss–Newton",
           "gauss-newton": "Gauss–Newton", "levenberg-marquardt": "Levenberg–Marquardt", "steps": "steps", "x": "x", "y": "y"},
    "zh": {"iteration": "迭代", "trial": "试步", "residual": "相对残差 ‖b − Sx‖ / ‖b‖", "none": "M = I", "diagonal": "对角",
           "blocks": "6 × 6 块", "index": "M⁻¹S 的特征值（升序）", "eigenvalue": "特征值", "full": "正确", "missing": "漏了第一步",
           "factor": "成功后 λ 乘以的因子", "rho": "增益比 ρ", "nielsen": "Nielsen（课程）", "ceres": "去掉上限 ⅔",
           "tenfold": "Marquardt：×10、÷10", "curve": "曲线拟合", "valley": "Rosenbrock 山谷", "bundle": "光束法平差", "cost": "代价",
           "lambda": "λ / max diag(H)", "step": "‖Δx‖", "whole": "阻尼整个 H", "half": "只阻尼位姿", "radius": "初始半径",
           "newton": "高斯–牛顿", "dogleg": "dogleg", "steepest descent": "最速下降", "Gauss-Newton": "高斯–牛顿",
           "gauss-newton": "高斯–牛顿", "levenberg-marquardt": "LM", "steps": "步", "x": "x", "y": "y"},
}
PRECONDITIONERS = {"none": PRIOR, "diagonal": LANDMARK, "blocks": POSE}
RULES = {"nielsen": POSE, "ceres": CROSS, "tenfold": LANDMARK}
STEPS = {"steepest descent": PRIOR, "dogleg": LANDMARK, "Gauss-Newton": POSE}


def pcg(tables, lang):
    """The residual of every iteration, three preconditioners."""
    words = WORDS[lang]
    svg = Svg(1080, 420, "Conjugate gradients with three preconditioners")
    last = max(tables.column("solver_pcg", "iteration"))
    axes = Axes(svg, (90, 45, 780, 300), (0, last), (1e-10, 1e2), log_y=True)
    axes.draw(words["iteration"], words["residual"], range(0, int(last) + 1, 50), decades((1e-10, 1e2), 2))
    for name, colour in PRECONDITIONERS.items():
        axes.curve(tables.column("solver_pcg", "iteration", preconditioner=name),
                   tables.column("solver_pcg", "relative_residual", preconditioner=name), colour, dots=False)
    legend(svg, 900, 80, [(words[name], colour, None) for name, colour in PRECONDITIONERS.items()])
    return svg.render()


def conditioning(tables, lang):
    """The eigenvalues that conjugate gradients see."""
    words = WORDS[lang]
    svg = Svg(1080, 420, "Eigenvalues of the preconditioned system")
    count = len(tables.rows("solver_spectrum", preconditioner="none"))
    ticks = decades(tables.column("solver_spectrum", "eigenvalue"))
    axes = Axes(svg, (90, 45, 780, 300), (0, count), (ticks[0], ticks[-1]), log_y=True)
    axes.draw(words["index"], words["eigenvalue"], range(0, count + 1, 20), ticks[::3])
    for name, colour in PRECONDITIONERS.items():
        for i, value in enumerate(tables.column("solver_spectrum", "eigenvalue", preconditioner=name)):
            svg.circle(axes.x(i + 0.5), axes.y(value), 3.6, colour)
    legend(svg, 900, 80, [(words[name], colour, None) for name, colour in PRECONDITIONERS.items()])
    return svg.render()


def first_step(tables, lang):
    """What is left of the residual if α₀p₀ is never added."""
    words = WORDS[lang]
    svg = Svg(1080, 390, "Conjugate gradients without their first step")
    rows = tables.rows("solver_pcg", preconditioner="blocks")
    axes = Axes(svg, (90, 45, 740, 270), (0, rows[-1]["iteration"]), (1e-10, 1e2), log_y=True)
    axes.draw(words["iteration"], words["residual"], range(0, int(rows[-1]["iteration"]) + 1, 10), decades((1e-10, 1e2), 2))
    for column, name, colour in (("relative_residual", "full", POSE), ("without_first_step", "missing", PRIOR)):
        axes.curve([r["iteration"] for r in rows], [r[column] for r in rows], colour, dots=False, width=3)
    legend(svg, 850, 80, [(words["full"], POSE, None), (words["missing"], PRIOR, None)])
    return svg.render()


def factors(_, lang):
    """What the three rules make of a gain ratio."""
    words = WORDS[lang]
    svg = Svg(1080, 400, "Rules for the damping")
    axes = Axes(svg, (90, 45, 640, 280), (0, 1.5), (0, 2))
    axes.draw(words["rho"], words["factor"], (0, 0.5, 1, 1.5), (0, 0.5, 1, 1.5, 2))
    rho = [k / 100 for k in range(0, 151)]
    cubic = [max(1 / 3, 1 - (2 * r - 1) ** 3) for r in rho]
    axes.curve(rho, cubic, RULES["ceres"], dots=False)
    axes.curve(rho, [min(2 / 3, f) for f in cubic], RULES["nielsen"], dots=False, width=3.4)
    axes.curve(rho, [0.1 for _ in rho], RULES["tenfold"], dots=False)
    legend(svg, 760, 90, [(words[name], colour, None) for name, colour in RULES.items()], gap=34)
    return svg.render()


def rules(tables, lang):
    """The cost after every trial, three rules on three problems."""
    words = WORDS[lang]
    svg = Svg(1130, 285, "Rules for the damping on three problems")
    for panel, problem in enumerate(("curve", "valley", "bundle")):
        last = max(tables.column("solver_rules", "trial", problem=problem))
        best = min(tables.column("solver_rules", "cost", problem=problem))
        first = tables.rows("solver_rules", problem=problem)[0]["cost"]
        low = 1e-9 * first
        axes = Axes(svg, (75 + 375 * panel, 75, 290, 145), (0, last), (low, first), log_y=True)
        axes.draw(words["trial"], words[problem], range(0, int(last) + 1, 10), decades((low, first), 3))
        for name, colour in RULES.items():
            rows = tables.rows("solver_rules", problem=problem, rule=name)
            axes.curve([r["trial"] for r in rows], [max(r["cost"] - best, low) for r in rows], colour, dots=False,
                       dash="7 5" if name == "ceres" else None)
    for k, (name, colour) in enumerate(RULES.items()):
        svg.line(90 + 350 * k, 20, 122 + 350 * k, 20, colour, 3, "7 5" if name == "ceres" else None)
        svg.text(132 + 350 * k, 26, words[name], 16, anchor="start")
    return svg.render()


def half_damped(tables, lang):
    """Step and gain ratio against λ: all of H damped, and the poses alone."""
    words = WORDS[lang]
    svg = Svg(1130, 400, "Damping without the landmarks")
    rows = tables.rows("solver_half_damped")
    xs = [row["relative_lambda"] for row in rows]
    ticks = decades(xs, 2)
    for panel, (columns, name, y_range) in enumerate(((("step", "half_damped_step"), "step", (1e-4, 1)),
                                                     (("gain_ratio", "half_damped_gain_ratio"), "rho", (0, 1.2)))):
        axes = Axes(svg, (90 + 540 * panel, 60, 430, 260), (ticks[0], ticks[-1]), y_range, log_x=True, log_y=panel == 0)
        axes.draw(words["lambda"], words[name], ticks, decades(y_range) if panel == 0 else (0, 0.5, 1))
        for column, colour in zip(columns, (POSE, PRIOR)):
            axes.curve(xs, [row[column] for row in rows], colour, dots=False, width=3)
    for k, (name, colour) in enumerate((("whole", POSE), ("half", PRIOR))):
        svg.line(330 + 270 * k, 20, 362 + 270 * k, 20, colour, 3)
        svg.text(372 + 270 * k, 26, words[name], 16, anchor="start")
    return svg.render()


def dogleg(tables, lang):
    """The cost of every iteration for several first radii; a dot's colour is the kind of the step."""
    words = WORDS[lang]
    svg = Svg(1080, 410, "Dogleg on a bundle adjustment")
    rows = tables.rows("solver_dogleg")
    costs = [row["cost"] for row in rows]
    ticks, last = decades(costs), int(max(row["iteration"] for row in rows))
    axes = Axes(svg, (90, 45, 740, 290), (0, last), (ticks[0], ticks[-1]), log_y=True)
    axes.draw(words["iteration"], words["cost"], range(last + 1), ticks)
    for k, radius in enumerate(sorted({row["first_radius"] for row in rows})):
        mine = tables.rows("solver_dogleg", first_radius=radius)
        axes.curve([r["iteration"] for r in mine], [r["cost"] for r in mine], mix(INK, 0.25 + 0.18 * k), dots=False, width=2)
        for row in mine[1:]:
            svg.circle(axes.x(row["iteration"]), axes.y(row["cost"]), 6, STEPS[row["step"]])
        third = mine[3]  # where the curves lie apart
        svg.text(axes.x(3) + 12, axes.y(third["cost"]) - 6, f"Δ = {radius:g}", 15, MUTED, anchor="start")
    for k, (name, colour) in enumerate(STEPS.items()):
        svg.circle(862, 90 + 34 * k, 6, colour)
        svg.text(880, 96 + 34 * k, words[name], 16, anchor="start")
    return svg.render()


def paths(tables, lang):
    """Three ways through Rosenbrock's valley, over its level lines."""
    words = WORDS[lang]
    svg = Svg(1130, 430, "Through Rosenbrock's valley")
    for panel, (name, colour) in enumerate((("gauss-newton", PRIOR), ("levenberg-marquardt", POSE), ("dogleg", LANDMARK))):
        axes = Axes(svg, (55 + 375 * panel, 60, 315, 320), (-1.6, 1.4), (-4.0, 1.6) if panel == 0 else (-0.4, 1.6))
        rows = tables.rows("solver_paths", algorithm=name)
        for level in (0.05, 0.5, 2.0, 5.0):  # (10 (y − x²))² + (1 − x)² = 2·level
            size = (2 * level) ** 0.5
            for sign in (1, -1):
                points = []
                for k in range(121):
                    x = 1 - size + 2 * size * k / 120
                    y = x * x + sign * max(0.0, 2 * level - (1 - x) ** 2) ** 0.5 / 10
                    if axes.x0 <= x <= axes.x1 and axes.y0 <= y <= axes.y1:
                        points.append((axes.x(x), axes.y(y)))
                if len(points) > 1:
                    svg.polyline(points, FAINT, 1.3)
        svg.polyline([(axes.x(r["x"]), axes.y(r["y"])) for r in rows], colour, 2)
        for row in rows:
            svg.circle(axes.x(row["x"]), axes.y(row["y"]), 4.5, colour)
        svg.circle(axes.x(1), axes.y(1), 8, "none", INK, 2)
        svg.rect(axes.left, axes.top, axes.width, axes.height, stroke=MUTED)
        svg.text(axes.left + axes.width / 2, 40, words[name], 18, colour)
        svg.text(axes.left + axes.width / 2, 412, f"{len(rows) - 1} {words['steps']}", 17, MUTED)
    return svg.render()


ALL = {"pcg": pcg, "conditioning": conditioning, "first_step": first_step, "factors": factors, "rules": rules,
       "half_damped": half_damped, "dogleg": dogleg, "paths": paths}
