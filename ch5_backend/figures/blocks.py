"""H and its Schur complement block by block: which vertices and edges made each, as ch5_chapter wrote it
from the graph."""

import json

import numpy as np
from markupsafe import Markup

from . import page
from .tables import dense, read

LEVELS = 8  # of magnitude, a decade each
WHAT = {"H": "H", "S": "S = H_pp − H_pm H_mm⁻¹ H_mp"}


class Blocks:
    """The tables of a scene: vertices by row, and what added to each block."""

    def __init__(self, directory, scene, say):
        self.say = say
        of = lambda name: read(directory, name).where(scene=scene)
        vertices, edges, blocks = of("hessian_vertices"), of("hessian_edges"), of("hessian_blocks")
        numbers = lambda *names: zip(*(vertices[name].astype(int).tolist() for name in names))
        spans_of = sorted(numbers("vertex", "first_row", "rows"), key=lambda row: row[1])
        self.rows = {vertex: (first, rows) for vertex, first, rows in spans_of}
        kinds, self.numbers = dict(zip(vertices["vertex"], vertices["type"])), dict(numbers("vertex", "number"))
        self.names = {vertex: say(kinds[vertex], number=self.numbers[vertex]) for vertex in self.rows}  # in their order
        self.place = {vertex: i for i, vertex in enumerate(self.names)}
        self.edges = {}  # {edge: its vertices}
        for edge, vertex in zip(edges["edge"], edges["vertex"]):
            self.edges.setdefault(int(edge), []).append(int(vertex))
        self.makers = {}  # {(matrix, i, j): {"edge": […], "landmark": […]}}, i ≥ j
        for cells in zip(*(blocks[name] for name in ("matrix", "row_vertex", "column_vertex", "by", "number"))):
            matrix, i, j, by, number = cells
            self.makers.setdefault((matrix, int(i), int(j)), {}).setdefault(by, []).append(int(number))

    def of(self, matrix):
        """(row vertex, column vertex, makers) of all its blocks, both halves."""
        for (name, i, j), makers in self.makers.items():
            if name == matrix:
                yield i, j, makers
                if i != j:
                    yield j, i, makers

    def name(self, matrix, i, j):
        return self.say("block.name", matrix=matrix, row=self.names[i], column=self.names[j])

    def made_by(self, matrix, makers):
        """The edges and landmarks that made a block, in words."""
        edges, landmarks, parts = makers.get("edge", []), makers.get("landmark", []), []
        if len(edges) == 1:
            vertices = self.say("list").join(self.names[v] for v in self.edges[edges[0]])
            parts.append(self.say("made_by.edge", edge=edges[0], vertices=vertices))
        elif edges:
            parts.append(self.say("made_by.edges", count=len(edges), edges=spans(edges)))
        elif matrix == "S":
            parts.append(self.say("made_by.no_edge"))
        if landmarks:
            numbers = spans(self.numbers[v] for v in landmarks)
            parts.append(self.say("made_by.landmarks", count=len(landmarks), landmarks=numbers))
        return self.say("made_by.all", parts=self.say("semicolon").join(parts))


def spans(numbers):
    """0–3, 5, 7"""
    numbers, found = sorted(numbers), []
    for n in numbers:
        if found and found[-1][1] == n - 1:
            found[-1][1] = n
        else:
            found.append([n, n])
    return ", ".join(f"{a}" if a == b else f"{a}–{b}" for a, b in found)


def entries(matrix, largest):
    """One path a decade of |entry|, the smaller the paler."""
    with np.errstate(divide="ignore"):
        level = np.clip(np.ceil(np.log10(np.abs(matrix) / largest) + LEVELS), 1, LEVELS)
    for k in range(1, LEVELS + 1):
        cells = "".join(f"M{column} {row}h1v1h-1z" for row, column in np.argwhere((level == k) & (matrix != 0)))
        if cells:
            yield f'<path class="entry" fill-opacity="{0.12 + 0.88 * k / LEVELS:.2f}" d="{cells}"/>'


