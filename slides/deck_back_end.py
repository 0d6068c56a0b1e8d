"""Deck 1, the back end. Its block pictures are computed from a toy graph: three poses, six landmarks, one edge per view.

Nothing is placed by hand that the algebra decides: which blocks of H are filled, where an edge writes, what the Schur
complement fills in, how rows and columns move, all follow from the list of edges in toy_graph.py.
"""

import numpy as np

from ch5_backend.figures import hessian
from ch5_backend.figures.convergence import curves
from ch5_backend.figures.scene import before_and_after
from ch5_backend.figures.slide import (CROSS, FAINT, INK, LANDMARK, MUTED, PAPER, POSE, PRIOR, Figures, decades, mix)
from ch5_backend.figures.tables import dense

from . import marginalization_examples
from .deck_back_end_facts import facts  # noqa: F401
from .tex import decimal
from .toy_graph import EDGES, LANDMARKS, POSES, POSE_WIDTH, ordering, pattern, schur_pattern, vertices, width

FIGURES = Figures({"cost": "cost above its least / first cost", "lambda": "λ"})


def color(a, b):
    return POSE if a[0] == b[0] == "p" else LANDMARK if a[0] == b[0] == "l" else CROSS


def draw_matrix(slide, x, y, cell, counts, total):
    place = ordering()
    strongest = max(counts.values())
    for (a, b), count in sorted(counts.items()):
        strength = 0.35 + 0.55 * count / strongest
        slide.rect(x + place[b] * cell + 1, y + place[a] * cell + 1, width(b) * cell - 2, width(a) * cell - 2,
                 mix(color(a, b), strength), radius=3)
    slide.rect(x, y, total * cell, total * cell, stroke=MUTED, radius=3, line=1.2)


def label_axes(slide, x, y, cell):
    for vertex, start in ordering().items():
        name = ("x" if vertex[0] == "p" else "ℓ") + "₀₁₂₃₄₅"[vertex[1]]
        middle = (start + width(vertex) / 2) * cell
        shade = POSE if vertex[0] == "p" else LANDMARK
        slide.text(x + middle, y - 10, name, 17, shade, italic=True)
        slide.text(x - 10, y + middle + 6, name, 17, shade, anchor="end", italic=True)


@FIGURES.figure(1130, 430, "Factor graph and Hessian")
def graph(slide, tables, say):
    """The factor graph on the left, the matrix that it makes on the right."""
    pose_at = {n: (110 + 175 * n, 95) for n in range(POSES)}
    landmark_at = {k: (50 + 94 * k, 340) for k in range(LANDMARKS)}
    for landmark, host, target in EDGES:
        lx, ly = landmark_at[landmark]
        px, py = pose_at[target]
        fx, fy = lx + 0.45 * (px - lx), ly + 0.45 * (py - ly)
        for ex, ey in ((lx, ly), (px, py), pose_at[host]):
            slide.line(fx, fy, ex, ey, FAINT if (ex, ey) == pose_at[host] else mix(CROSS, 0.8), 1.6)
        slide.rect(fx - 5, fy - 5, 10, 10, INK)
    for n, (x, y) in pose_at.items():
        slide.circle(x, y, 27, mix(POSE, 0.25), POSE, 2)
        slide.text(x, y + 7, "x" + "₀₁₂"[n], 21, italic=True)
    for k, (x, y) in landmark_at.items():
        slide.circle(x, y, 19, mix(LANDMARK, 0.25), LANDMARK, 2)
        slide.text(x, y + 6, "ℓ" + "₀₁₂₃₄₅"[k], 18, italic=True)
    slide.text(285, 36, say("poses"), 19, POSE)
    slide.text(285, 405, say("landmarks"), 19, LANDMARK)
    slide.line(590, 215, 655, 215, arrow=True)
    label_axes(slide, 725, 45, 24)
    draw_matrix(slide, 725, 45, 24, pattern(), 15)


@FIGURES.figure(620, 420, "The nine blocks of one edge")
def one_edge(slide, tables, say):
    """The nine blocks that one reprojection edge writes; a by TODO 1.1a, b by 1.1b."""
    edge = (2, 0, 1)
    x, y, cell = 60, 40, 24
    place, listed = ordering(), vertices(edge)
    label_axes(slide, x, y, cell)
    for i, a in enumerate(listed):
        for j, b in enumerate(listed):
            direct = i <= j
            left, top = x + place[b] * cell, y + place[a] * cell
            slide.rect(left + 1, top + 1, width(b) * cell - 2, width(a) * cell - 2,
                     mix(color(a, b), 0.85 if direct else 0.3), radius=3)
            slide.text(left + width(b) * cell / 2, top + width(a) * cell / 2 + 6, "a" if direct else "b", 17,
                     PAPER if direct else INK, weight="bold")
    slide.rect(x, y, 15 * cell, 15 * cell, stroke=MUTED, radius=3, line=1.2)
    slide.line(x, y, x + 15 * cell, y + 15 * cell, FAINT, 1.2, "4 5")
    for row, (mark, name, strength) in enumerate((("a", "write of 1.1a", 0.85), ("b", "write of 1.1b", 0.3))):
        top = 150 + 46 * row
        slide.rect(440, top, 26, 26, mix(POSE, strength), radius=3)
        slide.text(453, top + 19, mark, 17, PAPER if row == 0 else INK, weight="bold")
        slide.text(476, top + 19, say(name), 15, anchor="start")


