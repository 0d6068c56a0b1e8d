"""Deck 7, IMU: derivatives on the manifold, preintegration, start, calibration, evaluation; from the kept tables of ch5_systems and the
chapter's."""

import numpy as np

from matplotlib import patches
from PIL import Image

from ch5_backend.figures import systems
from ch5_backend.figures.numbers.systems import CALIBRATION_GOALS, RECORDINGS
from ch5_backend.figures.numbers.windows import KEPT
from ch5_backend.figures.slide import INK, LANDMARK, MUTED, PRIOR, Figures

from .deck_imu_facts import DRAWN, FLIGHTS, HALF, LARGER, PHOTO, PLACES, eigenvalues, exp, facts, paired, right_jacobian, short_number, spread  # noqa: F401

FIGURES = Figures({"ahead": "ahead, few tracks", "ahead with 100 tracks": "ahead, many tracks"})


@FIGURES.figure(1080, 330, "The error of a turn to first order")
def small_turns(slide, tables, say):
    """The angle between Exp(θ + δ) and Exp(θ) Exp(J δ), with J = J_r and with J = I."""
    theta, along, sizes = np.array([0.3, -0.5, 0.9]), np.array([0.6, 0.8, 0.0]), np.logspace(-4, 0, 17)
    axes = slide.axes((80, 45, 660, 220), title=say("angle that remains [rad]"), below=say("‖δ‖ [rad]"), log="xy")
    for J, label in ((np.eye(3), "J = I"), (right_jacobian(theta), "J = Jᵣ(θ)")):
        off = [np.linalg.norm(exp(theta + size * along) - exp(theta) @ exp(J @ along * size)) / 2 ** 0.5 for size in sizes]
        axes.plot(sizes, off, marker="o", label=label)
    slide.legend(axes, 800, 90)


@FIGURES.figure(1060, 262, "A photograph with its corners, and three patches with the ellipse of each")
def corners(slide, tables, say):
    """All corners; then σ of each kind of place, DRAWN times LARGER times as large, on the photograph's own pixels."""
    photo = np.asarray(Image.open(PHOTO))
    axes = slide.axes((0, 0, 262, 262), x=(0, photo.shape[1]), y=(photo.shape[0], 0))
    axes.imshow(photo, cmap="gray", interpolation="none")
    found = KEPT("corners", kind="corner")
    axes.plot(found["x"], found["y"], "o", color=PRIOR, markersize=2.6)
    axes.set_axis_off()
    for k, (kind, name) in enumerate(PLACES.items()):
        place = KEPT("corners", kind=kind)
        x, y = place["x"][0], place["y"][0]
        axes.add_patch(patches.Rectangle((x - HALF, y - HALF), 2 * HALF, 2 * HALF, fill=False, edgecolor=LANDMARK, linewidth=2))
        patch = slide.axes((330 + 245 * k, 30, 170, 170), x=(x - HALF, x + HALF), y=(y + HALF, y - HALF), title=say(name))
        left, top = int(x - HALF), int(y - HALF)  # a little more than is shown: the picture is in the file again
        extent = (left - 0.5, left + 22.5, top + 22.5, top - 0.5)
        patch.imshow(photo[top:top + 23, left:left + 23], cmap="gray", interpolation="nearest", vmin=0, vmax=255, extent=extent)
        patch.set(xlim=(x - HALF, x + HALF), ylim=(y + HALF, y - HALF))
        axis, sigmas = spread(kind)
        patch.add_patch(patches.Ellipse((x, y), *(2 * DRAWN * LARGER * sigmas), angle=np.degrees(np.arctan2(axis[1], axis[0])), fill=False,
                                        edgecolor=PRIOR, linewidth=2.5))
        patch.set_axis_off()
        slide.text(415 + 245 * k, 228, say("λ of H: {large}, {small}", **dict(zip(("large", "small"), map(short_number, eigenvalues(kind)[0][::-1])))), 16)
        slide.text(415 + 245 * k, 254, say("σ [px]: {small}, {large}", small=short_number(sigmas[1]), large=short_number(sigmas[0])), 16)


@FIGURES.figure(1120, 400, "What a preintegration claims, and what is measured")
def imu(slide, tables, say):
    """Over its length, and over the rate of the IMU."""
    axes = slide.axes((70, 75, 440, 255), title=say("σ [m, rad, m/s]"), below=say("length [s]"))
    systems.preintegration_length(axes, KEPT, say)
    slide.legend(axes, 60, 10, columns=3)
    axes = slide.axes((660, 75, 440, 255), title=say("claimed σ / measured σ"), below=say("rate of the IMU [Hz]"))
    systems.preintegration_rate(axes, KEPT, say)
    slide.legend(axes, 650, 10, columns=2)


@FIGURES.figure(1120, 380, "The clock's offset and the camera's rotation, found in flight")
def calibration(slide, tables, say):
    """Thin: flights; thick: their median; gray: what the tests ask."""
    for left, quantity, title in ((70, "offset_ms", "error of the clock's offset [ms]"), (660, "rotation_deg", "error of the camera's rotation [deg]")):
        axes = slide.axes((left, 75, 440, 235), title=say(title), below=say("time [s]"))
        systems.calibration(axes, KEPT, quantity, say)
        axes.axhline(CALIBRATION_GOALS[quantity], color=MUTED, linewidth=1)
    slide.legend(axes, 60, 10, columns=2)


@FIGURES.figure(1120, 400, "The error over a distance, in three recordings")
def distance(slide, tables, say):
    for left, (recording, name) in zip((60, 435, 810), RECORDINGS.items()):
        axes = slide.axes((left, 75, 290, 225), title=say(name), below=say("part of the path [%]\ndistance [m]"))
        systems.distance(axes, KEPT, recording)
    slide.legend(axes, 60, 10, columns=2)


@FIGURES.figure(1120, 400, "A restart, aligned by segment and as one")
def segments(slide, tables, say):
    systems.segments_path(slide.axes((60, 75, 400, 250), title=say("from above"), below="x [m]"), tables, say)
    axes = slide.axes((560, 75, 530, 250), title=say("position error [m]; thin: segments aligned as one"), below=say("time [s]"))
    systems.segments_error(axes, tables, say)


@FIGURES.figure(1080, 310, "The difference of two settings, flight by flight")
def paired_flights(slide, tables, say):
    """First estimates in all edges against none, VINS policy: a dot a flight, and the mean with its standard error."""
    axes = slide.axes((80, 45, 900, 205), title=say("ATE with first estimates, less that without [m]"))
    for k, name in enumerate(FLIGHTS):
        differences, mean, error, _ = paired(name)
        axes.plot(k + np.linspace(-0.2, 0.2, len(differences)), differences, "o", alpha=0.6)
        axes.errorbar(k + 0.3, mean, error, color=INK, marker="s", capsize=5)
    axes.axhline(0, color=MUTED, linewidth=1)
    axes.set_xticks(range(len(FLIGHTS)), [say(name) for name in FLIGHTS])
