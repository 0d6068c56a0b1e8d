"""The deck's plots, drawn from the experiments' tables."""

from math import ceil, floor, log10

from ..chart import Axes, decades, legend
from ..svg import CROSS, INK, LANDMARK, MUTED, POSE, PRIOR, Svg, mix, number

WORDS = {
    "en": {"weight": "weight w", "iterations": "iterations", "iteration": "iteration", "cost": "cost", "x": "x [m]",
           "y": "y [m]", "course": "course", "perturbed": "perturbed", "minimal": "minimal", "truth": "truth",
           "before": "start", "after": "result, aligned", "index": "eigenvalue, ascending", "eigenvalue": "|eigenvalue|",
           "free": "gauge free", "held": "pose 0 and scale held", "reprojection": "reprojection cost",
           "drift": "drift of frame 0 [m]", "identity": "λI", "diagonal": "λ diag(H)", "mean": "mean iterations",
           "rmse": "RMSE of positions [mm], aligned", "cameras": "cameras", "points": "points", "lambda": "λ"},
    "zh": {"weight": "权重 w", "iterations": "迭代次数", "iteration": "迭代", "cost": "代价", "x": "x [m]", "y": "y [m]",
           "course": "课程", "perturbed": "有扰动", "minimal": "最小规范", "truth": "真值", "before": "初值",
           "after": "结果（已对齐）", "index": "特征值（升序）", "eigenvalue": "|特征值|", "free": "规范自由",
           "held": "固定位姿 0 与尺度", "reprojection": "重投影代价", "drift": "第 0 帧漂移 [m]", "identity": "λI",
           "diagonal": "λ diag(H)", "mean": "平均迭代次数", "rmse": "对齐后的位置 RMSE [mm]", "cameras": "相机",
           "points": "路标点", "lambda": "λ"},
}
COLOURS = {"course": LANDMARK, "perturbed": POSE, "minimal": CROSS, "identity": LANDMARK, "diagonal": CROSS,
           "free": PRIOR, "held": POSE}


WEIGHT_TICKS = [0, 1e-3, 1, 1e3, 1e6, 1e9]


def weight_axes(svg, box, y_range, log_y=False):
    return Axes(svg, box, (1e-3, 1e10), y_range, log_x=True, log_y=log_y, zero=True)


def scene(tables, lang):
    """The large scene from above: truth, start and result."""
    words = WORDS[lang]
    svg = Svg(1130, 450, "The scene from above")
    data = {state: (tables.rows("mono_ba_frames", scene="large", state=state),
                    tables.rows("mono_ba_points", scene="large", state=state)) for state in ("truth", "initial", "final")}
    for panel, (state, name, colour) in enumerate((("initial", "before", PRIOR), ("final", "after", POSE))):
        axes = Axes(svg, (70 + 560 * panel, 40, 460, 345), (-12.5, 5.5), (-5, 9.5))
        axes.draw(words["x"], words[name], range(-12, 5, 4), range(-4, 9, 4))
        for kind, radius in ((1, 2.2), (0, 5)):
            for row in data["truth"][kind]:
                if not inside(axes, row):
                    continue
                svg.circle(axes.x(row["x_m"]), axes.y(row["y_m"]), radius + 1.2, mix(INK, 0.22))
            for row in data[state][kind]:
                if inside(axes, row):
                    svg.circle(axes.x(row["x_m"]), axes.y(row["y_m"]), radius, colour if kind == 0 else LANDMARK)
    for i, (name, colour) in enumerate((("truth", mix(INK, 0.22)), ("cameras", POSE), ("points", LANDMARK))):
        svg.circle(800 + 110 * i, 21, 5, colour)
        svg.text(813 + 110 * i, 26, words[name], 16, MUTED, anchor="start")
    return svg.render()


def inside(axes, row):
    return axes.x0 <= row["x_m"] <= axes.x1 and axes.y0 <= row["y_m"] <= axes.y1


def cells(svg, x, y, side, matrix, size, shades=8):
    """A matrix as a field of squares, darker where log|value| is larger; one path a shade keeps the file small."""
    largest = max(abs(v) for v in matrix.values())
    unit, fields = side / size, {}
    for (row, column), value in sorted(matrix.items()):
        depth = max(0.0, 1.0 + log10(abs(value) / largest) / 9.0)
        fields.setdefault(round(shades * depth), []).append((row, column))
    square = f"h{number(unit * 0.94)}v{number(unit * 0.94)}h-{number(unit * 0.94)}z"
    for shade, places in sorted(fields.items()):
        svg.path("".join(f"M{number(x + c * unit)} {number(y + r * unit)}{square}" for r, c in places), stroke=None,
                 width=None, fill=mix(POSE, 0.18 + 0.82 * shade / shades))
    svg.rect(x, y, side, side, stroke=MUTED, stroke_width=1)


