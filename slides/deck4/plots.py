"""The deck's plots, drawn from the tables of ./course plots gauge; what the paper reports stands beside them."""

from math import ceil, log10, sqrt

from ch5_backend.figures import gauge_paper
from ..chart import Axes, decades, legend
from ..svg import CROSS, FAINT, INK, LANDMARK, MUTED, PAPER, POSE, PRIOR, Svg, mix, number

WORDS = {
    "en": {"camera and IMU": "camera and IMU", "camera alone": "camera alone", "index": "eigenvalue, ascending",
           "relative": "|λ| / largest", "fixation": "fixation", "free": "free", "prior": "prior, w = 10⁵",
           "paper": "the paper", "iterations": "mean iterations", "weight": "weight w", "iteration": "iteration",
           "pixels": "reprojection error [px]", "distance": "prior error [m, rad]", "keyframe": "keyframe",
           "sigma": "σ of the position [cm]", "fixed": "fixed", "fixed to free": "fixed, transformed",
           "free to fixed": "free, transformed", "identity": "λ I (the course)", "diagonal": "λ diag(H)",
           "radius": "radius (Dogleg)", "ratio": "RMSE of the position / that without a prior", "gauge": "gauge: 4",
           "pose 0": "pose 0: 6", "poses 0 and 1": "poses 0 and 1: 12", "difference": "difference",
           "sine": "sine", "arc": "arc", "rec": "rectangle", "planes": "planes", "random": "random"},
    "zh": {"camera and IMU": "相机加 IMU", "camera alone": "只有相机", "index": "特征值（升序）",
           "relative": "|λ| / 最大值", "fixation": "固定", "free": "自由", "prior": "先验，w = 10⁵",
           "paper": "论文", "iterations": "平均迭代次数", "weight": "权重 w", "iteration": "迭代",
           "pixels": "重投影误差 [px]", "distance": "先验误差 [m, rad]", "keyframe": "关键帧",
           "sigma": "位置的 σ [cm]", "fixed": "固定", "fixed to free": "固定，变换后",
           "free to fixed": "自由，变换后", "identity": "λ I（课程）", "diagonal": "λ diag(H)",
           "radius": "信赖域半径（Dogleg）", "ratio": "位置 RMSE / 无先验时的 RMSE", "gauge": "规范：4",
           "pose 0": "位姿 0：6", "poses 0 and 1": "位姿 0 和 1：12", "difference": "差",
           "sine": "正弦", "arc": "圆弧", "rec": "矩形", "planes": "平面", "random": "随机"},
}
METHODS = {"fixation": POSE, "free": CROSS, "prior": PRIOR}
DAMPINGS = {"identity": LANDMARK, "diagonal": CROSS, "radius": POSE}
PLACES = {"gauge": CROSS, "pose 0": LANDMARK, "poses 0 and 1": PRIOR}
ZERO = 1e-8  # of the largest eigenvalue: below, it is rounding


def table(name):
    return f"../gauge/csv/{name}"


def mean(values):
    return sum(values) / len(values)


def relative_spectrum(tables, problem):
    """|λ| / λ_max, ascending; what rounds to 0 has a place at 1e-20."""
    values = tables.column(table("spectrum"), "eigenvalue", problem=problem)
    return sorted(max(abs(value) / max(values), 1e-20) for value in values)


def over_weight(tables, name, column, **where):
    """Weights, and the mean of the column over the trials at each."""
    found = {}
    for row in tables.rows(table(name), **where):
        found.setdefault(row["weight"], []).append(row[column])
    return sorted(found), [mean(found[weight]) for weight in sorted(found)]


def usual(**changes):
    return {"start": "perturbed", "place": "gauge", "damping": "diagonal", "stop": "relative", **changes}


def gauge_zeros(tables, lang):
    words = WORDS[lang]
    svg = Svg(1080, 360, "Zero eigenvalues with and without an IMU")
    for panel, problem in enumerate(("camera and IMU", "camera alone")):
        values = relative_spectrum(tables, problem)
        axes = Axes(svg, (80 + 545 * panel, 45, 430, 240), (1, len(values)), (1e-20, 1), log_x=True, log_y=True)
        axes.draw(words["index"], f"{words[problem]}: {words['relative']}", [], [1e-20, 1e-16, 1e-12, 1e-8, 1e-4, 1])
        for tick in (1, 2, 4, 7, 20, 50, 100):
            svg.text(axes.x(tick), 308, f"{tick}", 15, MUTED)
        for i, value in enumerate(values):
            zero = value < ZERO
            svg.circle(axes.x(i + 1), axes.y(value), 5.5 if zero else 2.6, PRIOR if zero else POSE)
    return svg.render()


