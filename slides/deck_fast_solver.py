"""Deck 5, a fast solver: pictures of structure, and plots of the kept measurements."""

from math import ceil

import numpy as np

from ch5_backend.figures import systems
from ch5_backend.figures.numbers.windows import KEPT
from ch5_backend.figures.slide import CROSS, INK, LANDMARK, MUTED, POSE, PRIOR, PX, Figures, decades, mix

from .deck_fast_solver_facts import BEST, PROBLEMS, STEPS, facts, iteration, ladder, time_of  # noqa: F401
from .toy_graph import EDGES, LANDMARKS, POSES

FIGURES = Figures({  # what the tables' words read as
    "invert": "invert H_ll", "schur": "form S", "poses": "solve S", "dense": "dense, any H", "plain": "blocks in a map",
    "fixed": "fixed sizes, structure once", "avx2": "and registers of four", "scene/30x1000": "scene, 30 frames",
    "window/vio_M": "IMU window", "bal/49-7776": "49 cameras", "bal/16-22106": "16 cameras",
    "sparse": "S formed, sparse Cholesky", "implicit-pcg": "implicit, PCG", "power-series": "implicit, power series",
    "milliseconds": "an iteration [ms]", "megabytes": "memory [MB]", "Levenberg-Marquardt": "LM"})
SHADES = {"linearize": POSE, "invert": mix(LANDMARK, 0.5), "schur": LANDMARK, "poses": CROSS, "back": PRIOR,
          "cost": mix(INK, 0.45), "update": mix(INK, 0.2)}
LADDER_COLORS = {"dense": PRIOR, "plain": LANDMARK, "fixed": CROSS, "avx2": POSE}
NUMBER = {"fontsize": 16.9 * PX, "color": INK}


def box(slide, x, y, width, name, below, color, strong=False):
    slide.rect(x, y, width, 78, mix(color, 0.28 if strong else 0.14), color, radius=10, line=2.2 if strong else 1.5)
    slide.text(x + width / 2, y + 34, name, 19, weight="bold")
    slide.text(x + width / 2, y + 60, below, 15, MUTED)


@FIGURES.figure(1130, 330, "g2o's classes")
def g2o(slide, tables, say):
    """Who owns whom in g2o; the three choices of the user in strong colors."""
    box(slide, 20, 40, 250, "SparseOptimizer", say("unknowns, measurements"), POSE)
    box(slide, 330, 40, 250, "OptimizationAlgorithm", say("how far"), CROSS, True)
    box(slide, 640, 40, 220, "BlockSolver<p, l>", say("H, b, Schur complement"), CROSS, True)
    box(slide, 920, 40, 190, "LinearSolver", say("S Δx = b"), CROSS, True)
    for x in (272, 582, 862):
        slide.line(x, 79, x + 54, 79, arrow=True)
    box(slide, 20, 210, 115, "Vertex", "oplusImpl", LANDMARK)
    box(slide, 155, 210, 115, "Edge", "computeError", LANDMARK)
    for x in (78, 212):
        slide.line(x, 120, x, 206, arrow=True)
    for x, name in ((455, "GN · LM · Dogleg"), (750, "6 × 3, 3 × 2, dynamic"), (1015, "PCG · CSparse · Cholmod")):
        slide.text(x, 160, name, 16, CROSS)
    slide.line(330, 190, 1110, 190, CROSS, 1.6)
    slide.text(720, 222, say("you choose"), 18, CROSS)