def sparsity(tables, lang):
    """H of the course's scene and its Schur complement, from the solver."""
    svg = Svg(1000, 430, "H and its Schur complement")
    H, S = (tables.matrix("hessian", scene="course", matrix=name) for name in "HS")
    sizes = [1 + max(row for row, _ in matrix) for matrix in (H, S)]
    cells(svg, 60, 20, 370, H, sizes[0])
    split = 370 * sizes[1] / sizes[0]
    svg.line(60, 20 + split, 430, 20 + split, INK, 1)
    svg.line(60 + split, 20, 60 + split, 390, INK, 1)
    svg.line(480, 205, 545, 205, arrow=True)
    cells(svg, 600, 20 + (370 - 300) / 2, 300, S, sizes[1])
    svg.text(245, 420, f"H  {sizes[0]} × {sizes[0]}", 18, italic=True)
    svg.text(750, 392, f"S  {sizes[1]} × {sizes[1]}", 18, italic=True)
    return svg.render()


def convergence(tables, lang):
    """Cost and damping of every iteration, the course's scene."""
    words = WORDS[lang]
    svg = Svg(1100, 400, "Cost and damping per iteration")
    rows = tables.rows("mono_ba_trace", scene="course")
    for panel, (column, name, colour) in enumerate((("cost", "cost", POSE), ("lambda", "lambda", PRIOR))):
        used = [row for row in rows if row[column] > 0]
        values = [row[column] for row in used]
        ticks = decades(values)
        axes = Axes(svg, (90 + 540 * panel, 45, 420, 280), (0, rows[-1]["iteration"]), (ticks[0], ticks[-1]), log_y=True)
        axes.draw(words["iteration"], words[name], range(int(rows[-1]["iteration"]) + 1), ticks)
        axes.curve([row["iteration"] for row in used], values, colour)
    return svg.render()


def spectrum(tables, lang):
    """Eigenvalues of H with a free gauge and with the smallest prior that holds it."""
    words = WORDS[lang]
    svg = Svg(1000, 420, "Eigenvalues of H")
    free = tables.column("spectrum", "eigenvalue", gauge="free")
    held = tables.column("spectrum", "eigenvalue", gauge="minimal prior")
    sizes = [max(abs(v), 1e-12) for v in free + held]
    ticks = decades(sizes)
    axes = Axes(svg, (90, 40, 860, 310), (0, len(free)), (ticks[0], ticks[-1]), log_y=True)
    axes.draw(words["index"], words["eigenvalue"], range(0, len(free) + 1, 5), ticks[::4])
    for values, name in ((held, "held"), (free, "free")):
        for i, value in enumerate(values):
            axes.svg.circle(axes.x(i + 0.5), axes.y(abs(value)), 5.5 if name == "free" else 4, COLOURS[name])
    for i, name in enumerate(("free", "held")):
        svg.circle(640, 250 + 30 * i, 5.5, COLOURS[name])
        svg.text(656, 256 + 30 * i, words[name], 17, anchor="start")
    return svg.render()


def prior_iterations(tables, lang):
    """Mean iterations against the weight, three variants."""
    words = WORDS[lang]
    svg = Svg(1080, 430, "Iterations against the weight of the prior")
    top = max(tables.column("prior_trials", "mean_iterations"))
    axes = weight_axes(svg, (80, 45, 800, 310), (0, 5 * ceil(top / 5)))
    axes.draw(words["weight"], words["mean"], WEIGHT_TICKS, range(0, 5 * ceil(top / 5) + 1, 5))
    for name in ("course", "perturbed", "minimal"):
        axes.curve(tables.column("prior_trials", "weight", variant=name),
                   tables.column("prior_trials", "mean_iterations", variant=name), COLOURS[name])
    legend(svg, 905, 80, [(words[name], COLOURS[name], None) for name in ("course", "perturbed", "minimal")])
    return svg.render()


