"""Pictures that need no table: computed from the toy graph and the hand-worked examples of toy.py."""

import numpy as np

from ch5_backend.figures.slide import FAINT, INK, LANDMARK, MUTED, PAPER, POSE, PRIOR, Figures, mix

from . import toy

FIGURES = Figures("windows.")
SUB = "₀₁₂₃₄₅"


def place(vertex, left):
    kind, n = vertex
    return (left + 60 + 130 * n, 250) if kind == "x" else (left + 75 + 95 * n, 100)


def draw_vertex(slide, vertex, left, faded=False):
    x, y = place(vertex, left)
    color = POSE if vertex[0] == "x" else LANDMARK
    slide.circle(x, y, 21, PAPER if faded else mix(color, 0.25), mix(color, 0.35) if faded else color, 2)
    slide.text(x, y + 6, ("x" if vertex[0] == "x" else "ℓ") + SUB[vertex[1]], 18,
             mix(INK, 0.35) if faded else INK, italic=True)


@FIGURES.figure(1080, 350, "Marginalizing ties the neighbors together")
def clique(slide, tables, say):
    """The toy graph before and after its oldest pose and the landmarks seen from there are marginalized."""
    gone, tied, vertices = toy.leaving(), toy.neighbors(), sorted(set().union(*toy.edges()))
    for left, after in ((0, False), (580, True)):
        for edge in toy.edges():
            a, b = (place(vertex, left) for vertex in sorted(edge))
            if not (after and edge & gone):
                slide.line(*a, *b, PRIOR if edge & gone else MUTED, 2.2 if edge & gone else 1.6)
        if after:
            for i, a in enumerate(tied):
                for b in tied[i + 1:]:
                    (x1, y1), (x2, y2) = place(a, left), place(b, left)
                    below = (x1 + x2) / 2, y1 + 34 + 0.22 * abs(x2 - x1)
                    slide.polyline([(x1, y1), below, (x2, y2)], PRIOR, 4, curved=True)
        for vertex in vertices:
            draw_vertex(slide, vertex, left, faded=after and vertex in gone)
            if not after and vertex in gone:
                slide.circle(*place(vertex, left), 28, "none", PRIOR, 2)
        slide.text(left + 250, 40, say("after" if after else "before"), 19, MUTED)
    slide.line(505, 180, 555, 180, arrow=True)
    slide.circle(40, 325, 9, "none", PRIOR, 2)
    slide.text(58, 331, say("goes"), 17, PRIOR, anchor="start")


@FIGURES.figure(860, 190, "The chain of three scalars and its hidden prior")
def chain_graph(slide, tables, say):
    """The course's three scalars with all four of their measurements."""
    at = (110, 420, 730)
    for (x1, x2), sigma in zip(zip(at, at[1:]), ("0.1", "0.3")):
        slide.line(x1, 75, x2, 75, MUTED, 2)
        slide.rect((x1 + x2) / 2 - 10, 65, 20, 20, POSE, radius=3)
        slide.text((x1 + x2) / 2, 48, f"{say('measured')}, σ = {sigma}", 17, MUTED)
    slide.line(420, 75, 420, 150, PRIOR, 2)
    slide.rect(410, 140, 20, 20, PRIOR, radius=3)
    slide.text(445, 157, say("hidden"), 18, PRIOR, anchor="start")
    for k, x in enumerate(at):
        slide.circle(x, 75, 25, mix(POSE, 0.25), POSE, 2)
        slide.text(x, 82, "x" + SUB[k], 20, italic=True)


def frame(slide, x, y, whole, color=POSE):
    slide.circle(x, y, 15, mix(color, 0.85 if whole else 0.3), color, 1.6)
    if whole:
        slide.circle(x, y, 22, "none", LANDMARK, 3)


@FIGURES.figure(1120, 350, "The windows of VINS-Mono and OKVIS")
def windows(slide, tables, say):
    """Which states the two windows hold, drawn with the published sizes: 10 + 1 frames, and 5 keyframes and 3 frames."""
    step, right = 64, 1040
    for row, (name, whole, keyframes) in enumerate((("VINS-Mono", 11, ()), ("OKVIS", 3, (4, 6, 8, 11, 13)))):
        y = 95 + 150 * row
        slide.text(20, y - 52, name, 21, weight="bold", anchor="start")
        newest = [right - step * k for k in range(whole)]
        for a, b in zip(newest, newest[1:]):
            slide.line(a - 22, y, b + 22, y, LANDMARK, 2.5)
        for x in newest:
            frame(slide, x, y, True)
        for k in keyframes:
            frame(slide, right - step * k + 0, y, False)
        for k in range(15):
            if k >= whole and k not in keyframes:
                slide.circle(right - step * k, y, 4, FAINT)
        slide.text(right, y - 36, say("newest"), 16, MUTED)
        if keyframes:
            slide.text(right - step * 8.5, y - 36, say("keyframes"), 16, MUTED)
        else:
            slide.text(newest[-1], y - 36, say("oldest"), 16, MUTED)
    frame(slide, 60, 325, False)
    slide.text(88, 331, say("pose"), 17, anchor="start")
    frame(slide, 210, 325, True)
    slide.text(244, 331, say("pose and speed"), 17, anchor="start")
    slide.line(560, 325, 600, 325, LANDMARK, 2.5)
    slide.text(612, 331, say("imu"), 17, anchor="start")


@FIGURES.figure(1080, 390, "Linearized twice, at one point and at two")
def product(slide, tables, say):
    """x y = 1 measured twice: level lines of the two quadratic models' sum, linearized at one point and at two."""
    same, mixed = toy.two_tangents()
    cross = [float(v) for v in toy.solve([[1, 1], [toy.POINTS[1][1], toy.POINTS[1][0]]], [2, 2 * toy.PRODUCT])]
    x, y = np.meshgrid(np.linspace(0, 2.8, 281), np.linspace(0, 1.8, 181))
    for left, name, H, middle, levels, points in (
            (60, "same", same, (1, 1), (0.0128, 0.18, 0.845), toy.POINTS[:1]),
            (610, "mixed", mixed, cross, (0.05, 0.25, 0.6), toy.POINTS)):
        axes = slide.axes((left, 45, 420, 270), (0, 2.8), (0, 1.8), below="x", xticks=(0, 1, 2), yticks=(0, 1))
        slide.text(left - 16, 50, "y", 17)
        slide.text(left + 210, 30, say(name), 18, MUTED)
        dx, dy = x - middle[0], y - middle[1]
        cost = float(H[0][0]) * dx**2 + 2 * float(H[0][1]) * dx * dy + float(H[1][1]) * dy**2
        axes.contour(x, y, cost, levels, colors=[mix(POSE, 0.6)], linewidths=1.35)
        axes.plot(x[0, 56:], toy.PRODUCT / x[0, 56:], color=LANDMARK, linewidth=3)
        if name == "mixed":
            axes.plot(*middle, "o", color=PRIOR, markersize=9)
        for x0, y0 in ((float(a), float(b)) for a, b in points):  # the tangent y0 (x − x0) + x0 (y − y0) = 0
            axes.plot((0, 2 * x0), (2 * y0, 0), color=INK, linewidth=1.35, linestyle=(0, (4, 3)))
            axes.plot(x0, y0, "o", color=INK, markersize=10.5)
