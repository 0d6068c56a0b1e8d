"""A wrong matrix in the terminal: a mark for each block of two vertices, as ch5_homework/judge/diagnosis.cc reports its entries."""

import json
from itertools import groupby

from ..base.language import Speaker, pad, width

MARK = {"x": "✗", "o": "■", ".": "·"}  # wrong, not zero, zero
MOST = 24  # vertices


def vertices(names: list) -> list:
    """[(vertex, its first row, the row after its last)]"""
    of = [name.get("vertex", name) if isinstance(name, dict) else name for name in names]
    found = []
    for vertex, rows in groupby(range(len(of)), key=of.__getitem__):
        rows = list(rows)
        found.append((vertex, rows[0], rows[-1] + 1))
    return found


def block_map(test: dict, say: Speaker) -> list:
    """Lines, each with the vertex of its rows; [] where blocks would tell no more than the rest, or not fit."""
    entries = test.get("picture", "").split("/")
    names = json.loads(test.get("rows", "[]"))
    rows, columns = vertices(names), vertices(json.loads(test.get("columns", "[]")) or names)
    if len(names) != len(entries) or not 1 < len(rows) <= MOST or not columns or columns[-1][2] != len(entries[0]) or len(columns) > MOST:
        return []
    marks = [[next(mark for mark in "xo." if any(mark in entries[i][left:right] for i in range(top, bottom)))
              for _, left, right in columns] for _, top, bottom in rows]
    if all(mark == "x" for row in marks for mark in row):
        return []
    labels = [say.text(vertex) for vertex, _, _ in rows]
    wide = max(map(width, labels))
    return [f"{pad(label, wide)}  {' '.join(MARK[mark] for mark in row)}" for label, row in zip(labels, marks)]
