"""Figures of the homework's pages, from no tables, and the README's race. slides/build.py --overview writes them beside the guide's picture."""

from pathlib import Path

import numpy as np

from ch5_backend.figures.slide import CROSS, FAINT, LANDMARK, MUTED, POSE, PRIOR, Figures, mix
from ch5_backend.figures.tables import Tables

MEASURED = Tables(Path(__file__).with_name("measured"))
FIGURES = Figures({"bal/49-7776": "49 cameras (BAL)", "window/real_euroc_sub2": "IMU window (EuRoC)", "pose_graph/intel": "pose graph (Intel)"})


def blocks(slide, x, y, sizes, cells, names):
    """A matrix of square blocks, `sizes` pixels wide; cells are {(row, column): (color, formula)}."""
    at = np.cumsum([0, *sizes])
    middles = at[:-1] + np.array(sizes) / 2
    for (i, j), (color, tex) in cells.items():
        slide.rect(x + at[j] + 1, y + at[i] + 1, sizes[j] - 2, sizes[i] - 2, mix(color, 0.45), radius=3)
        slide.formula(x + middles[j], y + middles[i] + 6, tex, 17)
    for name, middle in zip(names, middles):
        slide.text(x + middle, y - 10, name, 18, italic=True)
        slide.text(x - 12, y + middle + 6, name, 18, anchor="end", italic=True)
    slide.rect(x, y, at[-1], at[-1], stroke=MUTED)


def graph(slide, say, nodes, edges, radius=21):
    """Nodes {name: (x, y, color)}, and edges (from, to, formula) with the formula on them."""
    for a, b, tex in edges:
        (x1, y1, color), (x2, y2, _) = nodes[a], nodes[b]
        slide.line(x1, y1, x2, y2, color, 2.2)
        if tex:
            slide.formula((x1 + x2) / 2, (y1 + y2) / 2 - 8, tex, 18)
    for name, (x, y, color) in nodes.items():
        slide.circle(x, y, radius, mix(color, 0.25), color, 2)
        slide.text(x, y + 6, say(name), 18)


@FIGURES.figure(820, 330, "A new block in H")
def insert(slide, tables, say):
    """Stage 5.1: a pose goes between the dense part and the landmarks, a landmark to the end."""
    for x, a, new, b, names, words in ((70, 0, 1, 2, ("idx", "dim", "tail"), "a new pose"), (490, 0, 2, 1, ("", "", "dim"), "a new landmark")):
        cells = {(a, a): (POSE, "H_{00}"), (a, b): (CROSS, "H_{01}"), (b, a): (CROSS, "H_{01}^T"), (b, b): (LANDMARK, "H_{11}"), (new, new): (PRIOR, "+")}
        blocks(slide, x, 30, np.insert([120, 90], new, 50), cells, names)
        slide.text(x + 130, 318, say(words), 18)


@FIGURES.figure(860, 250, "Which frame leaves the window")
def flags(slide, tables, say):
    """Stage 6B: what each flag removes, and the IMU interval that replaces two."""
    for y, name, leaves in ((66, "MARGIN_OLD", 0), (186, "MARGIN_SECOND_NEW", 9)):
        slide.text(30, y - 38, name, 18, anchor="start", weight="bold")
        graph(slide, str, {k: (50 + 76 * k, y, PRIOR if k == leaves else POSE) for k in range(11)}, [(k, k + 1, "") for k in range(10) if leaves not in (k, k + 1)])
        slide.text(50 + 76 * leaves, y + 42, say("leaves"), 17, PRIOR)
    slide.polyline([(672, 170), (734, 122), (796, 170)], POSE, 2.2, curved=True)
    slide.text(734, 136, "IMU", 17)


