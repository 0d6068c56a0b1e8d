"""Block pictures of the chapter, computed from a toy graph: three poses, six landmarks, one edge per view.

Nothing is placed by hand that the algebra decides: which blocks of H are filled, where an edge writes, what the Schur
complement fills in, how rows and columns move, all follow from the list of edges in toy.py.
"""

import re
from math import cos, pi as PI, sin

from ..svg import CROSS, FAINT, INK, LANDMARK, MUTED, POSE, PRIOR, Svg, mix
from .toy import (EDGES, LANDMARKS, POSES, POSE_WIDTH, chain, decimal, ordering, pattern, schur_pattern, vertices, width)

WORDS = {
    "en": {"poses": "poses", "landmarks": "landmarks", "graph": "graph", "ordering": "ordering", "what": "what",
           "where": "where", "accept": "better?", "no": "no: larger λ", "yes": "yes: linearise again", "goes": "goes",
           "measured": "measured", "prior": "prior", "valley": "valley of equal cost", "pinned": "pinned",
           "before": "before", "rows": "rows moved", "columns": "columns moved", "remain": "what remains",
           "first": "write of 1.1a", "mirror": "write of 1.1b", "edge": "one edge", "zero": "0"},
    "zh": {"poses": "位姿", "landmarks": "路标点", "graph": "图", "ordering": "排序", "what": "是什么",
           "where": "在哪里", "accept": "更好吗？", "no": "否：增大 λ", "yes": "是：重新线性化", "goes": "离开",
           "measured": "观测", "prior": "先验", "valley": "等代价的山谷", "pinned": "钉住",
           "before": "移动之前", "rows": "移行", "columns": "移列", "remain": "留下的部分",
           "first": "1.1a 写入", "mirror": "1.1b 写入", "edge": "一条边", "zero": "0"},
}


def colour(a, b):
    return POSE if a[0] == b[0] == "p" else LANDMARK if a[0] == b[0] == "l" else CROSS


def draw_matrix(svg, x, y, cell, counts, total, place=None, outline=True):
    place = place or ordering()
    strongest = max(counts.values())
    for (a, b), count in sorted(counts.items()):
        strength = 0.35 + 0.55 * count / strongest
        svg.rect(x + place[b] * cell + 1, y + place[a] * cell + 1, width(b) * cell - 2, width(a) * cell - 2,
                 mix(colour(a, b), strength), radius=3)
    if outline:
        svg.rect(x, y, total * cell, total * cell, stroke=MUTED, radius=3, stroke_width=1.2)


def label_axes(svg, x, y, cell, names=True):
    for vertex, start in ordering().items():
        name = ("x" if vertex[0] == "p" else "ℓ") + "₀₁₂₃₄₅"[vertex[1]]
        middle = (start + width(vertex) / 2) * cell
        shade = POSE if vertex[0] == "p" else LANDMARK
        svg.text(x + middle, y - 10, name, 17, shade, italic=True)
        svg.text(x - 10, y + middle + 6, name, 17, shade, anchor="end", italic=True)


def graph_and_hessian(lang):
    """The factor graph on the left, the matrix that it makes on the right."""
    words = WORDS[lang]
    svg = Svg(1130, 430, "Factor graph and Hessian")
    pose_at = {n: (110 + 175 * n, 95) for n in range(POSES)}
    landmark_at = {k: (50 + 94 * k, 340) for k in range(LANDMARKS)}
    for landmark, host, target in EDGES:
        lx, ly = landmark_at[landmark]
        px, py = pose_at[target]
        fx, fy = lx + 0.45 * (px - lx), ly + 0.45 * (py - ly)
        for ex, ey in ((lx, ly), (px, py), pose_at[host]):
            svg.line(fx, fy, ex, ey, FAINT if (ex, ey) == pose_at[host] else mix(CROSS, 0.8), 1.6)
        svg.rect(fx - 5, fy - 5, 10, 10, INK)
    for n, (x, y) in pose_at.items():
        svg.circle(x, y, 27, mix(POSE, 0.25), POSE, 2)
        svg.text(x, y + 7, "x" + "₀₁₂"[n], 21, italic=True)
    for k, (x, y) in landmark_at.items():
        svg.circle(x, y, 19, mix(LANDMARK, 0.25), LANDMARK, 2)
        svg.text(x, y + 6, "ℓ" + "₀₁₂₃₄₅"[k], 18, italic=True)
    svg.text(285, 36, words["poses"], 19, POSE)
    svg.text(285, 405, words["landmarks"], 19, LANDMARK)
    svg.line(590, 215, 655, 215, arrow=True)
    label_axes(svg, 725, 45, 24)
    draw_matrix(svg, 725, 45, 24, pattern(), 15)
    return svg.render()


