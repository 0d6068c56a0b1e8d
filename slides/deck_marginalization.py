"""Deck 3, marginalization and sliding windows: pictures of hand-worked examples, and plots of windows and priors from the
chapter's tables and those kept of ch5_systems."""

from math import ceil

import numpy as np

from ch5_backend.figures import odometry, systems
from ch5_backend.figures.numbers.windows import KEPT, cuts, spectra
from ch5_backend.figures.slide import FAINT, INK, LANDMARK, MUTED, PAPER, POSE, PRIOR, Figures, decades, mix
from ch5_backend.figures.tables import dense

from . import marginalization_examples as toy
from .deck_marginalization_facts import facts  # noqa: F401

FIGURES = Figures({  # what the tables' words read as
    "prior": "into the prior", "again": "into the prior, and used again", "stays": "untouched",
    "no keyframe": "a frame that is no keyframe leaves", "keyframe": "a keyframe leaves"})
SUB = "₀₁₂₃₄₅"
POLICIES = {"vins": "VINS-Mono", "okvis": "OKVIS"}
FATES = {"prior": PRIOR, "again": LANDMARK, "lost": mix(INK, 0.3), "stays": POSE}


def place(vertex, left):
    kind, n = vertex
    return (left + 60 + 130 * n, 250) if kind == "x" else (left + 75 + 95 * n, 100)


def draw_vertex(slide, vertex, left, faded=False):
    x, y = place(vertex, left)
    color = POSE if vertex[0] == "x" else LANDMARK
    slide.circle(x, y, 21, PAPER if faded else mix(color, 0.25), mix(color, 0.35) if faded else color, 2)
    slide.text(x, y + 6, ("x" if vertex[0] == "x" else "ℓ") + SUB[vertex[1]], 18,
             mix(INK, 0.35) if faded else INK, italic=True)


@FIGURES.figure(1080, 350, "Marginalizing ties the neighbors together")
def clique(slide, tables, say):
    """The toy graph before and after its oldest pose and the landmarks seen from there are marginalized."""
    gone, tied, vertices = toy.leaving(), toy.neighbors(), sorted(set().union(*toy.edges()))
    for left, after in ((0, False), (580, True)):
        for edge in toy.edges():
            a, b = (place(vertex, left) for vertex in sorted(edge))
            if not (after and edge & gone):
                slide.line(*a, *b, PRIOR if edge & gone else MUTED, 2.2 if edge & gone else 1.6)
        if after:
            for i, a in enumerate(tied):
                for b in tied[i + 1:]:
                    (x1, y1), (x2, y2) = place(a, left), place(b, left)
                    below = (x1 + x2) / 2, y1 + 34 + 0.22 * abs(x2 - x1)
                    slide.polyline([(x1, y1), below, (x2, y2)], PRIOR, 4, curved=True)
        for vertex in vertices:
            draw_vertex(slide, vertex, left, faded=after and vertex in gone)
            if not after and vertex in gone:
                slide.circle(*place(vertex, left), 28, "none", PRIOR, 2)
        slide.text(left + 250, 40, say("after: one prior" if after else "before"), 19, MUTED)
    slide.line(505, 180, 555, 180, arrow=True)
    slide.circle(40, 325, 9, "none", PRIOR, 2)
    slide.text(58, 331, say("leaves"), 17, PRIOR, anchor="start")


@FIGURES.figure(860, 190, "The chain of three scalars and its hidden prior")
def chain_graph(slide, tables, say):
    """The course's three scalars with all four of their measurements."""
    at = (110, 420, 730)
    for (x1, x2), sigma in zip(zip(at, at[1:]), ("0.1", "0.3")):
        slide.line(x1, 75, x2, 75, MUTED, 2)
        slide.rect((x1 + x2) / 2 - 10, 65, 20, 20, POSE, radius=3)
        slide.text((x1 + x2) / 2, 48, f"{say('measured distance')}, σ = {sigma}", 17, MUTED)
    slide.line(420, 75, 420, 150, PRIOR, 2)
    slide.rect(410, 140, 20, 20, PRIOR, radius=3)
    slide.text(445, 157, say("prior, σ = 0.2"), 18, PRIOR, anchor="start")
    for k, x in enumerate(at):
        slide.circle(x, 75, 25, mix(POSE, 0.25), POSE, 2)
        slide.text(x, 82, "x" + SUB[k], 20, italic=True)


def frame(slide, x, y, whole):
    slide.circle(x, y, 15, mix(POSE, 0.85 if whole else 0.3), POSE, 1.6)
    if whole:
        slide.circle(x, y, 22, "none", LANDMARK, 3)