@FIGURES.figure(1060, 360, "g2o's mapped memory")
def mapping(slide, tables, say):
    """One edge of the toy graph and the blocks of H that it keeps the addresses of; the vertices keep their diagonal ones."""
    cell, left, top = 22, 600, 30
    size = POSES * 3 + LANDMARKS
    for k in range(POSES + LANDMARKS):
        start, wide = (3 * k, 3) if k < POSES else (3 * POSES + k - POSES, 1)
        slide.rect(left + start * cell + 1, top + start * cell + 1, wide * cell - 2, wide * cell - 2,
                 mix(POSE if k < POSES else LANDMARK, 0.3), radius=3)
    landmark, host, target = EDGES[3]
    slide.rect(left, top, size * cell, size * cell, stroke=MUTED, radius=3)
    l_at = 3 * POSES + landmark
    targets = ((3 * host, l_at, 3, 1, CROSS), (3 * target, l_at, 3, 1, CROSS), (3 * host, 3 * target, 3, 3, POSE))
    for k, (row, column, tall, wide, color) in enumerate(targets):
        x, y = left + column * cell, top + row * cell
        slide.rect(x + 1, y + 1, wide * cell - 2, tall * cell - 2, mix(color, 0.9), radius=3)
        start, end = 120 + 40 * k, y + tall * cell / 2
        slide.polyline([(340, start), (480, start), (480, end), (x - 4, end)], PRIOR, 1.6, arrow=True, curved=True)
    slide.rect(110, 90, 230, 140, mix(INK, 0.06), INK, radius=10)
    slide.text(225, 80, say("edges"), 18)
    for k, name in enumerate(("_hessian[0]", "_hessian[1]", "_hessian[2]")):
        slide.text(225, 126 + 40 * k, name, 17, mono=True)
    slide.text(225, 275, say("an edge knows its places"), 17, PRIOR)
    slide.text(225, 303, say("H_pp, H_pl, H_ll in one block matrix"), 16, MUTED)


@FIGURES.figure(1130, 190, "Structure, Linearized, Eliminated, Step")
def flow(slide, tables, say):
    """Our four values and the functions between them."""
    names = (("Structure", say("what lies where; once"), POSE), ("Linearized", "H_pp, H_pl, H_ll, b", LANDMARK),
             ("Eliminated", "H_ll⁻¹, S, b_S", CROSS), ("Step", "Δx", PRIOR))
    for k, (name, below, color) in enumerate(names):
        box(slide, 10 + 296 * k, 70, 222, name, below, color)
    for k, name in enumerate(("linearize", "eliminate", "solve, go back")):
        slide.line(236 + 296 * k, 109, 300 + 296 * k, 109, arrow=True)
        slide.text(268 + 296 * k, 50, say(name), 17, MUTED)


@FIGURES.figure(1080, 330, "Lanes")
def lanes(slide, tables, say):
    """The numbers of eight edges, one after the other and side by side."""
    shades = [mix(color, 0.75) for color in (POSE, LANDMARK, CROSS, PRIOR)] + [
        mix(color, 0.4) for color in (POSE, LANDMARK, CROSS, PRIOR)]
    for panel, name in enumerate(("one edge at a time", "eight edges at a time")):
        left = 60 + 540 * panel
        slide.text(left + 200, 40, say(name), 19)
        for row in range(5):
            for column in range(8):
                item = (row * 8 + column) // 5 if panel == 0 else column
                slide.rect(left + 50 * column, 70 + 42 * row, 47, 38, shades[item], radius=4)
                if panel == 1 and row == 0:
                    slide.text(left + 50 * column + 24, 312, column, 16, MUTED)
        if panel == 1:
            slide.rect(left - 6, 70 + 42 * 2 - 3, 8 * 50 + 9, 44, stroke=INK, radius=6, line=2.2)
            slide.text(left - 14, 312, say("lane"), 16, MUTED, anchor="end")