@FIGURES.figure(760, 330, "The blocks of H that exist, and those of S")
def few_blocks(slide, tables, say):
    """Stage 7: landmark l is seen by the poses i and j, m by j and k."""
    H = {"ii": POSE, "jj": POSE, "kk": POSE, "il": CROSS, "jl": CROSS, "jm": CROSS, "km": CROSS, "ll": LANDMARK, "mm": LANDMARK}
    S = {"ii": POSE, "jj": POSE, "kk": POSE, "ji": PRIOR, "kj": PRIOR}
    for x, y, name, sizes, filled in ((60, 40, "H", [62] * 3 + [44] * 2, H), (500, 84, "S", [62] * 3, S)):
        cells = {("ijklm".index(a), "ijklm".index(b)): (color, f"{name}_{{{a}{b}}}") for (a, b), color in filled.items()}
        blocks(slide, x, y, sizes, cells, "ijklm")
    slide.line(370, 177, 430, 177, arrow=True)
    slide.text(700, 182, say("new"), 18, PRIOR, anchor="start")


@FIGURES.figure(560, 395, "What is known of one number of two")
def marginal(slide, tables, say):
    """The covariance (1 1; 1 2): the ellipse's shadow is x₁ with x₂ integrated out, its chord is x₁ with x₂ known."""
    turn, unit, x, y = np.linspace(0, 2 * np.pi, 97), 95, 180, 175
    slide.polyline(np.column_stack((x + unit * np.cos(turn), y - unit * (np.cos(turn) + np.sin(turn)))), POSE)
    for half, below, color, words in ((1, 180, POSE, "x₂ unknown"), (0.5 ** 0.5, 0, PRIOR, "x₂ known")):
        slide.line(x - half * unit, y + below, x + half * unit, y + below, color, 5)
        slide.text(310, y + below + 6, f"{say(words)}: σ = {half:.2g}", 18, color, anchor="start")
    for side in (-unit, unit):
        slide.line(x + side, y - side, x + side, y + 180, FAINT, 1.5, "4 4")
    slide.text(x, y + 206, "x₁", 18)


@FIGURES.figure(700, 290, "The example on paper")
def on_paper(slide, tables, say):
    """Two poses, two landmarks, four edges and a prior."""
    nodes = {"prior": (60, 145, PRIOR), "x₀": (250, 145, POSE), "x₁": (650, 145, POSE), "l₀": (450, 40, LANDMARK), "l₁": (450, 250, LANDMARK)}
    graph(slide, say, nodes, (("prior", "x₀", "1,\\ W = 1"), ("x₀", "l₀", "2.4,\\ W = 2"), ("x₁", "l₀", "2.6,\\ W = 2"), ("x₀", "l₁", "4.4,\\ W = 3"),
                              ("x₁", "l₁", "2.8,\\ W = 6")), 26)


@FIGURES.figure(760, 370, "World, body, camera, antenna and beacon")
def open_tasks(slide, tables, say):
    """Stages 8b and 8d: what is measured from where."""
    nodes = {"world": (60, 310, POSE), "body": (310, 240, POSE), "camera": (470, 190, POSE), "antenna": (250, 100, POSE), "landmark": (690, 70, LANDMARK),
             "beacon": (60, 60, PRIOR)}
    graph(slide, say, nodes, (("world", "body", "p"), ("body", "camera", "p_{BC}"), ("body", "antenna", "a"), ("landmark", "camera", "p_C"),
                              ("beacon", "antenna", r"\mathtt{range}")), 42)


@FIGURES.figure(1180, 330, "Cost over time, ours and Ceres at its best")
def race(slide, tables, say):
    """How far each side is above the least cost that either has found."""
    rows = MEASURED("speed_traces")
    for k, problem in enumerate(dict.fromkeys(rows["problem"])):
        here = rows.where(problem=problem)
        axes = slide.axes((110 + 365 * k, 75, 300, 190), y=(3e-6, 3e1), title=say(problem), below=say("time [ms]"), log="y")
        for side, color in (("ours", POSE), ("Ceres", PRIOR)):
            run = here.where(side=side)
            axes.plot(1e3 * run["seconds"], np.maximum(run["cost"] / here["cost"].min() - 1, 1e-9), "o-", color=color, markersize=5, label=say(side))
        axes.set_xlim(0, None)
        axes.set_yticks([1e-5, 1e-3, 1e-1, 1e1], ["" if k else words for words in ("0.001 %", "0.1 %", "10 %", "1000 %")])
        if k == 0:
            axes.set_ylabel(say("above the least cost"))
            slide.legend(axes, 110, 5, columns=2)
