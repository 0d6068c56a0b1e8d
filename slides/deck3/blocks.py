"""Pictures that need no table: computed from the toy graph and the hand-worked examples of toy.py."""

from math import cos, pi as PI, sin, sqrt

from ..chart import Axes
from ..svg import FAINT, INK, LANDMARK, MUTED, PAPER, POSE, PRIOR, Svg, mix, number

from . import toy

WORDS = {
    "en": {"before": "before", "after": "after: one prior", "goes": "leaves", "newest": "newest", "keyframes": "keyframes",
           "oldest": "oldest", "pose": "pose", "speed": "with speed and biases", "landmark": "landmark", "imu": "IMU",
           "same": "linearised at one point", "mixed": "linearised at two points", "measured": "measured distance",
           "hidden": "prior, σ = 0.2", "temporal": "newest frames, whole"},
    "zh": {"before": "之前", "after": "之后：一个先验", "goes": "离开", "newest": "最新", "keyframes": "关键帧",
           "oldest": "最老", "pose": "位姿", "speed": "带速度与零偏", "landmark": "路标点", "imu": "IMU",
           "same": "在同一点线性化", "mixed": "在两个点线性化", "measured": "测得的距离",
           "hidden": "先验，σ = 0.2", "temporal": "最新几帧，状态完整"},
}
SUB = "₀₁₂₃₄₅"


def place(vertex, left):
    kind, n = vertex
    return (left + 60 + 130 * n, 250) if kind == "x" else (left + 75 + 95 * n, 100)


def draw_vertex(svg, vertex, left, faded=False):
    x, y = place(vertex, left)
    colour = POSE if vertex[0] == "x" else LANDMARK
    svg.circle(x, y, 21, PAPER if faded else mix(colour, 0.25), mix(colour, 0.35) if faded else colour, 2)
    svg.text(x, y + 6, ("x" if vertex[0] == "x" else "ℓ") + SUB[vertex[1]], 18,
             mix(INK, 0.35) if faded else INK, italic=True)


def clique(lang):
    """The toy graph before and after its oldest pose and the landmarks seen from there are marginalised."""
    words = WORDS[lang]
    svg = Svg(1080, 350, "Marginalising ties the neighbours together")
    gone, tied, vertices = toy.leaving(), toy.neighbours(), sorted(set().union(*toy.edges()))
    for left, after in ((0, False), (580, True)):
        for edge in toy.edges():
            a, b = (place(vertex, left) for vertex in sorted(edge))
            if not (after and edge & gone):
                svg.line(*a, *b, PRIOR if edge & gone else MUTED, 2.2 if edge & gone else 1.6)
        if after:
            for i, a in enumerate(tied):
                for b in tied[i + 1:]:
                    (x1, y1), (x2, y2) = place(a, left), place(b, left)
                    bend = 34 + 0.22 * abs(x2 - x1)
                    svg.path(f"M{number(x1)} {y1} Q{number((x1 + x2) / 2)} {number(y1 + bend)} {number(x2)} {y2}", PRIOR, 4)
        for vertex in vertices:
            draw_vertex(svg, vertex, left, faded=after and vertex in gone)
            if not after and vertex in gone:
                svg.circle(*place(vertex, left), 28, "none", PRIOR, 2)
        svg.text(left + 250, 40, words["after" if after else "before"], 19, MUTED)
    svg.line(505, 180, 555, 180, arrow=True)
    svg.circle(40, 325, 9, "none", PRIOR, 2)
    svg.text(58, 331, words["goes"], 17, PRIOR, anchor="start")
    return svg.render()


def chain_graph(lang):
    """The course's three scalars with all four of their measurements."""
    words = WORDS[lang]
    svg = Svg(860, 190, "The chain of three scalars and its hidden prior")
    at = (110, 420, 730)
    for (x1, x2), sigma in zip(zip(at, at[1:]), ("0.1", "0.3")):
        svg.line(x1, 75, x2, 75, MUTED, 2)
        svg.rect((x1 + x2) / 2 - 10, 65, 20, 20, POSE, radius=3)
        svg.text((x1 + x2) / 2, 48, f"{words['measured']}, σ = {sigma}", 17, MUTED)
    svg.line(420, 75, 420, 150, PRIOR, 2)
    svg.rect(410, 140, 20, 20, PRIOR, radius=3)
    svg.text(445, 157, words["hidden"], 18, PRIOR, anchor="start")
    for k, x in enumerate(at):
        svg.circle(x, 75, 25, mix(POSE, 0.25), POSE, 2)
        svg.text(x, 82, "x" + SUB[k], 20, italic=True)
    return svg.render()


def frame(svg, x, y, whole, colour=POSE):
    svg.circle(x, y, 15, mix(colour, 0.85 if whole else 0.3), colour, 1.6)
    if whole:
        svg.circle(x, y, 22, "none", LANDMARK, 3)


