"""Plots of deck 5, from the tables that measure.py keeps."""

from math import ceil

import numpy as np

from ch5_backend.figures.slide import CROSS, INK, LANDMARK, MUTED, POSE, PRIOR, PX, Figures, decades, mix

from .facts import BEST, PROBLEMS, STEPS, iteration, ladder, time_of

FIGURES = Figures("speed.")
SHADES = {"linearize": POSE, "invert": mix(LANDMARK, 0.5), "schur": LANDMARK, "poses": CROSS, "back": PRIOR,
          "cost": mix(INK, 0.45), "update": mix(INK, 0.2)}
SIDES = {"ceres": PRIOR, "ours": POSE}
MILLISECONDS = (0.1, 1000.0)
LADDER_COLORS = {"dense": PRIOR, "plain": LANDMARK, "fixed": CROSS, "avx2": POSE}
NUMBER = {"fontsize": 14 * PX, "color": INK, "padding": 4}


@FIGURES.figure(1080, 380, "Where the time goes")
def shares(slide, tables, say):
    """Where an iteration's time goes."""
    names = [problem.split("/")[1] for problem in PROBLEMS]
    axes = slide.axes((190, 40, 740, 250), (0, 1), (len(PROBLEMS) - 0.5, -0.5), xticks=(), yticks=())
    axes.spines[:].set_visible(False)
    left = np.zeros(len(PROBLEMS))
    for step in STEPS:
        times = np.array([time_of(tables, problem, step, *BEST) / iteration(tables, problem, *BEST) for problem in PROBLEMS])
        axes.barh(range(len(PROBLEMS)), times, 0.66, left, color=SHADES[step], label=say(step))
        left += times
    for k, (name, problem) in enumerate(zip(names, PROBLEMS)):
        y = 40 + 250 * (k + 0.5) / len(PROBLEMS) + 6
        slide.text(176, y, name, 18, anchor="end")
        slide.text(945, y, f"{iteration(tables, problem, *BEST):.2g} ms", 18, anchor="start")
    slide.legend(axes, 50, 330, columns=len(STEPS), handlelength=1.2, columnspacing=2.2)


def bars(axes, groups, colors, say):
    """Groups of bars on a logarithmic scale of times an iteration, each with its number: {name: {color's key: value}}."""
    at, middles = 0.0, []
    for values in groups.values():
        for k, (key, value) in enumerate(values.items()):
            bar = axes.bar(at + k, value, 0.8, color=colors[key])
            axes.bar_label(bar, [f"{value:.3g}" if value < 100 else f"{value:.0f}"], **NUMBER)
        middles.append(at + (len(values) - 1) / 2)
        at += len(values) + 0.55
    for key, color in colors.items():
        axes.bar(0, MILLISECONDS[0], color=color, label=say(key))
    axes.set_xticks(middles, [problem.split("/")[1] for problem in groups], fontsize=17 * PX, color=INK)
    axes.tick_params(axis="x", length=0)
    axes.set_xlim(-0.7, at - 0.9)


def time_axes(slide, say, box):
    return slide.axes(box, None, MILLISECONDS, say("ms"), "", "y", None, decades(MILLISECONDS))


@FIGURES.figure(1120, 400, "What each idea gained")
def rungs(slide, tables, say):
    """An iteration's time on each rung of the ladder."""
    axes = time_axes(slide, say, (70, 60, 800, 250))
    bars(axes, {problem: ladder(tables, problem) for problem in PROBLEMS}, LADDER_COLORS, say)
    slide.legend(axes, 888, 84, handlelength=1.2, fontsize=14.5 * PX)


@FIGURES.figure(1080, 380, "Registers of four, step by step")
def lanes_gain(slide, tables, say):
    """Step by step: how much faster with registers of four doubles instead of two."""
    problem = "bal/16-22106"
    steps = [step for step in STEPS if step != "update"]
    ratios = [time_of(tables, problem, s, "sparse", "portable") / time_of(tables, problem, s, *BEST) for s in steps]
    top = ceil(1.1 * max(ratios))
    axes = slide.axes((90, 50, 900, 260), None, (0, top), say("gain"), yticks=range(top + 1))
    axes.bar_label(axes.bar(range(len(steps)), ratios, 0.52, color=[SHADES[step] for step in steps]), fmt="%.1f", **NUMBER)
    axes.axhline(1, color=INK, linewidth=1, linestyle=(0, (4, 4)))
    axes.set_xticks(range(len(steps)), map(say, steps), fontsize=16 * PX, color=INK)


@FIGURES.figure(1080, 430, "Roofline")
def roofline(slide, tables, say):
    """Steps under the roof of this machine."""
    machine = tables("speed_machine")
    reading = machine.where(simd="avx2", limit="read")
    bandwidth = reading["value"][reading["megabytes"].argmax()]
    axes = slide.axes((90, 45, 760, 310), (0.1, 100), (0.5, 200), say("speed"), say("intensity"), "xy", (0.1, 1, 10, 100),
                      (1, 10, 100))
    for simd, name, dashes in (("avx2", "peak", "-"), ("portable", "portable", (0, (4, 3)))):
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


@FIGURES.figure(1080, 380, "Beside Ceres")
def peers(slide, tables, say):
    """An iteration of ours and of Ceres."""
    axes = time_axes(slide, say, (90, 60, 760, 240))
    times = {problem: tables("speed_peers", problem=problem) for problem in PROBLEMS}
    bars(axes, {problem: {side: rows.row(side=side)["iteration_ms"] for side in SIDES} for problem, rows in times.items()},
         SIDES, say)
    slide.legend(axes, 885, 90, handlelength=1.2)


@FIGURES.figure(1080, 410, "Solvers for 969 cameras")
def reduced(slide, tables, say):
    """Cost over time for the cameras' system solved in three ways."""
    every = tables("speed_reduced")
    last = every["seconds"].max()
    axes = slide.axes((90, 45, 700, 290), (0.1, last), (1e-4, 10), say("excess"), say("seconds"), "xy",
                      [t for t in (0.1, 1, 10, 100) if t <= last], decades((1e-4, 10)))
    for name, color in (("sparse", PRIOR), ("implicit-pcg", LANDMARK), ("power-series", POSE)):
        rows = every.where(solver=name)
        axes.plot(rows["seconds"], np.maximum(1e-4, rows["cost"] / every["cost"].min() - 1), "o-", color=color, label=say(name))
    slide.legend(axes, 805, 80)