@FIGURES.figure(1120, 350, "The windows of VINS-Mono and OKVIS")
def windows(slide, tables, say):
    """Which states the two windows hold, drawn with the published sizes: 10 + 1 frames, and 5 keyframes and 3 frames."""
    step, right = 64, 1040
    for row, (name, whole, keyframes) in enumerate((("VINS-Mono", 11, ()), ("OKVIS", 3, (4, 6, 8, 11, 13)))):
        y = 95 + 150 * row
        slide.text(20, y - 52, name, 21, weight="bold", anchor="start")
        newest = [right - step * k for k in range(whole)]
        for a, b in zip(newest, newest[1:]):
            slide.line(a - 22, y, b + 22, y, LANDMARK, 2.5)
        for x in newest:
            frame(slide, x, y, True)
        for k in keyframes:
            frame(slide, right - step * k + 0, y, False)
        for k in range(15):
            if k >= whole and k not in keyframes:
                slide.circle(right - step * k, y, 4, FAINT)
        slide.text(right, y - 36, say("newest"), 16, MUTED)
        if keyframes:
            slide.text(right - step * 8.5, y - 36, say("keyframes"), 16, MUTED)
        else:
            slide.text(newest[-1], y - 36, say("oldest"), 16, MUTED)
    frame(slide, 60, 325, False)
    slide.text(88, 331, say("pose"), 17, anchor="start")
    frame(slide, 210, 325, True)
    slide.text(244, 331, say("pose with speed and biases"), 17, anchor="start")
    slide.line(560, 325, 600, 325, LANDMARK, 2.5)
    slide.text(612, 331, say("IMU"), 17, anchor="start")


@FIGURES.figure(1090, 385, "What the order of marginalization fills in")
def fill(slide, tables, say):
    """H of a scene: whole, without landmarks and frame 0, and without frame 0 only."""
    whole = len(dense(tables("marginalize_scene", stage="before")))
    for k, (stage, name) in enumerate((("before", "before"), ("without landmarks and frame 0", "landmarks, then frame 0"),
                                       ("without frame 0", "frame 0 at once"))):
        matrix = dense(tables("marginalize_scene", stage=stage))
        side = 320 * len(matrix) / whole
        slide.cells(20 + 365 * k + (320 - side) / 2, 20 + (320 - side) / 2, side, matrix)
        slide.text(20 + 365 * k + 160, 370, f"{say(name)}: {len(matrix)} × {len(matrix)}", 18)


@FIGURES.figure(1080, 370, "Eigenvalues of a prior, and where they are cut")
def prior_spectrum(slide, tables, say):
    plain, scaled = spectra(tables)
    panels = zip((plain, scaled), cuts(scaled), ("eigenvalues of H", "of P⁻¹HP⁻¹"), ("VINS-Mono's cut", "OKVIS's cut"))
    for panel, (values, cut, title, name) in enumerate(panels):
        sizes = np.maximum(np.abs(values), 1e-17)
        ticks = decades([*sizes, cut])
        axes = slide.axes((75 + 545 * panel, 42, 440, 250), (0, len(values)), ticks[[0, -1]], say(title), say("eigenvalue, ascending"), "y",
                          range(0, len(values) + 1, 10), ticks[::4])
        axes.axhline(cut, color=PRIOR, linewidth=1.2, linestyle=(0, (4, 3)))
        axes.annotate(say(name), (len(values), cut), (-5, 6), textcoords="offset points", color=PRIOR, ha="right")
        at = np.arange(len(values)) + 0.5
        axes.plot(at[:4], sizes[:4], "o", color=LANDMARK)
        axes.plot(at[4:], sizes[4:], "o", color=POSE, markersize=4.5)


def track_grid(slide, rows, box, color_of, radius):
    """Landmarks to the right, frames downwards: one dot an observation."""
    left, top, width, height = box
    landmarks = sorted({row["landmark"] for row in rows}, key=lambda n: [row["frame"] for row in rows if row["landmark"] == n])
    frames = int(max(row["frame"] for row in rows)) + 1
    dx, dy = width / len(landmarks), height / frames
    for frame in range(frames):
        y = top + (frame + 0.5) * dy
        slide.line(left, y, left + width, y, FAINT, 1)
        slide.text(left - 10, y + 5, frame, 16, MUTED, anchor="end")
    for row in rows:
        x, y = left + (landmarks.index(row["landmark"]) + 0.5) * dx, top + (row["frame"] + 0.5) * dy
        slide.circle(x, y, radius, PAPER if row["host"] else color_of(row), color_of(row), 2.6)


@FIGURES.figure(1060, 345, "Which frame sees which landmark")
def slide_tracks(slide, tables, say):
    """The window that both policies get."""
    track_grid(slide, tables("slide_observations", policy="vins").rows(), (70, 25, 970, 275), lambda row: POSE, 7.5)
    slide.text(555, 335, say("track"), 17)
    slide.text(22, 165, say("frame"), 17, rotate=-90)


@FIGURES.figure(1100, 300, "What becomes of each observation")
def slide_fates(slide, tables, say):
    """What a slide of each policy makes of each observation."""
    for panel, (policy, name) in enumerate(POLICIES.items()):
        track_grid(slide, tables("slide_observations", policy=policy).rows(), (35 + 550 * panel, 40, 500, 205),
                   lambda row: FATES[row["fate"]], 5.5)
        slide.text(35 + 550 * panel + 250, 24, name, 19, weight="bold")
    for x, (fate, color) in zip((60, 280, 590, 810), FATES.items()):
        slide.circle(x, 277, 7, color)
        slide.text(x + 16, 283, say(fate), 17, anchor="start")