@FIGURES.figure(1080, 400, "The Schur complement")
def schur(slide, tables, say):
    """H, then the reduced system of the poses with its fill-in."""
    cell = 22
    draw_matrix(slide, 40, 35, cell, pattern(), 15)
    corner = POSES * POSE_WIDTH * cell
    slide.line(40, 35 + corner, 40 + 15 * cell, 35 + corner, INK, 1.2)
    slide.line(40 + corner, 35, 40 + corner, 35 + 15 * cell, INK, 1.2)
    wide = LANDMARKS * cell
    for i, j, name in ((0, 0, "pp"), (0, 1, "pm"), (1, 0, "mp"), (1, 1, "mm")):
        left, top = 40 + (corner if j else 0), 35 + (corner if i else 0)
        slide.formula(left + (wide if j else corner) / 2, top + (wide if i else corner) / 2 + 7, f"H_{{{name}}}", 22)
    slide.text(40 + corner / 2, 390, say("poses"), 17, POSE)
    slide.text(40 + corner + wide / 2, 390, say("landmarks"), 17, LANDMARK)
    slide.line(405, 200, 465, 200, arrow=True)
    draw_matrix(slide, 500, 35 + 66, cell, schur_pattern(), 9)
    slide.formula(500 + corner / 2, 335, r"H_{pp} - H_{pm}\, H_{mm}^{-1} H_{mp}", 18)
    added = [pair for pair in schur_pattern() if pair not in pattern()]
    for a, b in added:
        left, top = 500 + ordering()[b] * cell, 101 + ordering()[a] * cell
        slide.rect(left + 4, top + 4, POSE_WIDTH * cell - 8, POSE_WIDTH * cell - 8, stroke=PRIOR, radius=3,
                 line=2, dash="5 4")
    slide.line(735, 200, 795, 200, arrow=True)
    for k in range(LANDMARKS):
        slide.rect(840 + k * 32, 101 + k * 33, 26, 26, mix(LANDMARK, 0.8), radius=3)
    slide.formula(935, 335, r"H_{mm}\, \Delta x_m = b_m - H_{mp}\, \Delta x_p", 18)


def heat(slide, x, y, cell, rows, names):
    largest = max(abs(v) for row in rows for v in row)
    for i, row in enumerate(rows):
        for j, value in enumerate(row):
            base = POSE if value > 0 else PRIOR
            shade = mix(base, 0.08 + 0.5 * float(abs(value) / largest)) if value else PAPER
            slide.rect(x + j * cell + 1, y + i * cell + 1, cell - 2, cell - 2, shade, FAINT, radius=4)
            slide.text(x + (j + 0.5) * cell, y + (i + 0.5) * cell + 7, decimal(value), 19)
        slide.text(x - 12, y + (i + 0.5) * cell + 7, names[i], 19, MUTED, anchor="end", italic=True)
        slide.text(x + (i + 0.5) * cell, y - 12, names[i], 19, MUTED, italic=True)


@FIGURES.figure(1060, 380, "Marginalizing the middle of a chain")
def chain(slide, tables, say):
    """The 3×3 example before and after, as a heat map with its numbers."""
    H, _, prior, _ = marginalization_examples.chain()
    for n, (x, shade) in enumerate(((70, POSE), (200, PRIOR), (330, POSE))):
        slide.circle(x, 60, 25, mix(shade, 0.2), shade, 2)
        slide.text(x, 67, "x" + "₀₁₂"[n], 20, italic=True)
    for x1, x2 in ((95, 175), (225, 305)):
        slide.line(x1, 60, x2, 60, INK, 2)
        slide.rect((x1 + x2) / 2 - 6, 54, 12, 12, INK)
    slide.line(200, 85, 200, 125, INK, 2)
    slide.rect(194, 119, 12, 12, INK)
    slide.text(200, 27, say("goes"), 17, PRIOR)
    for n, x in ((0, 70), (2, 330)):
        slide.circle(x, 290, 25, mix(POSE, 0.2), POSE, 2)
        slide.text(x, 297, "x" + "₀₁₂"[n], 20, italic=True)
    slide.line(95, 290, 305, 290, PRIOR, 2)
    slide.rect(192, 282, 16, 16, PRIOR)
    slide.text(200, 330, say("prior"), 17, PRIOR)
    slide.line(200, 160, 200, 235, arrow=True)
    heat(slide, 450, 60, 98, H, ["x₀", "x₁", "x₂"])
    slide.line(760, 207, 800, 207, arrow=True)
    heat(slide, 850, 109, 98, prior, ["x₀", "x₂"])