def gauge_iterations(tables, lang):
    """Fig. 7: mean iterations of each method in each scene, the paper's as grey bars."""
    words = WORDS[lang]
    svg = Svg(1080, 360, "Iterations of three ways to handle the gauge")
    axes = Axes(svg, (70, 40, 800, 235), (-0.6, 5.6), (3, 8))
    axes.draw("", words["iterations"], [], range(3, 9))
    for at, scene in enumerate(gauge_paper.SCENES):
        for k, (method, colour) in enumerate(METHODS.items()):
            x = axes.x(at + 0.24 * (k - 1))
            low, high = gauge_paper.ITERATIONS[scene][method]
            top, bottom = axes.y(high + 0.08), axes.y(low - 0.08)
            svg.rect(x - 10, top, 20, bottom - top, mix(INK, 0.18), radius=3)
            rows = tables.column(table("methods"), "iterations", path=scene[0], points=scene[1], method=method)
            svg.circle(x, axes.y(mean(rows)), 6.5, colour)
        svg.text(axes.x(at), 300, words[scene[0]], 17)
        svg.text(axes.x(at), 324, words[scene[1]], 15, MUTED)
    for i, (method, colour) in enumerate(METHODS.items()):
        svg.circle(905, 90 + 32 * i, 6.5, colour)
        svg.text(922, 96 + 32 * i, words[method], 16, anchor="start")
    svg.rect(895, 178, 20, 16, mix(INK, 0.18), radius=3)
    svg.text(922, 192, words["paper"], 16, anchor="start")
    return svg.render()


def weight_axes(svg, box, x_range, y_range, log_y=False):
    return Axes(svg, box, x_range, y_range, log_x=True, log_y=log_y, zero=True)


def gauge_weights(tables, lang):
    """Figs. 4 and 5: mean iterations against the weight, all scenes; the paper's as dots."""
    words = WORDS[lang]
    svg = Svg(1080, 370, "Iterations against the weight of the prior")
    axes = weight_axes(svg, (70, 40, 760, 260), (1, 1e8), (0, 16))
    axes.draw(words["weight"], words["iterations"], [0, 1, 1e2, 1e4, 1e6, 1e8], range(0, 17, 4))
    entries = []
    for path, colour in zip(("sine", "arc", "rec"), (PRIOR, CROSS, POSE)):
        for points, dash in (("planes", None), ("random", "6 5")):
            weights, found = over_weight(tables, "sweep", "iterations", path=path, points=points)
            axes.curve(weights, found, colour, dash, dots=False, width=2.2)
            entries.append((f"{words[path]}, {words[points]}", colour, dash))
    for weight, iterations in gauge_paper.SWEEP.items():
        svg.circle(axes.x(weight), axes.y(iterations), 5, INK)
    legend(svg, 860, 80, entries)
    svg.circle(875, 80 + 28 * len(entries), 5, INK)
    svg.text(900, 86 + 28 * len(entries), words["paper"], 16, anchor="start")
    return svg.render()


ARRIVAL = {10: mix(PRIOR, 0.45), 100: PRIOR, 1000: LANDMARK, 1e5: POSE}


def gauge_arrival(tables, lang):
    """Fig. 6: when the reprojection error and the prior error have arrived, trial 0."""
    words = WORDS[lang]
    svg = Svg(1080, 360, "First the pixels, then the frame")
    rows = {w: tables.rows(table("convergence"), trial=0, weight=w) for w in ARRIVAL}
    last = max(row["iteration"] for own in rows.values() for row in own)
    panels = (("reprojection_px", "pixels", (1.0, 100.0)), ("prior_error", "distance", (1e-5, 1.0)))
    for panel, (column, name, y_range) in enumerate(panels):
        axes = Axes(svg, (75 + 470 * panel, 40, 380, 245), (0, last), y_range, log_y=True)
        axes.draw(words["iteration"], words[name], range(0, int(last) + 1, 2), decades(y_range))
        for weight, own in rows.items():
            shown = [(row["iteration"], row[column]) for row in own if row[column] > y_range[0]]
            axes.curve([x for x, _ in shown], [y for _, y in shown], ARRIVAL[weight])
    legend(svg, 965, 90, [(f"10{'⁰¹²³⁴⁵'[round(log10(w))]}", colour, None) for w, colour in ARRIVAL.items()])
    svg.text(965, 66, "w", 17, anchor="start", italic=True)
    return svg.render()


def choice_damping(tables, lang):
    """The same problem and prior with three dampings."""
    words = WORDS[lang]
    svg = Svg(1080, 360, "Damping and the weight of the prior")
    curves = {name: over_weight(tables, "prior_choice", "iterations", **usual(damping=name)) for name in DAMPINGS}
    top = 4 * ceil(max(value for _, found in curves.values() for value in found) / 4)
    axes = weight_axes(svg, (70, 40, 740, 245), (1, 1e10), (0, top))
    axes.draw(words["weight"], words["iterations"], [0, 1, 1e2, 1e4, 1e6, 1e8, 1e10], range(0, top + 1, 4))
    for name, (weights, found) in curves.items():
        axes.curve(weights, found, DAMPINGS[name])
    legend(svg, 840, 90, [(words[name], colour, None) for name, colour in DAMPINGS.items()])
    return svg.render()