@FIGURES.figure(1080, 350, "The two priors")
def slide_priors(slide, tables, say):
    """H of the window with what goes marked, and the prior afterwards, on the same scale."""
    for panel, (policy, name) in enumerate(POLICIES.items()):
        left, side = 15 + 545 * panel, 270
        window, prior = (dense(tables("slide_matrices", policy=policy, stage=stage)) for stage in ("window", "after"))
        slide.cells(left, 45, side, window)
        for vertex in tables("slide_vertices", policy=policy, fate="marginalized").rows():
            y, height = (vertex[key] * side / len(window) for key in ("row", "rows"))
            slide.rect(left, 45 + y, side, height, mix(PRIOR, 0.6), alpha=0.42)
            slide.rect(left + y, 45, height, side, mix(PRIOR, 0.6), alpha=0.42)
        slide.line(left + side + 12, 180, left + side + 42, 180, arrow=True)
        shown = len(prior) * 190 / 51
        slide.cells(left + side + 55, 180 - shown / 2, shown, prior)
        slide.text(left + 135, 30, f"{name}: {say('H of the window')}", 17)
        slide.text(left + 135, 340, f"{len(window)} × {len(window)}", 17, MUTED)
        slide.text(left + side + 55 + shown / 2, 340, f"{say('prior after the slide')}: {len(prior)} × {len(prior)}", 17, MUTED)


@FIGURES.figure(1120, 412, "The windows image by image")
def slide_film(slide, tables, say):
    """Which frames each policy's window holds after each image."""
    images = int(tables("slide_frames")["image"].max()) + 1
    width, height = 15.5, 11.0
    for panel, (policy, name) in enumerate(POLICIES.items()):
        left, top = 70 + 550 * panel, 35
        slide.text(left + images * width / 2, 22, name, 19, weight="bold")
        for row in tables("slide_frames", policy=policy).rows():
            slide.rect(left + row["frame"] * width + 1, top + row["image"] * height + 0.8, width - 3, height - 2,
                       mix(POSE, 0.85 if row["speed"] else 0.3), PRIOR if row["in_prior"] else None, line=1.5)
        for n in range(0, images, 5):
            slide.text(left + (n + 0.5) * width, top + images * height + 20, n, 16.6, MUTED)
            slide.text(left - 8, top + (n + 0.5) * height + 5, n, 16.6, MUTED, anchor="end")
        slide.text(left + images * width / 2, 407, say("frame"), 17)
        slide.text(left - 45, top + images * height / 2, say("image"), 17, rotate=-90)


def time_axes(slide, say, box, end, y, title, **more):
    return slide.axes(box, (0, end), y, say(title), say("time [s]"), xticks=range(0, int(end) + 1, 2 if end < 15 else 5), **more)


@FIGURES.figure(1060, 330, "Distance from the truth")
def odometry_error(slide, tables, say):
    """The distance from the truth over the longer flight."""
    paths = {policy: tables("odometry_path", policy=policy) for policy in POLICIES}
    top = 5 * ceil(20 * max(rows["error_m"].max() for rows in paths.values()))
    axes = time_axes(slide, say, (70, 40, 800, 225), max(rows["t_s"].max() for rows in paths.values()), (0, top), "distance from the truth [cm]",
                     yticks=range(0, top + 1, 5))
    for policy, rows in paths.items():
        odometry.error_line(axes, rows, policy, label=POLICIES[policy])
    slide.legend(axes, 900, 60)


@FIGURES.figure(1120, 400, "Errors and times of three ways to marginalize")
def back_ends(slide, tables, say):
    """Over how little the old prior knows, and over the landmarks that leave."""
    axes = slide.axes((75, 75, 400, 255), title=say("worst relative error of an information"), below=say("σ of the old prior, times"))
    systems.back_end_errors(axes, KEPT, say)
    slide.legend(axes, 810, 70)
    systems.back_end_times(slide.axes((545, 75, 245, 255), title=say("time [ms]"), below=say("landmarks that leave")), KEPT, say)


@FIGURES.figure(1120, 330, "H before and after OKVIS's marginalization")
def okvis_cases(slide, tables, say):
    """A frame that is no keyframe leaves, and a keyframe."""
    for k, case in enumerate(("no keyframe", "keyframe")):
        sizes = [tables("film_blocks", case=case, stage=stage)["size"][0] for stage in ("window", "prior")]
        left, side = 10 + 570 * k, 260
        shown = 1.6 * side * sizes[1] / sizes[0]
        systems.okvis_case(slide.axes((left, 40, side, side)), tables, case, "window")
        slide.line(left + side + 15, 170, left + side + 50, 170, arrow=True)
        systems.okvis_case(slide.axes((left + side + 65, 170 - shown / 2, shown, shown)), tables, case, "prior")
        slide.text(left, 24, say(case), 18, anchor="start")
        slide.text(left + side / 2, 322, f"H: {sizes[0]:.0f} × {sizes[0]:.0f}", 17, MUTED)
        slide.text(left + side + 65 + shown / 2, 322, f"{say('prior after the slide')}: {sizes[1]:.0f} × {sizes[1]:.0f}", 17, MUTED)