def matrix_svg(blocks, name, matrix, largest):
    """The matrix, a rectangle over each of its blocks, and a cursor."""
    say, size = blocks.say, len(matrix)
    shown = [v for v, (first, _) in blocks.rows.items() if first < size]
    lines = "".join(f"M0 {first}H{size}M{first} 0V{size}" for first, _ in (blocks.rows[v] for v in shown))
    parts = [*entries(matrix, largest), f'<path class="border" d="{lines}"/>']
    for i, j, makers in blocks.of(name):
        (y, height), (x, width) = blocks.rows[i], blocks.rows[j]
        made_of = [f"e{edge}" for edge in makers.get("edge", [])]
        made_of += [f"v{blocks.place[landmark]}" for landmark in makers.get("landmark", [])]
        words = say("block.words", block=blocks.name(name, i, j), made_by=blocks.made_by(name, makers))
        parts.append(Markup('<rect class="block" data-block="{} {}" data-parts="{}" x="{}" y="{}" width="{}" height="{}">'
                            "<title>{}</title></rect>").format(
                                blocks.place[i], blocks.place[j], " ".join(made_of), x, y, width, height, words))
    vertices = json.dumps([(blocks.names[v], *blocks.rows[v]) for v in shown])
    label = say("matrix.alt", what=WHAT[name], rows=size, blocks=len(shown))
    empty = say(f"block.empty.{name}", row="{row}", column="{column}")  # filled in by page.js
    return Markup('<div><p>{}</p><svg class="plot blocks" viewBox="0 0 {} {}" role="img" aria-label="{}" data-empty="{}" '
                  'data-vertices="{}">{}<rect class="cursor"/></svg></div>').format(
                      page.formulas(say("matrix", what=WHAT[name], rows=size)), size, size, label, empty, vertices, Markup("\n".join(parts)))


def map_svg(blocks, directory, scene):
    """Poses and points from above with their edges."""
    frames, points = (read(directory, name).where(scene=scene, state="final") for name in ("mono_ba_frames", "mono_ba_points"))
    x, z = (np.concatenate((frames[axis], points[axis])) for axis in ("x_m", "z_m"))
    scale = 300 / max(np.ptp(x), np.ptp(z))
    spots = dict(zip(blocks.names, np.column_stack((10 + scale * (x - x.min()), 10 + scale * (z.max() - z)))))
    parts = []
    for edge, vertices in blocks.edges.items():
        of = sorted(vertices, key=lambda v: blocks.rows[v][1])  # the landmark between its two poses
        way = "L".join(f"{spots[v][0]:.1f} {spots[v][1]:.1f}" for v in (of[1], of[0], *of[2:]))
        parts.append(f'<path class="edge e{edge}" d="M{way}"/>')
    for vertex, (a, b) in spots.items():
        pose = blocks.rows[vertex][1] > 1
        d = f"M{a - 7:.1f} {b + 6:.1f}h14l-7 -14z" if pose else f"M{a - 4:.1f} {b:.1f}a4 4 0 1 0 8 0a4 4 0 1 0 -8 0"
        parts.append(Markup('<path class="vertex v{}" d="{}"><title>{}</title></path>').format(
            blocks.place[vertex], d, blocks.names[vertex]))
    return Markup('<div><p>{}</p><svg class="plot map" viewBox="0 0 320 {:.0f}" role="img" aria-label="{}">{}</svg></div>').format(
        blocks.say("graph"), scale * np.ptp(z) + 20, blocks.say("graph.alt"), Markup("".join(parts)))


def explorer(directory, scene, say):
    """The figure that answers."""
    blocks = Blocks(directory, scene, say)
    size = sum(rows for _, rows in blocks.rows.values())
    poses = sum(rows for _, rows in blocks.rows.values() if rows > 1)
    table = read(directory, "hessian").where(scene=scene)
    matrices = {name: dense(table.where(matrix=name), n, n) for name, n in (("H", size), ("S", poses))}
    largest = max(np.abs(matrix).max() for matrix in matrices.values())
    drawn = [matrix_svg(blocks, name, matrix, largest) for name, matrix in matrices.items()]
    rows = [(blocks.name(matrix, i, j), page.formulas(blocks.made_by(matrix, makers))) for (matrix, i, j), makers in blocks.makers.items()]
    return page.PIECES.explorer([*drawn, map_svg(blocks, directory, scene)], rows, say)
