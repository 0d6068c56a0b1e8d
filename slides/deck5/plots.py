"""Plots of deck 5, from the tables that measure.py keeps."""

from math import ceil

from ..chart import Axes, decades, legend
from ..svg import CROSS, INK, LANDMARK, MUTED, POSE, PRIOR, Svg, mix

from .facts import BEST, PROBLEMS, STEPS, iteration, ladder, time_of

WORDS = {
    "en": {"linearize": "linearise", "invert": "invert H_ll", "schur": "form S", "poses": "solve S", "back": "back", "cost": "cost",
           "update": "update", "ms": "ms an iteration", "dense": "dense, any H", "plain": "blocks in a map",
           "fixed": "fixed sizes, structure once", "avx2": "and registers of four",
           "intensity": "flop per byte", "speed": "GFLOP/s", "memory": "memory", "peak": "multiply-adds, four at once",
           "portable": "two at once", "gain": "times faster with registers of four", "ours": "ours", "ceres": "Ceres",
           "seconds": "seconds", "sparse": "S formed, sparse Cholesky", "implicit-pcg": "implicit, PCG",
           "power-series": "implicit, power series", "excess": "cost above the best"},
    "zh": {"linearize": "线性化", "invert": "求 H_ll 逆", "schur": "构造 S", "poses": "解 S", "back": "回代", "cost": "代价",
           "update": "更新", "ms": "每次迭代毫秒", "dense": "稠密 H", "plain": "map 里的块", "fixed": "固定尺寸，结构只建一次",
           "avx2": "再加四通道寄存器", "intensity": "每字节浮点运算", "speed": "GFLOP/s",
           "memory": "内存", "peak": "乘加，一次四个", "portable": "一次两个", "gain": "四通道寄存器带来的加速倍数", "ours": "本章",
           "ceres": "Ceres", "seconds": "秒", "sparse": "构造 S，稀疏 Cholesky", "implicit-pcg": "隐式，PCG",
           "power-series": "隐式，幂级数", "excess": "高出最优代价的比例"},
}
SHADES = {"linearize": POSE, "invert": mix(LANDMARK, 0.5), "schur": LANDMARK, "poses": CROSS, "back": PRIOR,
          "cost": mix(INK, 0.45), "update": mix(INK, 0.2)}


def shares(tables, lang):
    """Where an iteration's time goes."""
    words = WORDS[lang]
    svg = Svg(1080, 380, "Where the time goes")
    for k, problem in enumerate(PROBLEMS):
        whole, left = iteration(tables, problem, *BEST), 190.0
        svg.text(176, 74 + 64 * k, problem.split("/")[1], 18, anchor="end")
        for step in STEPS:
            wide = 740 * time_of(tables, problem, step, *BEST) / whole
            svg.rect(left, 48 + 64 * k, wide, 42, SHADES[step])
            left += wide
        svg.text(945, 76 + 64 * k, f"{whole:.2g} ms", 18, anchor="start")
    for k, step in enumerate(STEPS):
        x = 50 + 146 * k
        svg.rect(x, 330, 20, 20, SHADES[step], radius=3)
        svg.text(x + 27, 346, words[step], 15, anchor="start")
    return svg.render()


MILLISECONDS = (0.1, 1000.0)
BAR = 41  # from one to the next


def time_axes(svg, lang, left, height):
    """A logarithmic scale of times an iteration; what stands on it is named by hand."""
    axes = Axes(svg, (left, 60, 870 - left, height), (0, 1), MILLISECONDS, log_y=True)
    axes.draw("", WORDS[lang]["ms"], (), decades(MILLISECONDS))
    return axes


def bars(axes, left, values):
    """Bars side by side, each with its number: [(value, colour)]."""
    for k, (value, colour) in enumerate(values):
        top = axes.y(value)
        axes.svg.rect(left + k * BAR, top, BAR - 8, axes.top + axes.height - top, colour, radius=2)
        axes.svg.text(left + k * BAR + (BAR - 8) / 2, top - 7, f"{value:.3g}" if value < 100 else f"{value:.0f}", 14)


LADDER_COLOURS = {"dense": PRIOR, "plain": LANDMARK, "fixed": CROSS, "avx2": POSE}


def rungs(tables, lang):
    """An iteration's time on each rung of the ladder."""
    words = WORDS[lang]
    svg = Svg(1120, 400, "What each idea gained")
    axes, left = time_axes(svg, lang, 70, 250), 90
    for problem in PROBLEMS:
        found = ladder(tables, problem)
        bars(axes, left, [(value, LADDER_COLOURS[name]) for name, value in found.items()])
        svg.text(left + BAR * len(found) / 2 - 4, 340, problem.split("/")[1], 17)
        left += BAR * len(found) + 22
    for k, name in enumerate(LADDER_COLOURS):
        svg.rect(888, 84 + 38 * k, 20, 20, LADDER_COLOURS[name], radius=3)
        svg.text(916, 100 + 38 * k, words[name], 14.5, anchor="start")
    return svg.render()