@FIGURES.figure(1080, 310, "Moving a variable to the end")
def moves(slide, tables, say):
    """Stage 2: where rows and columns go, for a variable in the middle of five."""
    n, idx = 5, 1
    order = [k for k in range(n) if k != idx] + [idx]
    steps = ((range(n), range(n), "before"), (order, range(n), "rows moved"), (order, order, "columns moved"))
    cell = 42
    for step, (rows, columns, name) in enumerate(steps):
        x, y = 50 + step * 360, 50
        for i, row in enumerate(rows):
            for j, column in enumerate(columns):
                hit = (row == idx) + (column == idx)
                shade = mix(POSE, 0.16) if hit == 0 else mix(PRIOR, 0.3 if hit == 1 else 0.65)
                slide.rect(x + j * cell + 1, y + i * cell + 1, cell - 2, cell - 2, shade, radius=3)
            slide.text(x - 12, y + (i + 0.5) * cell + 6, row, 17, PRIOR if row == idx else MUTED, anchor="end")
        for j, column in enumerate(columns):
            slide.text(x + (j + 0.5) * cell, y - 9, column, 17, PRIOR if column == idx else MUTED)
        slide.text(x + n * cell / 2, y + n * cell + 34, say(name), 18)
        if step < 2:
            slide.line(x + n * cell + 40, y + n * cell / 2, x + n * cell + 90, y + n * cell / 2, arrow=True)


@FIGURES.figure(1130, 270, "From graph to step")
def river(slide, tables, say):
    """The chapter's flow of values, one box a step."""
    boxes = [("Graph", say("what")), ("Ordering", say("where")), ("MakeHessian", "H, b"),
             ("SolveLinearSystem", "(H + λD) Δx = b"), ("UpdateStates", "x ⊞ Δx"), (say("better?"), "ρ")]
    wide = [105, 130, 165, 235, 165, 120]
    x, places = 15, []
    for (name, below), w in zip(boxes, wide):
        graded = name in ("MakeHessian", "SolveLinearSystem")
        shade = LANDMARK if graded else POSE
        slide.rect(x, 85, w, 74, mix(shade, 0.18), shade, radius=10, line=1.6)
        slide.text(x + w / 2, 117, name, 19, weight="bold")
        slide.text(x + w / 2, 143, below, 16, MUTED)
        places.append((x, w))
        x += w + 38
    for (x1, w), (x2, _) in zip(places, places[1:]):
        slide.line(x1 + w + 4, 122, x2 - 5, 122, arrow=True)
    last, solve, make = places[5], places[3], places[2]
    for target, y, name in ((solve, 40, say("no: larger λ")), (make, 215, say("yes: linearize again"))):
        edge = 80 if y < 122 else 164
        right, left = last[0] + last[1] / 2, target[0] + target[1] / 2
        slide.polyline([(right, edge), (right, y), (left, y), (left, edge)], width=1.5, arrow=True)
        slide.text((right + left) / 2, y + (-10 if y < 122 else 24), name, 16, MUTED)


@FIGURES.figure(900, 365, "A free gauge is a valley")
def valley(slide, tables, say):
    """Cost of two scalars a, b with b − a measured, without and with a prior on a: level lines of the quadratic."""
    for panel, weight in enumerate((0.0, 0.35)):
        ox, oy, unit = 215 + 450 * panel, 180, 62
        for level in (0.15, 0.6, 1.5):
            if weight == 0.0:  # (b − a)² = level: two straight lines
                for sign in (1, -1):
                    shift = sign * level ** 0.5 / 2
                    slide.line(ox - (2.3 + shift) * unit, oy + (2.3 - shift) * unit,
                             ox + (2.3 - shift) * unit, oy - (2.3 + shift) * unit, mix(POSE, 0.75), 1.8)
            else:  # (b − a)² + w a² = level: a = √(level/w) cos t, b = a + √level sin t
                t = np.linspace(0, 2 * np.pi, 97)
                a = (level / weight) ** 0.5 * np.cos(t)
                slide.polyline(np.column_stack((ox + a * unit, oy - (a + level ** 0.5 * np.sin(t)) * unit)), mix(POSE, 0.75), 1.8)
        if weight == 0.0:
            slide.line(ox - 2.3 * unit, oy + 2.3 * unit, ox + 2.3 * unit, oy - 2.3 * unit, LANDMARK, 4)
            slide.text(ox + 10, oy + 150, say("valley of equal cost"), 18, LANDMARK, anchor="start")
        else:
            slide.circle(ox, oy, 7, PRIOR)
            slide.text(ox + 16, oy + 150, say("prior"), 18, PRIOR, anchor="start")