def error_ratio(tables, place):
    """Weights, and the mean error of the position at each next to that without a prior."""
    weights, found = over_weight(tables, "prior_choice", "position_m", **usual(place=place))
    return weights, [value / found[weights.index(0)] for value in found]


def choice_place(tables, lang):
    """What a prior at a wrong value does to the answer, by what it holds."""
    words = WORDS[lang]
    svg = Svg(1080, 340, "What the prior holds, and the error")
    axes = weight_axes(svg, (70, 40, 740, 225), (1, 1e10), (0.5, 50), log_y=True)
    axes.draw(words["weight"], words["ratio"], [0, 1, 1e2, 1e4, 1e6, 1e8, 1e10], [])
    for tick in (0.5, 1, 2, 5, 10, 20, 50):
        svg.line(axes.left, axes.y(tick), axes.left + axes.width, axes.y(tick), FAINT, 1)
        svg.text(axes.left - 9, axes.y(tick) + 5, f"{tick:g}", 15, MUTED, anchor="end")
    for place, colour in PLACES.items():
        axes.curve(*error_ratio(tables, place), colour)
    legend(svg, 840, 90, [(words[place], colour, None) for place, colour in PLACES.items()])
    return svg.render()


def gauge_sigma(tables, lang):
    """Fig. 9: the uncertainty of the positions, in each gauge and transformed into the other."""
    words = WORDS[lang]
    svg = Svg(1060, 340, "The uncertainty of the positions in two gauges")
    rows = {name: tables.rows(table("deviations"), gauge=name) for name in ("fixed", "free", "fixed to free", "free to fixed")}
    top = ceil(100 * max(row["position_m"] for own in rows.values() for row in own))
    axes = Axes(svg, (70, 40, 730, 230), (0, max(row["keyframe"] for row in rows["free"])), (0, top))
    axes.draw(words["keyframe"], words["sigma"], range(10), range(top + 1))
    for k, (name, colour) in enumerate((("fixed", POSE), ("free", CROSS), ("free to fixed", POSE), ("fixed to free", CROSS))):
        xs, ys = [row["keyframe"] for row in rows[name]], [100 * row["position_m"] for row in rows[name]]
        y = 90 + 32 * k
        if " to " in name:
            for at, value in zip(xs, ys):
                svg.circle(axes.x(at), axes.y(value), 9, "none", colour, 2)
            svg.circle(845, y, 9, "none", colour, 2)
        else:
            axes.curve(xs, ys, colour)
            svg.line(830, y, 860, y, colour, 3)
        svg.text(872, y + 6, words[name], 16, anchor="start")
    return svg.render()


def block_norms(tables, gauge, minus=None):
    """Norms of the 3×3 blocks of a covariance, of which the table holds the lower half."""
    entries = tables.matrix(table("matrices"), gauge=gauge)
    other = tables.matrix(table("matrices"), gauge=minus) if minus else {}
    sums = {}
    for (i, j), value in entries.items():
        square = (value - other.get((i, j), 0.0)) ** 2
        for place in {(i // 3, j // 3), (j // 3, i // 3)}:
            sums[place] = sums.get(place, 0.0) + square
    return {place: sqrt(total) for place, total in sums.items()}


def gauge_covariances(tables, lang):
    """Figs. 8 and 10: fixed, free, free transformed, and the difference, all in the same shades."""
    words = WORDS[lang]
    svg = Svg(1090, 310, "Covariances in two gauges")
    shown = (("fixed", block_norms(tables, "fixed")), ("free", block_norms(tables, "free")),
             ("free to fixed", block_norms(tables, "free to fixed")),
             ("difference", block_norms(tables, "free to fixed", minus="fixed")))
    largest = max(max(norms.values()) for _, norms in shown)
    side = 250
    for k, (name, norms) in enumerate(shown):
        left, unit = 10 + 272 * k, side / (1 + max(row for row, _ in norms))
        shades = {}
        for (row, column), value in sorted(norms.items()):
            depth = max(0.0, 1.0 + log10(max(value, 1e-300) / largest) / 7.0)
            shades.setdefault(round(12 * depth), []).append((row, column))
        square = f"h{number(unit * 0.94)}v{number(unit * 0.94)}h-{number(unit * 0.94)}z"
        for shade, places in sorted(shades.items()):
            svg.path("".join(f"M{number(left + c * unit)} {number(12 + r * unit)}{square}" for r, c in places), stroke=None,
                     width=None, fill=mix(POSE, shade / 12) if shade else PAPER)
        svg.rect(left, 12, side, side, stroke=MUTED, stroke_width=1)
        svg.text(left + side / 2, 292, words[name], 18)
    return svg.render()


ALL = {"gauge_zeros": gauge_zeros, "gauge_iterations": gauge_iterations, "gauge_weights": gauge_weights,
       "gauge_arrival": gauge_arrival, "choice_damping": choice_damping, "choice_place": choice_place,
       "gauge_sigma": gauge_sigma, "gauge_covariances": gauge_covariances}