def lanes_gain(tables, lang):
    """Step by step: how much faster with registers of four doubles instead of two."""
    words = WORDS[lang]
    svg = Svg(1080, 380, "Registers of four, step by step")
    problem = "bal/16-22106"
    steps = [step for step in STEPS if step != "update"]
    ratios = [time_of(tables, problem, s, "sparse", "portable") / time_of(tables, problem, s, *BEST) for s in steps]
    top = ceil(1.1 * max(ratios))
    axes = Axes(svg, (90, 50, 900, 260), (0, len(steps)), (0, top))
    axes.draw("", words["gain"], (), range(top + 1))
    svg.line(90, axes.y(1), 990, axes.y(1), INK, 1.2, "5 5")
    for k, (step, ratio) in enumerate(zip(steps, ratios)):
        x = axes.x(k + 0.5)
        svg.rect(x - 38, axes.y(ratio), 76, axes.y(0) - axes.y(ratio), SHADES[step], radius=3)
        svg.text(x, axes.y(ratio) - 8, f"{ratio:.1f}", 16)
        svg.text(x, 338, words[step], 16)
    return svg.render()


def roofline(tables, lang):
    """Steps under the roof of this machine."""
    words = WORDS[lang]
    svg = Svg(1080, 430, "Roofline")
    peaks = {simd: tables.row("speed_machine", simd=simd, limit="peak")["value"] for simd in ("portable", "avx2")}
    bandwidth = max(tables.rows("speed_machine", simd="avx2", limit="read"), key=lambda r: r["megabytes"])["value"]
    axes = Axes(svg, (90, 45, 760, 310), (0.1, 100), (0.5, 200), log_x=True, log_y=True)
    axes.draw(words["intensity"], words["speed"], [0.1, 1, 10, 100], [1, 10, 100])
    for simd, name, dash in (("avx2", "peak", None), ("portable", "portable", "7 5")):
        knee = peaks[simd] / bandwidth
        axes.curve([0.1, knee, 100], [0.1 * bandwidth, peaks[simd], peaks[simd]], INK, dash, dots=False, width=2.2)
        svg.text(axes.x(100) + 10, axes.y(peaks[simd]) + 5, words[name], 15, MUTED, anchor="start")
    svg.text(axes.x(0.7), axes.y(0.7 * bandwidth) - 26, words["memory"], 16, MUTED, anchor="end")
    for problem, radius in (("bal/16-22106", 8), ("bal/49-7776", 5)):
        for step in ("linearize", "schur", "back"):
            row = tables.row("speed_steps", problem=problem, step=step, solver="sparse", simd="avx2")
            x, y = axes.x(row["flop"] / row["bytes"]), axes.y(1e-6 * row["flop"] / row["milliseconds"])
            svg.circle(x, y, radius, SHADES[step])
            if radius == 8:
                svg.text(x, y + 28, words[step], 16, SHADES[step])
    return svg.render()


def peers(tables, lang):
    """An iteration of ours and of Ceres."""
    words = WORDS[lang]
    svg = Svg(1080, 380, "Beside Ceres")
    axes = time_axes(svg, lang, 90, 240)
    for k, problem in enumerate(PROBLEMS):
        both = {r["side"]: r["iteration_ms"] for r in tables.rows("speed_peers", problem=problem)}
        bars(axes, 135 + 190 * k, [(both["ceres"], PRIOR), (both["ours"], POSE)])
        svg.text(135 + 190 * k + 42, 332, problem.split("/")[1], 17)
    for k, (name, colour) in enumerate((("ceres", PRIOR), ("ours", POSE))):
        svg.rect(885, 90 + 38 * k, 20, 20, colour, radius=3)
        svg.text(913, 106 + 38 * k, words[name], 17, anchor="start")
    return svg.render()


def reduced(tables, lang):
    """Cost over time for the cameras' system solved in three ways."""
    words = WORDS[lang]
    svg = Svg(1080, 410, "Solvers for 969 cameras")
    rows = tables.rows("speed_reduced")
    best = min(r["cost"] for r in rows)
    last = max(r["seconds"] for r in rows)
    axes = Axes(svg, (90, 45, 700, 290), (0.1, last), (1e-4, 10), log_x=True, log_y=True)
    axes.draw(words["seconds"], words["excess"], [t for t in (0.1, 1, 10, 100) if t <= last], decades((1e-4, 10)))
    colours = {"sparse": PRIOR, "implicit-pcg": LANDMARK, "power-series": POSE}
    for name, colour in colours.items():
        mine = [r for r in tables.rows("speed_reduced", solver=name) if r["seconds"] >= 0.1]
        axes.curve([r["seconds"] for r in mine], [max(1e-4, r["cost"] / best - 1) for r in mine], colour)
    legend(svg, 805, 90, [(words[name], colour, None) for name, colour in colours.items()], gap=36)
    return svg.render()


ALL = {"shares": shares, "rungs": rungs, "lanes_gain": lanes_gain, "roofline": roofline, "peers": peers, "reduced": reduced}