def one_edge(lang):
    """The nine blocks that one reprojection edge writes; a by TODO 1.1a, b by 1.1b."""
    words = WORDS[lang]
    edge = (2, 0, 1)
    svg = Svg(620, 420, "The nine blocks of one edge")
    x, y, cell = 60, 40, 24
    place, listed = ordering(), vertices(edge)
    label_axes(svg, x, y, cell)
    for i, a in enumerate(listed):
        for j, b in enumerate(listed):
            direct = i <= j
            left, top = x + place[b] * cell, y + place[a] * cell
            svg.rect(left + 1, top + 1, width(b) * cell - 2, width(a) * cell - 2,
                     mix(colour(a, b), 0.85 if direct else 0.3), radius=3)
            svg.text(left + width(b) * cell / 2, top + width(a) * cell / 2 + 6, "a" if direct else "b", 17,
                     "#ffffff" if direct else INK, weight="bold")
    svg.rect(x, y, 15 * cell, 15 * cell, stroke=MUTED, radius=3, stroke_width=1.2)
    svg.line(x, y, x + 15 * cell, y + 15 * cell, FAINT, 1.2, "4 5")
    for row, (mark, name, strength) in enumerate((("a", "first", 0.85), ("b", "mirror", 0.3))):
        top = 150 + 46 * row
        svg.rect(440, top, 26, 26, mix(POSE, strength), radius=3)
        svg.text(453, top + 19, mark, 17, "#ffffff" if row == 0 else INK, weight="bold")
        svg.text(476, top + 19, words[name], 15, anchor="start")
    return svg.render()


def schur(lang):
    """H, then the reduced system of the poses with its fill-in."""
    words = WORDS[lang]
    svg = Svg(1080, 400, "The Schur complement")
    cell = 22
    draw_matrix(svg, 40, 35, cell, pattern(), 15)
    corner = POSES * POSE_WIDTH * cell
    svg.line(40, 35 + corner, 40 + 15 * cell, 35 + corner, INK, 1.2)
    svg.line(40 + corner, 35, 40 + corner, 35 + 15 * cell, INK, 1.2)
    wide = LANDMARKS * cell
    for i, j, name in ((0, 0, "H_pp"), (0, 1, "H_pm"), (1, 0, "H_mp"), (1, 1, "H_mm")):
        left, top = 40 + (corner if j else 0), 35 + (corner if i else 0)
        subscript(svg, left + (wide if j else corner) / 2, top + (wide if i else corner) / 2 + 7, name, 22)
    svg.text(40 + corner / 2, 390, words["poses"], 17, POSE)
    svg.text(40 + corner + wide / 2, 390, words["landmarks"], 17, LANDMARK)
    svg.line(405, 200, 465, 200, arrow=True)
    draw_matrix(svg, 500, 35 + 66, cell, schur_pattern(), 9)
    subscript(svg, 500 + corner / 2, 335, "H_pp − H_pm H_mm⁻¹ H_mp", 20)
    added = [pair for pair in schur_pattern() if pair not in pattern()]
    for a, b in added:
        left, top = 500 + ordering()[b] * cell, 101 + ordering()[a] * cell
        svg.rect(left + 4, top + 4, POSE_WIDTH * cell - 8, POSE_WIDTH * cell - 8, stroke=PRIOR, radius=3,
                 stroke_width=2, stroke_dasharray="5 4")
    svg.line(735, 200, 795, 200, arrow=True)
    for k in range(LANDMARKS):
        svg.rect(840 + k * 32, 101 + k * 33, 26, 26, mix(LANDMARK, 0.8), radius=3)
    subscript(svg, 935, 335, "H_mm Δx_m = b_m − H_mp Δx_p", 20)
    return svg.render()