def prior_damping(tables, lang):
    """The course's variant with identity and with diagonal damping."""
    words = WORDS[lang]
    svg = Svg(1080, 400, "Damping and the weight of the prior")
    top = max(tables.column("prior_damping", "iterations"))
    axes = weight_axes(svg, (80, 45, 800, 280), (0, 5 * ceil(top / 5)))
    axes.draw(words["weight"], words["iterations"], WEIGHT_TICKS, range(0, 5 * ceil(top / 5) + 1, 5))
    for name in ("identity", "diagonal"):
        axes.curve(tables.column("prior_damping", "weight", damping=name),
                   tables.column("prior_damping", "iterations", damping=name), COLOURS[name])
    legend(svg, 905, 80, [(words[name], COLOURS[name], None) for name in ("identity", "diagonal")])
    return svg.render()


def prior_answer(tables, lang):
    """What the weight does to the answer: reprojection cost and drift, full and minimal priors."""
    words = WORDS[lang]
    svg = Svg(1130, 420, "What the weight does to the answer")
    left = tables.rows("prior_sweep", variant="perturbed") + tables.rows("prior_sweep", variant="minimal")
    costs = [row["reprojection_cost"] for row in left]
    panels = (("reprojection_cost", "reprojection", (5 * floor(min(costs) / 5), 5 * ceil(max(costs) / 5)), False),
              ("drift_position", "drift", (1e-12, 1.0), True))
    for panel, (column, name, y_range, log_y) in enumerate(panels):
        axes = weight_axes(svg, (80 + 560 * panel, 45, 460, 290), y_range, log_y)
        ticks = decades(y_range, 3) if log_y else range(y_range[0], y_range[1] + 1, 5)
        axes.draw(words["weight"], words[name], WEIGHT_TICKS, ticks)
        for variant in ("perturbed", "minimal"):
            axes.curve(tables.column("prior_sweep", "weight", variant=variant),
                       tables.column("prior_sweep", column, variant=variant), COLOURS[variant], dots=False)
    for i, variant in enumerate(("perturbed", "minimal")):
        svg.line(820 + 150 * i, 20, 850 + 150 * i, 20, COLOURS[variant], 3)
        svg.text(860 + 150 * i, 26, words[variant], 16, anchor="start")
    return svg.render()


def side_view(svg, box, tables, state, colour):
    """The course's scene from the side, x to the right and z up: truth in grey, `state` in colour."""
    axes = Axes(svg, box, (-5.5, 5.5), (-1.2, 9.8))
    for which, shade, radius in (("truth", mix(INK, 0.25), 6), (state, LANDMARK, 3.6)):
        for row in tables.rows("mono_ba_points", scene="course", state=which):
            svg.circle(axes.x(row["x_m"]), axes.y(row["z_m"]), radius, shade)
    for row in tables.rows("mono_ba_frames", scene="course", state=state):
        x, y = axes.x(row["x_m"]), axes.y(row["z_m"])
        svg.path(f"M{number(x)} {number(y)} l-11 -17 h22 z", colour, 1.6, mix(colour, 0.3))


def overview(tables, lang):
    """The README's picture: start, H, Schur complement, result of the course's scene."""
    words = WORDS[lang]
    svg = Svg(1180, 330, "From a noisy start to a solved bundle adjustment")
    svg.rect(0, 0, 1180, 330, "#ffffff", radius=10)
    H, S = (tables.matrix("hessian", scene="course", matrix=name) for name in "HS")
    sizes = [1 + max(row for row, _ in matrix) for matrix in (H, S)]
    side_view(svg, (20, 25, 250, 250), tables, "initial", PRIOR)
    cells(svg, 330, 40, 220, H, sizes[0])
    cells(svg, 645, 40 + (220 - 200) / 2, 200, S, sizes[1])
    side_view(svg, (915, 25, 250, 250), tables, "final", POSE)
    for x in (275, 578, 873):
        svg.line(x, 150, x + 36, 150, arrow=True)
    for x, name in ((145, words["before"]), (440, "H = Σ JᵀWJ"), (745, "Hₚₚ − Hₚₘ Hₘₘ⁻¹ Hₘₚ"), (1040, words["after"])):
        svg.text(x, 305, name, 18)
    return svg.render()


ALL = {"overview": overview, "scene": scene, "sparsity": sparsity, "convergence": convergence, "spectrum": spectrum,
       "prior_iterations": prior_iterations, "prior_damping": prior_damping, "prior_answer": prior_answer}
