"""Visual-inertial odometry as pictures: paths, errors, time per window, the prior's eigenvalues, the window's H."""
import numpy as np

from . import style
from .digits import minus
from .numbers import windows
from .scene import XYZ, decorate
from .style import BLUE, GRAY, GREEN, plt
from .tables import read

COLORS = {"vins": BLUE, "okvis": GREEN}  # orange is what leaves a window, and the prior
DOTS = {"vins": ".", "okvis": "x"}
NAMES = {"vins": "VINS", "okvis": "OKVIS"}


def policies(table):
    """Those that the table tells of, which may be none: not every policy finds a start in every recording."""
    return [name for name in COLORS if np.any(table["policy"] == name)]


def segments(rows):
    """What lies between two restarts, each with a world frame of its own."""
    return [rows.where(segment=number) for number in np.unique(rows["segment"])]


def read_estimates(directory, name):
    """A table that has rows only of policies that have started, and only once a prior is there."""
    return read(directory, name, may_be_empty=True)


def error_line(axes, rows, policy, **look):
    """The distance from the truth over time [cm]."""
    axes.plot(rows["t_s"], 100 * rows["error_m"], color=COLORS[policy], **look)


def paths(directory):
    """From above and in 3-D, the height over time and, where there is a truth, the distance from it."""
    path = read(directory, "odometry_path")
    truth = path.where(policy="truth")
    fig = plt.figure(figsize=(10.0, 7.6), layout="constrained")
    grid = fig.add_gridspec(2, 2, height_ratios=(1.45, 1.0))
    above, space = fig.add_subplot(grid[0, 0]), fig.add_subplot(grid[0, 1], projection="3d")
    side = fig.add_subplot(grid[1, 0 if len(truth) else slice(None)])
    error = fig.add_subplot(grid[1, 1], sharex=side) if len(truth) else None
    lines = [(segments(path.where(policy=name)), {"color": COLORS[name], "linewidth": 1.3, "label": NAMES[name]}) for name in policies(path)]
    if len(truth):
        lines.insert(0, ([truth], {"color": GRAY, "linewidth": 4.0, "alpha": 0.5, "label": "truth"}))
    for pieces, look in lines:
        for k, rows in enumerate(pieces):
            of = look if k == 0 else {**look, "label": None}
            above.plot(rows["x_m"], rows["y_m"], **of)
            space.plot(*rows.matrix(*XYZ).T, **of)
            side.plot(rows["t_s"], rows["z_m"], **of)
    everything = path.matrix(*XYZ)
    low, high = everything.min(axis=0), everything.max(axis=0)
    room = np.maximum(0.0, 0.4 * (high - low).max() - (high - low)) / 2  # a walk on one floor is no sheet of paper
    decorate(space, (low - room, high + room), zoom=0.92)
    space.set_title("in 3-D")
    above.set_aspect("equal", adjustable="datalim")
    above.set(xlabel="x [m]", ylabel="y [m]", title="from above")
    above.legend(loc="best", fontsize=11)
    side.set(xlabel="time [s]", ylabel="z [m]", title="height")
    if error:
        for name in policies(path):
            for rows in segments(path.where(policy=name)):
                error_line(error, rows, name, linewidth=1.5)
        error.set(xlabel="time [s]", ylabel="[cm]", title="distance from the truth")
        error.set_ylim(bottom=0)
    style.save(fig, directory, "odometry_path")


def timing(directory):
    """Milliseconds for each image, and how they are spread."""
    tracking = read(directory, "odometry_windows").where(status="tracking")
    summary = read(directory, "odometry_policies")
    with style.panels(directory, "odometry_timing", 1, 2, (10.0, 4.2), gridspec_kw={"width_ratios": (1.6, 1.0)}) as (left, right):
        for name in policies(tracking):
            rows, p99 = tracking.where(policy=name), summary.row(policy=name)["p99_window_ms"]
            left.plot(rows["t_s"], rows["milliseconds"], DOTS[name], color=COLORS[name], markersize=3, markeredgewidth=0.7)
            left.axhline(p99, color=COLORS[name], linewidth=1.0)
            ordered = np.sort(rows["milliseconds"])
            right.plot(ordered, 100 * (np.arange(len(ordered)) + 1) / len(ordered), color=COLORS[name],
                       label=f"{NAMES[name]}: 99 % in {p99:.2g} ms")
        left.set(xlabel="time [s]", ylabel="[ms]", title="time spent on each image")
        longest = 1.3 * np.nanmax(summary["p99_window_ms"])
        left.set_ylim(0, longest)
        right.set(xlabel="[ms]", ylabel="images done within [%]", title="its distribution")
        right.set_xlim(0, longest)
        style.legend_above(right)