def subscript(svg, x, y, words, size):
    """Text in which _pp, _m … is set low and ⁻¹ is set high, as on paper; a white rim keeps it legible on blocks."""
    small, low, high, out = round(size * 0.66), round(size * 0.26), round(size * 0.36), ""
    for plain, letters, inverse in re.findall(r"([^_⁻]+)(?:_([pmr]+))?(⁻¹)?", words):
        out += f'<tspan font-style="italic">{plain}</tspan>'
        for mark, shift in ((letters, low), (inverse and "−1", -high)):
            if mark:
                out += f'<tspan font-size="{small}" dy="{shift}">{mark}</tspan><tspan dy="{-shift}">\u200b</tspan>'
    svg.add("text", text=out, x=x, y=y, font_size=size, fill=INK, text_anchor="middle", stroke="#ffffff",
            stroke_width=5, paint_order="stroke", stroke_linejoin="round")


def heat(svg, x, y, cell, rows, names):
    largest = max(abs(v) for row in rows for v in row)
    for i, row in enumerate(rows):
        for j, value in enumerate(row):
            base = POSE if value > 0 else PRIOR
            shade = mix(base, 0.08 + 0.5 * float(abs(value) / largest)) if value else "#ffffff"
            svg.rect(x + j * cell + 1, y + i * cell + 1, cell - 2, cell - 2, shade, FAINT, radius=4)
            svg.text(x + (j + 0.5) * cell, y + (i + 0.5) * cell + 7, decimal(value), 19, mono=False)
        svg.text(x - 12, y + (i + 0.5) * cell + 7, names[i], 19, MUTED, anchor="end", italic=True)
        svg.text(x + (i + 0.5) * cell, y - 12, names[i], 19, MUTED, italic=True)


def chain_heat(lang):
    """The 3×3 example before and after, as a heat map with its numbers."""
    words = WORDS[lang]
    svg = Svg(1060, 380, "Marginalising the middle of a chain")
    H, prior = chain()
    for n, (x, colour_) in enumerate(((70, POSE), (200, PRIOR), (330, POSE))):
        svg.circle(x, 60, 25, mix(colour_, 0.2), colour_, 2)
        svg.text(x, 67, "x" + "₀₁₂"[n], 20, italic=True)
    for x1, x2 in ((95, 175), (225, 305)):
        svg.line(x1, 60, x2, 60, INK, 2)
        svg.rect((x1 + x2) / 2 - 6, 54, 12, 12, INK)
    svg.line(200, 85, 200, 125, INK, 2)
    svg.rect(194, 119, 12, 12, INK)
    svg.text(200, 27, words["goes"], 17, PRIOR)
    for n, x in ((0, 70), (2, 330)):
        svg.circle(x, 290, 25, mix(POSE, 0.2), POSE, 2)
        svg.text(x, 297, "x" + "₀₁₂"[n], 20, italic=True)
    svg.line(95, 290, 305, 290, PRIOR, 2)
    svg.rect(192, 282, 16, 16, PRIOR)
    svg.text(200, 330, words["prior"], 17, PRIOR)
    svg.line(200, 160, 200, 235, arrow=True)
    heat(svg, 450, 60, 98, H, ["x₀", "x₁", "x₂"])
    svg.line(760, 207, 800, 207, arrow=True)
    heat(svg, 850, 109, 98, prior, ["x₀", "x₂"])
    return svg.render()


def moves(lang):
    """Stage 2: where rows and columns go, for a variable in the middle of five."""
    words = WORDS[lang]
    n, idx = 5, 1
    order = [k for k in range(n) if k != idx] + [idx]
    steps = ((range(n), range(n), "before"), (order, range(n), "rows"), (order, order, "columns"))
    svg = Svg(1080, 310, "Moving a variable to the end")
    cell = 42
    for step, (rows, columns, name) in enumerate(steps):
        x, y = 50 + step * 360, 50
        for i, row in enumerate(rows):
            for j, column in enumerate(columns):
                hit = (row == idx) + (column == idx)
                shade = mix(POSE, 0.16) if hit == 0 else mix(PRIOR, 0.3 if hit == 1 else 0.65)
                svg.rect(x + j * cell + 1, y + i * cell + 1, cell - 2, cell - 2, shade, radius=3)
            svg.text(x - 12, y + (i + 0.5) * cell + 6, row, 17, PRIOR if row == idx else MUTED, anchor="end")
        for j, column in enumerate(columns):
            svg.text(x + (j + 0.5) * cell, y - 9, column, 17, PRIOR if column == idx else MUTED)
        svg.text(x + n * cell / 2, y + n * cell + 34, words[name], 18)
        if step < 2:
            svg.line(x + n * cell + 40, y + n * cell / 2, x + n * cell + 90, y + n * cell / 2, arrow=True)
    return svg.render()


