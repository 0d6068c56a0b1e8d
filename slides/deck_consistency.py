"""Deck 6, consistency: how certain an estimator may be, and what makes it too certain; from the chapter's tables and the kept
ones of ch5_nees and ch5_systems."""

from math import ceil

import numpy as np

from ch5_backend.figures import nees, odometry, style, systems
from ch5_backend.figures.numbers.windows import KEPT, consistency
from ch5_backend.figures.slide import INK, LANDMARK, MUTED, POSE, PRIOR, Figures, decades, mix

from . import marginalization_examples as toy
from .deck_consistency_facts import facts  # noqa: F401
from .deck_marginalization import POLICIES, time_axes

FIGURES = Figures({  # what the tables' words read as
    "none": "no constraints", "prior_only": "prior only", "full": "all edges", "poses fixed": "poses\nfixed",
    "marginalized": "margi-\nnalized", "first estimates": "first\nestimates"})


@FIGURES.figure(1080, 390, "Linearized twice, at one point and at two")
def product(slide, tables, say):
    """x y = 1 measured twice: level lines of the two quadratic models' sum, linearized at one point and at two."""
    same, mixed = toy.two_tangents()
    cross = [float(v) for v in toy.solve([[1, 1], [toy.POINTS[1][1], toy.POINTS[1][0]]], [2, 2 * toy.PRODUCT])]
    x, y = np.meshgrid(np.linspace(0, 2.8, 281), np.linspace(0, 1.8, 181))
    for left, name, H, middle, levels, points in (
            (60, "linearized at one point", same, (1, 1), (0.0128, 0.18, 0.845), toy.POINTS[:1]),
            (610, "linearized at two points", mixed, cross, (0.05, 0.25, 0.6), toy.POINTS)):
        axes = slide.axes((left, 45, 420, 270), (0, 2.8), (0, 1.8), below="x", xticks=(0, 1, 2), yticks=(0, 1))
        slide.text(left - 16, 50, "y", 17)
        slide.text(left + 210, 30, say(name), 18, MUTED)
        dx, dy = x - middle[0], y - middle[1]
        cost = float(H[0][0]) * dx**2 + 2 * float(H[0][1]) * dx * dy + float(H[1][1]) * dy**2
        axes.contour(x, y, cost, levels, colors=[mix(POSE, 0.6)], linewidths=1.35)
        axes.plot(x[0, 56:], toy.PRODUCT / x[0, 56:], color=LANDMARK, linewidth=3, linestyle=style.SOLID)
        if name == "linearized at two points":
            axes.plot(*middle, "o", color=PRIOR, markersize=9)
        for x0, y0 in ((float(a), float(b)) for a, b in points):  # the tangent y0 (x − x0) + x0 (y − y0) = 0
            axes.plot((0, 2 * x0), (2 * y0, 0), color=INK, linewidth=1.35, linestyle=(0, (4, 3)))
            axes.plot(x0, y0, "o", color=INK, markersize=10.5)


@FIGURES.figure(1060, 340, "Information on what nothing measures")
def yaw_leak(slide, tables, say):
    """What the priors of the longer flight claim to know of yaw and of position."""
    every = tables("odometry_gauge")
    ticks = decades([1e-12, every["information"].max()])
    axes = time_axes(slide, say, (80, 40, 690, 230), every["t_s"].max(), ticks[[0, -1]], "nᵀHn of the prior", log="y", yticks=ticks[::4])
    for policy, name in POLICIES.items():
        for directions, what, width in (("yaw",), "yaw, ", None), ("xyz", "position, ", 1.0):
            rows = [every.where(policy=policy, direction=direction) for direction in directions]
            worst = np.max([np.abs(one["information"]) for one in rows], axis=0)
            odometry.leak_line(axes, rows[0]["t_s"], worst, policy, linewidth=width, label=say(what) + name)
    slide.legend(axes, 800, 80)


def nees_axes(slide, say, rows, top):
    return time_axes(slide, say, (70, 40, 740, 245), rows["t_s"].max(), (0, top), "NEES of the pose, mean of the flights", yticks=range(0, top + 1, top // 5))


def band(axes, rows, say):
    axes.fill_between(rows["t_s"], rows["pose_low"], rows["pose_high"], color=nees.PALE, zorder=0, label=say("95 % of honest means"))


@FIGURES.figure(1080, 290, "NEES of observations used once and twice, with hosts exact and noisy")
def nees_causes(slide, tables, say):
    """The VINS policy without constraints; the axis is logarithmic."""
    rows = consistency(KEPT, "vins", "none")
    axes = time_axes(slide, say, (70, 40, 700, 190), rows["t_s"].max(), (3, 300), "NEES of the pose, mean of the flights", log="y", yticks=(10, 100))
    nees.cause_lines(axes, KEPT, "vins", say)
    band(axes, rows, say)
    slide.legend(axes, 795, 60)


@FIGURES.figure(1080, 350, "NEES of three modes of first estimates")
def nees_modes(slide, tables, say):
    """The three modes of the VINS policy."""
    every = {mode: consistency(KEPT, "vins", mode) for mode in nees.MODES}
    axes = nees_axes(slide, say, every["none"], 5 * ceil(max(rows["nees_pose"].max() for rows in every.values()) / 5))
    for mode, rows in every.items():
        nees.curve(axes, rows, rows["nees_pose"], nees.MODES[mode][1], say(mode))
    band(axes, every["none"], say)
    slide.legend(axes, 840, 70)


@FIGURES.figure(1060, 350, "The information on yaw over time")
def yaw_information(slide, tables, say):
    """The mean information on the newest frame's yaw, of that at the start."""
    every = {mode: consistency(KEPT, "vins", mode) for mode in nees.MODES}
    share = {mode: rows["yaw_information"] / rows["yaw_information"][0] for mode, rows in every.items()}
    top = ceil(max(values.max() for values in share.values()))
    axes = time_axes(slide, say, (70, 40, 740, 245), every["none"]["t_s"].max(), (0, top), "information on yaw / at the start", yticks=range(top + 1))
    for mode, rows in every.items():
        nees.curve(axes, rows, share[mode], nees.MODES[mode][1], say(mode))
    slide.legend(axes, 840, 70)


@FIGURES.figure(1120, 400, "Dropped, fixed, marginalized, with first estimates")
def ablation(slide, tables, say):
    """Error and NEES of the motion across the window, a dot a flight."""
    for left, column, title in ((50, "ate_m", "error of the position, ATE [m]"), (625, "nees_motion", "NEES of the motion across the window")):
        axes = slide.axes((left + 20, 75, 455, 265), title=say(title))
        systems.ablation(axes, KEPT, column, say, size=5)
        if column == "nees_motion":
            axes.axhline(6, color=MUTED, linewidth=1)
        else:
            slide.legend(axes, 60, 10, columns=3)
