"""Pictures of structure: g2o's classes, its memory, our four values, lanes and groups."""

from ..deck1.toy import LANDMARKS, POSES, EDGES
from ..svg import CROSS, FAINT, INK, LANDMARK, MUTED, POSE, PRIOR, Svg, mix

WORDS = {
    "en": {"graph": "unknowns, measurements", "algorithm": "how far", "block": "H, b, Schur complement",
           "linear": "S Δx = b", "choice": "you choose", "vertex": "vertices", "edge": "edges", "lies": "what lies where; once",
           "linearize": "linearise", "eliminate": "eliminate", "solve": "solve, go back", "one": "one edge at a time",
           "eight": "eight edges at a time", "residual": "residual", "lane": "lane", "landmarks": "landmarks, sorted by who sees them",
           "group": "one group, one product", "owned": "H_pp, H_pl, H_ll in one block matrix", "points": "an edge knows its places"},
    "zh": {"graph": "未知量与观测", "algorithm": "走多远", "block": "H、b、舒尔补", "linear": "S Δx = b", "choice": "由你选择",
           "vertex": "顶点", "edge": "边", "lies": "什么放在哪里；只做一次", "linearize": "线性化", "eliminate": "消元",
           "solve": "求解，回代", "one": "一次一条边", "eight": "一次八条边", "residual": "残差", "lane": "通道",
           "landmarks": "路标点，按被谁看到排序", "group": "一组只做一次乘积", "owned": "块矩阵中的 H_pp、H_pl、H_ll",
           "points": "每条边知道自己的位置"},
}


def box(svg, x, y, width, name, below, colour, strong=False):
    svg.rect(x, y, width, 78, mix(colour, 0.28 if strong else 0.14), colour, radius=10, stroke_width=2.2 if strong else 1.5)
    svg.text(x + width / 2, y + 34, name, 19, weight="bold")
    svg.text(x + width / 2, y + 60, below, 15, MUTED)


def g2o(_, lang):
    """Who owns whom in g2o; the three choices of the user in strong colours."""
    words = WORDS[lang]
    svg = Svg(1130, 330, "g2o's classes")
    box(svg, 20, 40, 250, "SparseOptimizer", words["graph"], POSE)
    box(svg, 330, 40, 250, "OptimizationAlgorithm", words["algorithm"], CROSS, True)
    box(svg, 640, 40, 220, "BlockSolver<p, l>", words["block"], CROSS, True)
    box(svg, 920, 40, 190, "LinearSolver", words["linear"], CROSS, True)
    for x in (272, 582, 862):
        svg.line(x, 79, x + 54, 79, arrow=True)
    box(svg, 20, 210, 115, "Vertex", "oplusImpl", LANDMARK)
    box(svg, 155, 210, 115, "Edge", "computeError", LANDMARK)
    for x in (78, 212):
        svg.line(x, 120, x, 206, arrow=True)
    for x, name in ((455, "GN · LM · Dogleg"), (750, "6 × 3, 3 × 2, dynamic"), (1015, "PCG · CSparse · Cholmod")):
        svg.text(x, 160, name, 16, CROSS)
    svg.path("M330 190 H1110", CROSS, 1.6)
    svg.text(720, 222, words["choice"], 18, CROSS)
    return svg.render()


def mapping(_, lang):
    """One edge of the toy graph and the blocks of H that it keeps the addresses of; the vertices keep their diagonal ones."""
    words = WORDS[lang]
    svg = Svg(1060, 360, "g2o's mapped memory")
    cell, left, top = 22, 600, 30
    size = POSES * 3 + LANDMARKS
    for k in range(POSES + LANDMARKS):
        start, wide = (3 * k, 3) if k < POSES else (3 * POSES + k - POSES, 1)
        svg.rect(left + start * cell + 1, top + start * cell + 1, wide * cell - 2, wide * cell - 2,
                 mix(POSE if k < POSES else LANDMARK, 0.3), radius=3)
    landmark, host, target = EDGES[3]
    svg.rect(left, top, size * cell, size * cell, stroke=MUTED, radius=3)
    l_at = 3 * POSES + landmark
    targets = ((3 * host, l_at, 3, 1, CROSS), (3 * target, l_at, 3, 1, CROSS), (3 * host, 3 * target, 3, 3, POSE))
    for k, (row, column, tall, wide, colour) in enumerate(targets):
        x, y = left + column * cell, top + row * cell
        svg.rect(x + 1, y + 1, wide * cell - 2, tall * cell - 2, mix(colour, 0.9), radius=3)
        svg.path(f"M340 {120 + 40 * k} C 480 {120 + 40 * k} 480 {y + tall * cell / 2} {x - 4} {y + tall * cell / 2}", PRIOR, 1.6,
                 arrow=True)
    svg.rect(110, 90, 230, 140, mix(INK, 0.06), INK, radius=10)
    svg.text(225, 80, words["edge"], 18)
    for k, name in enumerate(("_hessian[0]", "_hessian[1]", "_hessian[2]")):
        svg.text(225, 126 + 40 * k, name, 17, mono=True)
    svg.text(225, 275, words["points"], 17, PRIOR)
    svg.text(225, 303, words["owned"], 16, MUTED)
    return svg.render()


