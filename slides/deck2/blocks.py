"""Pictures that follow from a small computation, without a table: the order of elimination, the step as λ grows."""

from math import cos, hypot, pi, sin

from ..deck1.toy import ordering, pattern, width
from ..svg import CROSS, FAINT, INK, LANDMARK, MUTED, POSE, PRIOR, Svg, mix

WORDS = {
    "en": {"questions": ["eliminate what first?", "factorise or iterate?", "how long a step?", "which direction?",
                         "whom to believe?"],
           "answers": ["Schur complement", "Cholesky, PCG", "λ, radius Δ", "LM, dogleg", "robust loss ρ"],
           "H": "H", "landmarks": "landmarks first", "poses": "poses first", "filled": "filled in",
           "newton": "Gauss–Newton", "steepest": "steepest descent", "damped": "all λ", "dogleg": "dogleg",
           "radius": "radius Δ", "start": "here"},
    "zh": {"questions": ["先消去谁？", "分解还是迭代？", "步子多大？", "朝哪个方向？", "该相信谁？"],
           "answers": ["舒尔补", "Cholesky、PCG", "λ、半径 Δ", "LM、dogleg", "鲁棒核 ρ"],
           "H": "H", "landmarks": "先消路标点", "poses": "先消位姿", "filled": "填充",
           "newton": "高斯–牛顿", "steepest": "最速下降", "damped": "所有 λ", "dogleg": "dogleg",
           "radius": "半径 Δ", "start": "当前点"},
}


def questions(_, lang):
    """The five decisions of the lecture on their way from H to the next state."""
    words = WORDS[lang]
    svg = Svg(1130, 190, "Five questions to a solver")
    for k, (question, answer) in enumerate(zip(words["questions"], words["answers"])):
        x, shade = 8 + 226 * k, (POSE, POSE, CROSS, CROSS, PRIOR)[k]
        svg.rect(x, 40, 196, 96, mix(shade, 0.16), shade, radius=10, stroke_width=1.6)
        svg.text(x + 98, 80, question, 17, weight="bold")
        svg.text(x + 98, 112, answer, 14.5, MUTED)
        if k:
            svg.line(x - 26, 88, x - 5, 88, arrow=True)
    return svg.render()


def eliminate(order):
    """Blocks of the Cholesky factor of the toy graph in this order, and which of them are not in H: symbolic."""
    filled = {pair for pair in pattern()}
    place = {vertex: k for k, vertex in enumerate(order)}
    for vertex in order:
        later = [other for other in order if place[other] > place[vertex] and (other, vertex) in filled]
        filled |= {(a, b) for a in later for b in later}
    return filled, filled - set(pattern())


def order(_, lang):
    """H as an arrow, and its Cholesky factor in both orders: fill-in dashed."""
    words = WORDS[lang]
    svg = Svg(1130, 380, "The order of elimination")
    poses_first = list(ordering())
    landmarks_first = sorted(poses_first, key=lambda vertex: vertex[0] != "l")
    cell, top = 19, 40
    for panel, (name, sequence) in enumerate((("H", landmarks_first), ("landmarks", landmarks_first), ("poses", poses_first))):
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
            svg.rect(x + 1, y + 1, width(b) * cell - 2, width(a) * cell - 2, mix(shade, 0.55), radius=3)
        svg.rect(left, top, start * cell, start * cell, stroke=MUTED, radius=3)
        svg.text(left + start * cell / 2, top - 14, words[name], 18)
        if panel:
            count = len(fill & {(a, b) for a, b in blocks if places[a] >= places[b]})
            svg.text(left + start * cell / 2, top + start * cell + 32, f"{words['filled']}: {count}", 17,
                     PRIOR if count > 3 else MUTED)
    return svg.render()


# The model of the picture below, m(h) = ½ hᵀHh − bᵀh.
H, B = ((1.0, 0.75), (0.75, 3.0)), (2.6, 3.4)


def solve(damping):
    (a, c), (_, d) = H
    a, d = a + damping, d + damping
    det = a * d - c * c
    return (d * B[0] - c * B[1]) / det, (a * B[1] - c * B[0]) / det


def trust(_, lang):
    """Level lines of the model, the steps of all λ, and the two pieces of the dogleg."""
    words = WORDS[lang]
    svg = Svg(1040, 400, "Damped steps and the dogleg")
    ox, oy, unit = 210, 320, 165

    def at(h):
        return ox + unit * h[0], oy - unit * h[1]
    newton = solve(0.0)
    (a, c), (_, d) = H
    middle, spread = (a + d) / 2, hypot((a - d) / 2, c)
    small, large = middle - spread, middle + spread
    v = (c, small - a)
    v = (v[0] / hypot(*v), v[1] / hypot(*v))
    for level in (0.08, 0.35, 0.9, 1.8, 3.1):
        p, q = (2 * level / small) ** 0.5, (2 * level / large) ** 0.5
        svg.polyline([at((newton[0] + p * cos(t) * v[0] - q * sin(t) * v[1], newton[1] + p * cos(t) * v[1] + q * sin(t) * v[0]))
                      for t in (2 * pi * k / 120 for k in range(121))], FAINT, 1.4)
    radius = 1.15
    svg.circle(ox, oy, radius * unit, "none", mix(PRIOR, 0.7), 1.6)
    path = [solve(10 ** (k / 20)) for k in range(-60, 61)]
    svg.polyline([at(h) for h in [newton, *path, (0, 0)]], CROSS, 3)
    bb = B[0] ** 2 + B[1] ** 2
    bHb = sum(B[i] * H[i][j] * B[j] for i in (0, 1) for j in (0, 1))
    steepest = tuple(bb / bHb * x for x in B)
    svg.polyline([at((0, 0)), at(steepest), at(newton)], LANDMARK, 3, dash="9 6")
    for h, colour in (((0, 0), INK), (steepest, LANDMARK), (newton, POSE)):
        svg.circle(*at(h), 7, colour)
    svg.text(ox - 14, oy + 24, words["start"], 17, anchor="end")
    svg.text(at(newton)[0] + 14, at(newton)[1] + 6, words["newton"], 17, POSE, anchor="start")
    svg.text(at(steepest)[0] + 2, at(steepest)[1] - 16, words["steepest"], 17, LANDMARK)
    for k, (name, colour, dash) in enumerate((("damped", CROSS, None), ("dogleg", LANDMARK, "9 6"), ("radius", PRIOR, None))):
        svg.line(800, 120 + 34 * k, 836, 120 + 34 * k, colour, 3, dash)
        svg.text(848, 126 + 34 * k, words[name], 17, anchor="start")
    return svg.render()


ALL = {"questions": questions, "order": order, "trust": trust}
