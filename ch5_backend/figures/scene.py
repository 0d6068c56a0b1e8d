"""The scenes in 3-D, before and after bundle adjustment: cameras and points against the truth."""
import numpy as np

from . import style
from .style import BLUE, GRAY, INK, plt
from .tables import read
from .words import Labels


def rotate(q, v):
    """R(q) v for a quaternion x, y, z, w."""
    u, w = q[:3], q[3]
    return v + 2 * np.cross(u, np.cross(u, v) + w * v)


def camera(axes, position, q, size, **line):
    """A pyramid that opens along the camera's z axis."""
    image = ((-1, -0.7), (1, -0.7), (1, 0.7), (-1, 0.7))
    corners = [position + size * rotate(q, np.array([x, y, 1.4])) for x, y in image]
    ring = np.array([*corners, corners[0]])
    axes.plot(*ring.T, **line)
    for corner in corners:
        axes.plot(*np.array([position, corner]).T, **line)


XYZ, QUATERNION = ("x_m", "y_m", "z_m"), ("qx", "qy", "qz", "qw")


def panel(axes, frames, points, state, limits):
    truth = points.where(state="truth").matrix(*XYZ)
    estimate = points.where(state=state).matrix(*XYZ)
    inside = np.all((estimate > limits[0]) & (estimate < limits[1]), axis=1)  # 3-D axes do not clip by themselves
    few = len(truth) <= 50
    for a, b in zip(truth[inside], estimate[inside]):
        axes.plot(*np.array([a, b]).T, color=BLUE, linewidth=1.0 if few else 0.6, alpha=0.7)
    axes.scatter(*truth.T, s=26 if few else 9, facecolors="none", edgecolors=GRAY, linewidths=0.8, depthshade=False)
    axes.scatter(*estimate[inside].T, s=16 if few else 5, color=BLUE, depthshade=False)
    for which, line in (("truth", dict(color=GRAY, linewidth=1.0)), (state, dict(color=BLUE, linewidth=1.6))):
        rows = frames.where(state=which)
        for p, q in zip(rows.matrix(*XYZ), rows.matrix(*QUATERNION)):
            camera(axes, p, q, 0.55, **line)
    return int(np.sum(~inside))


def decorate(axes, limits, zoom=1.06):
    axes.set_xlim(limits[0][0], limits[1][0])
    axes.set_ylim(limits[0][1], limits[1][1])
    axes.set_zlim(limits[0][2], limits[1][2])
    axes.set_box_aspect(limits[1] - limits[0], zoom=zoom)
    axes.view_init(elev=16, azim=-68)
    for axis, label in ((axes.xaxis, "x [m]"), (axes.yaxis, "y [m]"), (axes.zaxis, "z [m]")):
        axis.set_pane_color((1, 1, 1, 0))
        axis._axinfo["grid"].update(color="#e6e6e6", linewidth=0.6)
        axis.set_label_text(label, fontsize=10.6)
        axis.labelpad = 1
        axis.set_major_locator(plt.MaxNLocator(4))
        axis.set_tick_params(labelsize=10.6, pad=-1)


def length(meters):
    return "0 m" if meters == 0 else f"{1e3 * meters:.2g} mm" if meters < 0.1 else f"{meters:.2f} m"


def before_and_after(fig, frames, points, summary, say):
    """A scene's start and result; the tables hold this scene alone."""
    everything = np.vstack([table.where(state="truth").matrix(*XYZ) for table in (points, frames)])
    limits, row = (everything.min(axis=0) - 1.0, everything.max(axis=0) + 1.0), summary.row()
    for i, (state, name) in enumerate((("initial", "start"), ("final", "result, aligned"))):
        axes = fig.add_axes([0.005 + 0.5 * i, 0.06, 0.475, 0.88], projection="3d")
        outside = panel(axes, frames, points, state, limits)
        decorate(axes, limits)
        fig.text(0.04 + 0.5 * i, 0.93, say(name), fontsize=15, weight="bold")
        note = say("RMSE: points {a}, cameras {b}" if state == "initial" else
                   "RMSE, points aligned by points: {a},\ncameras by cameras: {b}",
                   a=length(row[f"{state}_rmse_landmark_m"]), b=length(row[f"{state}_rmse_position_m"]))
        if outside:
            note += "\n" + say("{n} of {m} points lie outside the picture", n=outside, m=int(row["points"]))
        fig.text(0.04 + 0.5 * i, 0.905, note, fontsize=10.5, color=INK, va="top")
    fig.text(0.5, 0.015, say("gray: truth; blue: estimate, tied to its truth by a line"), ha="center", fontsize=10.5, color=GRAY)


def draw(directory):
    tables = [read(directory, name) for name in ("mono_ba_frames", "mono_ba_points", "mono_ba_summary")]
    for scene in tables[2]["scene"]:
        fig = plt.figure(figsize=style.WIDE)
        before_and_after(fig, *(table.where(scene=scene) for table in tables), Labels("en"))
        style.save(fig, directory, f"scene_{scene}")