@FIGURES.figure(1060, 250, "Blocks of the prior edge")
def prior_edge(slide, tables, say):
    """Its Jacobian, whose columns have the increment's order, and its information, which has the residual's throughout."""
    cell, top, residual = 30, 50, (say("rotation"), say("translation"))
    crossed = np.block([[np.zeros((3, 3)), np.ones((3, 3))], [np.eye(3), np.zeros((3, 3))]])
    for left, name, filled, columns in ((240, "J", crossed, ("δp", "δθ")), (740, "W", np.eye(6), ())):
        slide.text(left - 150, top + 3 * cell + 8, name, 26, italic=True)
        for row, column in np.argwhere(filled):
            slide.rect(left + column * cell + 1, top + row * cell + 1, cell - 2, cell - 2, mix(PRIOR if row < 3 else POSE, 0.6), radius=3)
        slide.rect(left, top, 6 * cell, 6 * cell, stroke=MUTED)
        for half, name in enumerate(columns):
            slide.text(left + (1.5 + 3 * half) * cell, top - 12, name, 20, MUTED)
        for half, name in enumerate(residual):
            slide.text(left - 12, top + (1.5 + 3 * half) * cell + 6, name, 20, MUTED, anchor="end")


@FIGURES.figure(820, 390, "The scene before and after")
def scene(slide, tables, say):
    """The large scene: start and result against the truth."""
    names = "mono_ba_frames", "mono_ba_points", "mono_ba_summary"
    before_and_after(slide.figure, *(tables(name, scene="large") for name in names), say)


@FIGURES.figure(1000, 460, "H and its Schur complement")
def sparsity(slide, tables, say):
    """Of the course's scene, from the solver."""
    axes = [slide.axes((left, 55, 380, 380)) for left in (70, 560)]
    hessian.pair(axes, tables("hessian", scene="course"), say, "HS")


@FIGURES.figure(1100, 400, "Cost and damping per iteration")
def convergence(slide, tables, say):
    """Of the course's scene."""
    panels = {column: slide.axes((90 + 540 * k, 45, 420, 280), title=say(column), below=say("iteration"))
              for k, column in enumerate(("cost", "lambda"))}
    curves(panels, tables("mono_ba_trace", scene="course"), marker="o")
    for axes in panels.values():
        axes.set_ylim(decades(axes.get_ylim())[[0, -1]])


@FIGURES.figure(1000, 300, "Eigenvalues of H")
def spectrum(slide, tables, say):
    """With a free gauge and with the smallest prior that holds it."""
    axes = slide.axes((200, 15, 780, 215))
    hessian.eigenvalues(axes, tables("spectrum"), {"free": say("gauge free"), "minimal prior": say("pose 0 and scale held")}, say)


def side_view(slide, box, tables, state, color):
    """The course's scene from the side, x to the right and z up: truth in gray, `state` in color."""
    axes = slide.axes(box, (-5.5, 5.5), (-1.2, 9.8))
    axes.set_axis_off()
    for which, shade, size in (("truth", mix(INK, 0.25), 18), (state, LANDMARK, 10.8)):
        rows = tables("mono_ba_points", scene="course", state=which)
        axes.plot(rows["x_m"], rows["z_m"], ".", color=shade, markersize=size, markeredgewidth=0)
    rows = tables("mono_ba_frames", scene="course", state=state)
    axes.plot(rows["x_m"], rows["z_m"] + 0.35, "v", color=mix(color, 0.3), markeredgecolor=color, markersize=15)


@FIGURES.figure(1180, 330, "From a noisy start to a solved bundle adjustment")
def overview(slide, tables, say):
    """The guide's picture: start, H, Schur complement, result of the course's scene."""
    H, S = (dense(tables("hessian", scene="course", matrix=name)) for name in "HS")
    slide.rect(0, 0, 1180, 330, PAPER)
    side_view(slide, (20, 25, 250, 250), tables, "initial", PRIOR)
    slide.cells(330, 40, 220, H)
    slide.cells(645, 40 + (220 - 200) / 2, 200, S)
    side_view(slide, (915, 25, 250, 250), tables, "final", POSE)
    for x in (275, 578, 873):
        slide.line(x, 150, x + 36, 150, arrow=True)
    slide.text(145, 305, say("start"))
    slide.formula(440, 305, r"H = \Sigma\, J^T W J", 17)
    slide.formula(745, 305, r"H_{pp} - H_{pm}\, H_{mm}^{-1} H_{mp}", 17)
    slide.text(1040, 305, say("result, aligned"))