def spectrum(directory):
    """The eigenvalues of the prior at a few times: position and yaw are free, so four of them should be small."""
    table = read_estimates(directory, "odometry_spectrum")
    names = policies(table)
    if not names:
        return style.discard(directory, "odometry_spectrum")
    with style.panels(directory, "odometry_spectrum", 1, len(names), (10.0, 3.8), sharey=True, squeeze=False) as panels:
        for axes, name in zip(panels[0], names):
            rows = table.where(policy=name)
            times = np.unique(rows["t_s"])
            for k, t in enumerate(times):
                values = rows.where(t_s=t)["eigenvalue"]
                shade = style.SHADES(k / max(1, len(times) - 1))
                axes.plot(np.arange(1, len(values) + 1), np.maximum(values, 1e-10), color=shade, marker=style.MARKS[k % len(style.MARKS)],
                          markersize=3.5, linewidth=0.8, label=f"{t:.1f} s")
            style.log_axis(axes.yaxis)
            axes.axvspan(0.5, 4.5, color=style.PALE, zorder=0)
            axes.set(xlabel="number, ascending", title=f"{NAMES[name]}: the prior's spectrum")
            axes.legend(loc="lower right", fontsize=10)
        panels[0, 0].set_ylabel("eigenvalue")


def zeros(directory, say, policy):
    """How many eigenvalues of the last prior are zero in the arithmetic, and the next one."""
    rows = read_estimates(directory, "odometry_spectrum").where(policy=policy)
    values = np.sort(rows.where(t_s=rows["t_s"].max())["eigenvalue"])
    count = int((values <= 1e-12 * values[-1]).sum())
    if count == len(values):
        return say("odometry_spectrum.all", policy=NAMES[policy])
    return say("odometry_spectrum.zeros", policy=NAMES[policy], count=count, next=style.number(values[count], 2))


def leak(directory, say, policy):
    """What the priors claim of yaw."""
    values = windows.leak(read_estimates(directory, "odometry_gauge"), policy)
    return say("odometry_gauge.leak", policy=NAMES[policy], most=style.number(max(values), 2),
               last=style.number(values[-1], 2))


def leak_line(axes, times, values, policy, **look):
    """|nᵀHn| of the priors over time, where it is above 1e-12."""
    axes.plot(times, np.where(np.abs(values) > 1e-12, np.abs(values), np.nan), color=COLORS[policy], **look)


def gauge(directory):
    """What the prior knows of position and yaw, over time."""
    table = read_estimates(directory, "odometry_gauge")
    if not policies(table):
        return style.discard(directory, "odometry_gauge")
    with style.panels(directory, "odometry_gauge", 1, 2, (10.0, 3.8)) as panels:
        for name in policies(table):
            yaw = table.where(policy=name, direction="yaw")
            position = sum(table.where(policy=name, direction=axis)["information"] for axis in "xyz")
            for axes, values in zip(panels, (yaw["information"], position)):
                leak_line(axes, yaw["t_s"], values, name, label=NAMES[name], linewidth=1.2)
        for axes, title in zip(panels, ("the prior's leak of yaw [rad⁻²]", "its leak of position [m⁻²]")):
            style.log_axis(axes.yaxis)
            axes.set(xlabel="time [s]", title=title)
        panels[0].legend(loc="best", fontsize=11)  # what the priors know of position is rounding, all over the other panel


def path_words(say, rows, answered):
    """How far each policy is from the truth, and which has found no start."""
    started = [name for name in rows if answered[name]]
    words = say("odometry_path.alone")
    if all(np.isfinite(rows[name]["ate_m"]) for name in started):
        errors = [say("odometry_path.error" if np.isfinite(rows[name]["scale_error"]) else "odometry_path.at_rest",
                      policy=NAMES[name], distance=style.number(100 * rows[name]["ate_m"], 2),
                      scale=minus(f"{100 * rows[name]['scale_error']:+.1f}")) for name in started]
        words = say("odometry_path", errors=say("semicolon").join(errors))
    shown, line, folded = words.partition("\n")
    return shown + "".join(say("odometry_path.silent", policy=NAMES[name]) for name in rows if not answered[name]) + line + folded


def machine(directory, say):
    """What the times of this run were measured on."""
    about = read(directory, "odometry_machine").rows()[0]
    return say("machine", **{**about, "load": f"{about['load']:.0f}"})


def captions(directory, say):
    """{figure: its words}, with every number taken from the tables; only of the figures that are drawn."""
    summary, windows = read(directory, "odometry_policies"), read(directory, "odometry_windows")
    rows = {name: summary.row(policy=name) for name in policies(summary)}
    answered = {name: len(windows.where(status="tracking", policy=name)) for name in rows}
    each = lambda tell, names: say("semicolon").join(tell(name) for name in names)
    speed = lambda name: say("odometry_timing.speed", policy=NAMES[name], times=f"{rows[name]['realtime_factor']:.0f}",
                              tracking=f"{rows[name]['tracking_factor']:.0f}")
    words = {
        "odometry_path": path_words(say, rows, answered),
        "odometry_timing": say("odometry_timing", images=max(answered.values()), machine=machine(directory, say),
                               speeds=each(speed, [name for name in rows if answered[name]])),
    }
    if names := policies(read_estimates(directory, "odometry_spectrum")):
        words["odometry_spectrum"] = say("odometry_spectrum", zeros=each(lambda name: zeros(directory, say, name), names))
    if names := policies(read_estimates(directory, "odometry_gauge")):
        words["odometry_gauge"] = say("odometry_gauge", leaks=each(lambda name: leak(directory, say, name), names))
    return words


def draw(directory):
    paths(directory)
    timing(directory)
    spectrum(directory)
    gauge(directory)