@FIGURES.figure(1080, 360, "Groups of landmarks")
def groups(slide, tables, say):
    """The toy's landmarks sorted by the poses that see them: neighbors change the same blocks of S."""
    seen = {k: tuple(sorted({p for l, host, target in EDGES for p in (host, target) if l == k})) for k in range(LANDMARKS)}
    order = sorted(seen, key=lambda k: (seen[k], k))
    kinds = sorted(set(seen.values()))
    shades = dict(zip(kinds, (LANDMARK, CROSS, PRIOR)))
    cell = 34
    for column, landmark in enumerate(order):
        x = 70 + column * cell
        for pose in seen[landmark]:
            slide.rect(x + 2, 60 + pose * 3 * cell * 0.75 + 2, cell - 4, 3 * cell * 0.75 - 4, mix(shades[seen[landmark]], 0.75), radius=3)
        slide.text(x + cell / 2, 48, "ℓ" + "₀₁₂₃₄₅"[landmark], 18.3, shades[seen[landmark]], italic=True)
    for pose in range(POSES):
        slide.text(56, 60 + (pose + 0.5) * 3 * cell * 0.75 + 6, "x" + "₀₁₂"[pose], 18.3, POSE, anchor="end", italic=True)
    slide.text(70 + 3 * cell, 325, say("landmarks, sorted by who sees them"), 18.3, MUTED)
    for k, kind in enumerate(kinds):
        left, size = 380 + 240 * k, 60
        for a in range(POSES):
            for b in range(POSES):
                inside = a in kind and b in kind and a >= b
                slide.rect(left + b * size + 2, 70 + a * size + 2, size - 4, size - 4,
                         mix(shades[kind], 0.75) if inside else mix(INK, 0.05), radius=4)
        slide.text(left + 1.5 * size, 288, "S −= A Aᵀ", 18.3, shades[kind], italic=True)
    slide.text(380 + 330, 325, say("one group, one product"), 18.3, MUTED)


@FIGURES.figure(1080, 380, "Where the time goes")
def shares(slide, tables, say):
    """Where an iteration's time goes."""
    axes = slide.axes((190, 40, 740, 250), (0, 1), (len(PROBLEMS) - 0.5, -0.5), xticks=(), yticks=())
    axes.spines[:].set_visible(False)
    left = np.zeros(len(PROBLEMS))
    for step in STEPS:
        times = np.array([time_of(tables, problem, step, *BEST) / iteration(tables, problem, *BEST) for problem in PROBLEMS])
        axes.barh(range(len(PROBLEMS)), times, 0.66, left, color=SHADES[step], label=say(step))
        left += times
    for k, problem in enumerate(PROBLEMS):
        y = 40 + 250 * (k + 0.5) / len(PROBLEMS) + 6
        slide.text(176, y, say(problem), 18, anchor="end")
        slide.text(945, y, f"{iteration(tables, problem, *BEST):.2g} ms", 18, anchor="start")
    slide.legend(axes, 50, 330, columns=len(STEPS), handlelength=1.2, columnspacing=2.2)


def dots(slide, say, box, groups, colors):
    """Groups of times an iteration on a logarithmic scale, where a bar's length would mean nothing, each with its number:
    {name: {color's key: value}}."""
    ticks = decades([value for values in groups.values() for value in values.values()])
    axes = slide.axes(box, None, ticks[[0, -1]], say("ms an iteration"), "", "y", None, ticks)
    at, middles = 0.0, []
    for values in groups.values():
        axes.plot(at + np.arange(len(values)), list(values.values()), color=mix(INK, 0.25), linewidth=1.5, zorder=1)
        for k, (key, value) in enumerate(values.items()):
            axes.plot(at + k, value, "o", markersize=11, color=colors[key])
            axes.annotate(f"{value:.3g}" if value < 100 else f"{value:.0f}", (at + k, value), (0, 9), ha="center",
                          textcoords="offset points", **NUMBER)
        middles.append(at + (len(values) - 1) / 2)
        at += len(values) + 0.55
    for key, color in colors.items():
        axes.plot([], [], "o", markersize=11, color=color, label=say(key))
    axes.set_xticks(middles, [say(problem) for problem in groups], fontsize=17 * PX, color=INK)
    axes.tick_params(axis="x", length=0)
    axes.set_xlim(-0.7, at - 0.9)
    return axes


@FIGURES.figure(1120, 400, "What each idea gained")
def rungs(slide, tables, say):
    """An iteration's time on each rung of the ladder."""
    axes = dots(slide, say, (70, 60, 770, 250), {problem: ladder(tables, problem) for problem in PROBLEMS}, LADDER_COLORS)
    slide.legend(axes, 852, 84, handlelength=1.2, fontsize=16.4 * PX)