def windows(lang):
    """Which states the two windows hold, drawn with the published sizes: 10 + 1 frames, and 5 keyframes and 3 frames."""
    words = WORDS[lang]
    svg = Svg(1120, 350, "The windows of VINS-Mono and OKVIS")
    step, right = 64, 1040
    for row, (name, whole, keyframes) in enumerate((("VINS-Mono", 11, ()), ("OKVIS", 3, (4, 6, 8, 11, 13)))):
        y = 95 + 150 * row
        svg.text(20, y - 52, name, 21, weight="bold", anchor="start")
        newest = [right - step * k for k in range(whole)]
        for a, b in zip(newest, newest[1:]):
            svg.line(a - 22, y, b + 22, y, LANDMARK, 2.5)
        for x in newest:
            frame(svg, x, y, True)
        for k in keyframes:
            frame(svg, right - step * k + 0, y, False)
        for k in range(15):
            if k >= whole and k not in keyframes:
                svg.circle(right - step * k, y, 4, FAINT)
        svg.text(right, y - 36, words["newest"], 16, MUTED)
        if keyframes:
            svg.text(right - step * 8.5, y - 36, words["keyframes"], 16, MUTED)
        else:
            svg.text(newest[-1], y - 36, words["oldest"], 16, MUTED)
    frame(svg, 60, 325, False)
    svg.text(88, 331, words["pose"], 17, anchor="start")
    frame(svg, 210, 325, True)
    svg.text(244, 331, words["pose"] + (" " if lang == "en" else "，") + words["speed"], 17, anchor="start")
    svg.line(560, 325, 600, 325, LANDMARK, 2.5)
    svg.text(612, 331, words["imu"], 17, anchor="start")
    return svg.render()


def ellipse(H, level):
    """Points of δᵀHδ = level for a positive definite 2×2 H."""
    (a, b), (_, c) = [[float(v) for v in row] for row in H]
    points = []
    for step in range(97):
        u, v = cos(2 * PI * step / 96), sin(2 * PI * step / 96)
        radius = sqrt(level / (a * u * u + 2 * b * u * v + c * v * v))
        points.append((radius * u, radius * v))
    return points


def product(lang):
    """x y = 1 measured twice: level lines of the two quadratic models' sum, linearised at one point and at two."""
    words = WORDS[lang]
    svg = Svg(1080, 390, "Linearised twice, at one point and at two")
    _, mixed = toy.two_tangents()
    points = [[float(v) for v in point] for point in toy.POINTS]
    for left, name in ((60, "same"), (610, "mixed")):
        axes = Axes(svg, (left, 45, 420, 270), (0.0, 2.8), (0.0, 1.8))
        axes.draw("x", "", (0, 1, 2), (0, 1))
        svg.text(left - 16, 50, "y", 17)
        svg.text(left + 210, 30, words[name], 18, MUTED)
        curve = [0.56 + 2.24 * k / 60 for k in range(61)]
        svg.polyline([(axes.x(x), axes.y(toy.PRODUCT / x)) for x in curve], LANDMARK, 4)
        at = points[:1] if name == "same" else points
        if name == "same":
            for level in (0.08, 0.3, 0.65):  # the two tangents are one: (x + y − 2)² = level, straight lines
                for sign in (1, -1):
                    c = 2 + sign * level
                    svg.line(axes.x(max(0.0, c - 1.8)), axes.y(min(1.8, c)), axes.x(c), axes.y(0.0), mix(POSE, 0.6), 1.8)
        else:
            cross = toy.solve([[1, 1], [toy.POINTS[1][1], toy.POINTS[1][0]]], [2, 2 * toy.PRODUCT])
            for level in (0.05, 0.25, 0.6):
                ring = [(float(cross[0]) + dx, float(cross[1]) + dy) for dx, dy in ellipse(mixed, level)]
                svg.polyline([(axes.x(x), axes.y(y)) for x, y in ring], mix(POSE, 0.6), 1.8)
            svg.circle(axes.x(float(cross[0])), axes.y(float(cross[1])), 6, PRIOR)
        for x0, y0 in at:  # the tangent y0 (x − x0) + x0 (y − y0) = 0
            ends = [(x, y0 - y0 * (x - x0) / x0) for x in (max(0.0, x0 - x0 * (1.8 - y0) / y0), min(2.8, 2 * x0))]
            svg.polyline([(axes.x(x), axes.y(y)) for x, y in ends], INK, 1.8, dash="7 5")
            svg.circle(axes.x(x0), axes.y(y0), 7, INK)
    return svg.render()


ALL = {"clique": clique, "chain_graph": chain_graph, "windows": windows, "product": product}