def river(lang):
    """The chapter's flow of values, one box a step."""
    words = WORDS[lang]
    svg = Svg(1130, 270, "From graph to step")
    boxes = [("Graph", words["what"]), ("Ordering", words["where"]), ("MakeHessian", "H, b"),
             ("SolveLinearSystem", "(H + λD) Δx = b"), ("UpdateStates", "x ⊞ Δx"), (words["accept"], "ρ")]
    wide = [105, 130, 165, 235, 165, 120]
    x, places = 15, []
    for (name, below), w in zip(boxes, wide):
        graded = name in ("MakeHessian", "SolveLinearSystem")
        shade = LANDMARK if graded else POSE
        svg.rect(x, 85, w, 74, mix(shade, 0.18), shade, radius=10, stroke_width=1.6)
        svg.text(x + w / 2, 117, name, 19, weight="bold")
        svg.text(x + w / 2, 143, below, 16, MUTED)
        places.append((x, w))
        x += w + 38
    for (x1, w), (x2, _) in zip(places, places[1:]):
        svg.line(x1 + w + 4, 122, x2 - 5, 122, arrow=True)
    last, solve, make = places[5], places[3], places[2]
    for target, y, name in ((solve, 40, words["no"]), (make, 215, words["yes"])):
        edge = 80 if y < 122 else 164
        right, left = last[0] + last[1] / 2, target[0] + target[1] / 2
        svg.path(f"M{right} {edge} V{y} H{left} V{edge + (1 if y < 122 else -1)}", arrow=True)
        svg.text((right + left) / 2, y + (-10 if y < 122 else 24), name, 16, MUTED)
    return svg.render()


def valley(lang):
    """Cost of two scalars a, b with b − a measured, without and with a prior on a: level lines of the quadratic."""
    words = WORDS[lang]
    svg = Svg(900, 365, "A free gauge is a valley")
    for panel, weight in enumerate((0.0, 0.35)):
        ox, oy, unit = 215 + 450 * panel, 180, 62
        for level in (0.15, 0.6, 1.5):
            if weight == 0.0:  # (b − a)² = level: two straight lines
                for sign in (1, -1):
                    shift = sign * level ** 0.5 / 2
                    svg.line(ox - (2.3 + shift) * unit, oy + (2.3 - shift) * unit,
                             ox + (2.3 - shift) * unit, oy - (2.3 + shift) * unit, mix(POSE, 0.75), 1.8)
            else:  # (b − a)² + w a² = level: a = √(level/w) cos t, b = a + √level sin t
                points = []
                for step in range(97):
                    t = 2 * PI * step / 96
                    a = (level / weight) ** 0.5 * cos(t)
                    points.append((ox + a * unit, oy - (a + level ** 0.5 * sin(t)) * unit))
                svg.polyline(points, mix(POSE, 0.75), 1.8)
        if weight == 0.0:
            svg.line(ox - 2.3 * unit, oy + 2.3 * unit, ox + 2.3 * unit, oy - 2.3 * unit, LANDMARK, 4)
            svg.text(ox + 10, oy + 150, words["valley"], 18, LANDMARK, anchor="start")
        else:
            svg.circle(ox, oy, 7, PRIOR)
            svg.text(ox + 16, oy + 150, words["prior"], 18, PRIOR, anchor="start")
    return svg.render()


ALL = {"graph": graph_and_hessian, "one_edge": one_edge, "schur": schur, "chain": chain_heat, "moves": moves,
       "river": river, "valley": valley}
