"""Pictures that follow from a small computation, without a table: the order of elimination, the step as λ grows."""

from math import cos, hypot, pi, sin

from ch5_backend.figures.slide import CROSS, FAINT, INK, LANDMARK, MUTED, POSE, PRIOR, Figures, mix

from ..deck1.toy import ordering, pattern, width

FIGURES = Figures("solvers.")


@FIGURES.figure(1130, 190, "Five questions to a solver")
def questions(slide, tables, say):
    """The five decisions of the lecture on their way from H to the next state."""
    for k, (question, answer) in enumerate(zip(*([say(f"{kind}.{k}") for k in range(5)] for kind in ("questions", "answers")))):
        x, shade = 8 + 226 * k, (POSE, POSE, CROSS, CROSS, PRIOR)[k]
        slide.rect(x, 40, 196, 96, mix(shade, 0.16), shade, radius=10, line=1.6)
        slide.text(x + 98, 80, question, 17, weight="bold")
        slide.text(x + 98, 112, answer, 14.5, MUTED)
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
            slide.rect(x + 1, y + 1, width(b) * cell - 2, width(a) * cell - 2, mix(shade, 0.55), radius=3)
        slide.rect(left, top, start * cell, start * cell, stroke=MUTED, radius=3)
        slide.text(left + start * cell / 2, top - 14, say(name), 18)
        if panel:
            count = len(fill & {(a, b) for a, b in blocks if places[a] >= places[b]})
            slide.text(left + start * cell / 2, top + start * cell + 32, f"{say('filled')}: {count}", 17,
                     PRIOR if count > 3 else MUTED)


# The model of the picture below, m(h) = ½ hᵀHh − bᵀh.
H, B = ((1.0, 0.75), (0.75, 3.0)), (2.6, 3.4)


def solve(damping):
    (a, c), (_, d) = H
    a, d = a + damping, d + damping
    det = a * d - c * c
    return (d * B[0] - c * B[1]) / det, (a * B[1] - c * B[0]) / det


@FIGURES.figure(1040, 400, "Damped steps and the dogleg")
def trust(slide, tables, say):
    """Level lines of the model, the steps of all λ, and the two pieces of the dogleg."""
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
        slide.polyline([at((newton[0] + p * cos(t) * v[0] - q * sin(t) * v[1], newton[1] + p * cos(t) * v[1] + q * sin(t) * v[0]))
                      for t in (2 * pi * k / 120 for k in range(121))], FAINT, 1.4)
    radius = 1.15
    slide.circle(ox, oy, radius * unit, "none", mix(PRIOR, 0.7), 1.6)
    path = [solve(10 ** (k / 20)) for k in range(-60, 61)]
    slide.polyline([at(h) for h in [newton, *path, (0, 0)]], CROSS, 3)
    bb = B[0] ** 2 + B[1] ** 2
    bHb = sum(B[i] * H[i][j] * B[j] for i in (0, 1) for j in (0, 1))
    steepest = tuple(bb / bHb * x for x in B)
    slide.polyline([at((0, 0)), at(steepest), at(newton)], LANDMARK, 3, dash="9 6")
    for h, color in (((0, 0), INK), (steepest, LANDMARK), (newton, POSE)):
        slide.circle(*at(h), 7, color)
    slide.text(ox - 14, oy + 24, say("start"), 17, anchor="end")
    slide.text(at(newton)[0] + 14, at(newton)[1] + 6, say("newton"), 17, POSE, anchor="start")
    slide.text(at(steepest)[0] + 2, at(steepest)[1] - 16, say("steepest"), 17, LANDMARK)
    for k, (name, color, dash) in enumerate((("damped", CROSS, None), ("dogleg", LANDMARK, "9 6"), ("radius", PRIOR, None))):
        slide.line(800, 120 + 34 * k, 836, 120 + 34 * k, color, 3, dash)
        slide.text(848, 126 + 34 * k, say(name), 17, anchor="start")