@FIGURES.figure(1080, 380, "Registers of four, step by step")
def lanes_gain(slide, tables, say):
    """Step by step: how much faster with registers of four doubles instead of two."""
    problem = "bal/16-22106"
    steps = [step for step in STEPS if step != "update"]
    ratios = [time_of(tables, problem, s, "sparse", "portable") / time_of(tables, problem, s, *BEST) for s in steps]
    top = ceil(1.1 * max(ratios))
    axes = slide.axes((90, 50, 900, 260), None, (0, top), say("times faster with registers of four"), yticks=range(top + 1))
    axes.bar_label(axes.bar(range(len(steps)), ratios, 0.52, color=[SHADES[step] for step in steps]), fmt="%.1f", padding=4, **NUMBER)
    axes.axhline(1, color=INK, linewidth=1, linestyle=(0, (4, 4)))
    axes.set_xticks(range(len(steps)), map(say, steps), fontsize=16.6 * PX, color=INK)


@FIGURES.figure(1080, 430, "Roofline")
def roofline(slide, tables, say):
    """Steps under the roof of this machine."""
    machine = tables("speed_machine")
    reading = machine.where(simd="avx2", limit="read")
    bandwidth = reading["value"][reading["megabytes"].argmax()]
    axes = slide.axes((90, 45, 740, 310), (0.1, 100), (0.5, 200), say("GFLOP/s"), say("flop per byte"), "xy", (0.1, 1, 10, 100),
                      (1, 10, 100))
    for simd, name, dashes in (("avx2", "multiply-adds, four at once", "-"), ("portable", "two at once", (0, (4, 3)))):
        peak = machine.row(simd=simd, limit="peak")["value"]
        axes.plot((0.1, peak / bandwidth, 100), (0.1 * bandwidth, peak, peak), color=INK, linewidth=1.65, linestyle=dashes)
        axes.annotate(say(name), (100, peak), (7, -4), textcoords="offset points", color=MUTED, annotation_clip=False)
    axes.annotate(say("memory"), (0.7, 0.7 * bandwidth), (0, 18), textcoords="offset points", color=MUTED, ha="right")
    for problem, size in (("bal/16-22106", 12), ("bal/49-7776", 7.5)):
        for step in ("linearize", "schur", "back"):
            row = tables("speed_steps").row(problem=problem, step=step, solver="sparse", simd="avx2")
            place = row["flop"] / row["bytes"], 1e-6 * row["flop"] / row["milliseconds"]
            axes.plot(*place, "o", color=SHADES[step], markersize=size)
            if size == 12:
                axes.annotate(say(step), place, (0, -21), textcoords="offset points", color=SHADES[step], ha="center")


@FIGURES.figure(1080, 410, "Solvers for 969 cameras")
def reduced(slide, tables, say):
    """Cost over time for the cameras' system solved in three ways."""
    every = tables("speed_reduced")
    last = every["seconds"].max()
    axes = slide.axes((90, 45, 700, 290), (0.1, last), (1e-4, 10), say("cost above the best"), say("seconds"), "xy",
                      [t for t in (0.1, 1, 10, 100) if t <= last], decades((1e-4, 10)))
    for name, color in (("sparse", PRIOR), ("implicit-pcg", LANDMARK), ("power-series", POSE)):
        rows = every.where(solver=name)
        axes.plot(rows["seconds"], np.maximum(1e-4, rows["cost"] / every["cost"].min() - 1), "o-", color=color, label=say(name))
    slide.legend(axes, 805, 80)


@FIGURES.figure(1120, 390, "g2o's data sets by linear solver and algorithm")
def pose_graphs(slide, tables, say):
    """Time of an iteration and memory over the unknowns; cost over the iterations of the data set with a bad start."""
    for left, column in ((75, "milliseconds"), (405, "megabytes")):
        axes = slide.axes((left, 110, 240, 205), title=say(column), below=say("unknowns"))
        systems.solver_column(axes, KEPT, column, say)
        axes.set_xticks([2500, 5000, 10000])
    slide.legend(axes, 60, 10, columns=2)
    axes = slide.axes((760, 110, 330, 205), title=say("MIT: cost / least cost"), below=say("iteration"))
    systems.algorithm_costs(axes, KEPT, "MIT", say)
    slide.legend(axes, 700, 10, columns=3, columnspacing=1.4)