def flow(_, lang):
    """Our four values and the functions between them."""
    words = WORDS[lang]
    svg = Svg(1130, 190, "Structure, Linearized, Eliminated, Step")
    names = (("Structure", words["lies"], POSE), ("Linearized", "H_pp, H_pl, H_ll, b", LANDMARK),
             ("Eliminated", "H_ll⁻¹, S, b_S", CROSS), ("Step", "Δx", PRIOR))
    for k, (name, below, colour) in enumerate(names):
        box(svg, 10 + 296 * k, 70, 222, name, below, colour)
    for k, name in enumerate(("linearize", "eliminate", "solve")):
        svg.line(236 + 296 * k, 109, 300 + 296 * k, 109, arrow=True)
        svg.text(268 + 296 * k, 50, words[name], 17, MUTED)
    return svg.render()


def lanes(_, lang):
    """The numbers of eight edges, one after the other and side by side."""
    words = WORDS[lang]
    svg = Svg(1080, 330, "Lanes")
    shades = [mix(colour, 0.75) for colour in (POSE, LANDMARK, CROSS, PRIOR)] + [
        mix(colour, 0.4) for colour in (POSE, LANDMARK, CROSS, PRIOR)]
    for panel, name in enumerate(("one", "eight")):
        left = 60 + 540 * panel
        svg.text(left + 200, 40, words[name], 19)
        for row in range(5):
            for column in range(8):
                item = (row * 8 + column) // 5 if panel == 0 else column
                svg.rect(left + 50 * column, 70 + 42 * row, 47, 38, shades[item], radius=4)
                if panel == 1 and row == 0:
                    svg.text(left + 50 * column + 24, 312, column, 16, MUTED)
        if panel == 1:
            svg.rect(left - 6, 70 + 42 * 2 - 3, 8 * 50 + 9, 44, stroke=INK, radius=6, stroke_width=2.2)
            svg.text(left - 14, 312, words["lane"], 16, MUTED, anchor="end")
    return svg.render()


def groups(_, lang):
    """The toy's landmarks sorted by the poses that see them: neighbours change the same blocks of S."""
    words = WORDS[lang]
    svg = Svg(1080, 360, "Groups of landmarks")
    seen = {k: tuple(sorted({p for l, host, target in EDGES for p in (host, target) if l == k})) for k in range(LANDMARKS)}
    order = sorted(seen, key=lambda k: (seen[k], k))
    kinds = sorted(set(seen.values()))
    shades = dict(zip(kinds, (LANDMARK, CROSS, PRIOR)))
    cell = 34
    for column, landmark in enumerate(order):
        x = 70 + column * cell
        for pose in seen[landmark]:
            svg.rect(x + 2, 60 + pose * 3 * cell * 0.75 + 2, cell - 4, 3 * cell * 0.75 - 4, mix(shades[seen[landmark]], 0.75), radius=3)
        svg.text(x + cell / 2, 48, "ℓ" + "₀₁₂₃₄₅"[landmark], 17, shades[seen[landmark]], italic=True)
    for pose in range(POSES):
        svg.text(56, 60 + (pose + 0.5) * 3 * cell * 0.75 + 6, "x" + "₀₁₂"[pose], 17, POSE, anchor="end", italic=True)
    svg.text(70 + 3 * cell, 325, words["landmarks"], 17, MUTED)
    for k, kind in enumerate(kinds):
        left, size = 380 + 240 * k, 60
        for a in range(POSES):
            for b in range(POSES):
                inside = a in kind and b in kind and a >= b
                svg.rect(left + b * size + 2, 70 + a * size + 2, size - 4, size - 4,
                         mix(shades[kind], 0.75) if inside else mix(INK, 0.05), radius=4)
        svg.text(left + 1.5 * size, 288, "S −= A Aᵀ", 18, shades[kind], italic=True)
    svg.text(380 + 330, 325, words["group"], 17, MUTED)
    return svg.render()


ALL = {"g2o": g2o, "mapping": mapping, "flow": flow, "lanes": lanes, "groups": groups}
