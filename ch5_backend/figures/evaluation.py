"""A recording's estimates, judged: errors over time and after pieces of the path, σ beside errors, features, biases, and what happened when."""
import numpy as np

from . import odometry, style
from .odometry import COLORS, NAMES, policies, read_estimates, segments
from .style import GRAY, INK, PALE
from .tables import read

HONEST = (1.24, 14.45)  # 95 % of χ² with 6 degrees of freedom lie between
OF_PIECES = {"position_m": "position error [m]", "yaw_deg": "yaw error [deg]"}
OF_SIGMA = {"position [m]": ("sigma_m", "error_m"), "rotation [deg]": ("rotation_sigma_deg", "rotation_error_deg")}
BIASES = {"accelerometer's bias [m/s²]": ("bax_m_s2", "bay_m_s2", "baz_m_s2"),
          "gyroscope's bias [rad/s]": ("bgx_rad_s", "bgy_rad_s", "bgz_rad_s")}


def boxes(axes, of):
    """Quartiles and median of each policy's rows, one a length of the path; whiskers: 5 and 95 %."""
    for at, (policy, rows) in enumerate(of.items()):
        color, shift = {"color": COLORS[policy]}, 0.34 * (at - (len(of) - 1) / 2)
        for k, row in enumerate(rows.rows()):
            if np.isfinite(row["q50"]):
                box = {"med": row["q50"], "q1": row["q25"], "q3": row["q75"], "whislo": row["q05"], "whishi": row["q95"]}
                axes.bxp([box], positions=[k + shift], widths=0.28, showfliers=False, boxprops=color, medianprops=color,
                         whiskerprops=color, capprops=color)
        axes.plot([], [], color=COLORS[policy], label=NAMES[policy])
    lengths = next(iter(of.values())).rows()
    axes.set_xticks(range(len(lengths)), [f"{100 * row['share']:.0f}\n{row['distance_m']:.2g}" for row in lengths])
    axes.set_ylim(0, None)


def pieces(directory):
    """The errors after pieces of the path, as boxes."""
    table = read_estimates(directory, "odometry_lengths")
    if not len(table):
        return style.discard(directory, "odometry_lengths")
    with style.panels(directory, "odometry_lengths", 1, 2, (10.0, 4.2), legend=3) as panels:
        for axes, (quantity, title) in zip(panels, OF_PIECES.items()):
            boxes(axes, {name: table.where(policy=name, quantity=quantity) for name in policies(table)})
            axes.set(title=title, xlabel="part of the path [%]\ndistance [m]")


def sigmas(directory):
    """σ and error of the newest frame's motion since the oldest, a point a window, and the NEES over time."""
    table = read_estimates(directory, "odometry_consistency")
    if not len(table):
        return style.discard(directory, "odometry_consistency")
    with style.panels(directory, "odometry_consistency", 1, 3, (10.0, 4.0), legend=3) as panels:
        for axes, (title, columns) in zip(panels, OF_SIGMA.items()):
            values = table.matrix(*columns)
            span = np.array([np.nanmin(values[values > 0]), np.nanmax(values)])
            axes.plot(span, span, color=INK, linewidth=1)
            for name in policies(table):
                axes.plot(*table.where(policy=name).matrix(*columns).T, odometry.DOTS[name], color=COLORS[name], markersize=4,
                          alpha=0.6, label=NAMES[name])
            style.log_axis(axes.xaxis)
            style.log_axis(axes.yaxis)
            axes.set(title=title, xlabel="claimed σ")
        panels[0].set_ylabel("error")
        for name in policies(table):
            rows = table.where(policy=name)
            panels[2].plot(rows["t_s"], rows["nees"], odometry.DOTS[name], color=COLORS[name], markersize=4, alpha=0.6)
        panels[2].axhspan(*HONEST, color=PALE, zorder=0)
        style.plain_log(panels[2].yaxis)
        panels[2].set(title="NEES of the motion (6)", xlabel="time [s]")


def spans(rows, keep, end):
    """(begin, length) of each run of images that are kept; an image lasts until the next one, the last until `end`."""
    times = np.append(rows["t_s"], end)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], keep.astype(int), [0]))))
    return [(times[first], times[last] - times[first]) for first, last in edges.reshape(-1, 2)]


def restarts(directory):
    """{reason: {policy: times}}, in the order in which they came."""
    reasons = {}
    for row in sorted(read(directory, "odometry_windows").where(status="restarted").rows(), key=lambda row: row["t_s"]):
        reasons.setdefault(row["failure"], {}).setdefault(row["policy"], []).append(row["t_s"])
    return reasons


def lettered(reasons):
    """(letter, reason, {policy: times})."""
    return [(chr(ord("a") + k), reason, of) for k, (reason, of) in enumerate(reasons.items())]


def timeline(directory):
    """What each policy did when, the warnings, and below them the features of each image."""
    images, warnings = read(directory, "odometry_windows"), read_estimates(directory, "odometry_warnings").rows()
    names, begin, end = policies(images), images["t_s"].min(), images["t_s"].max()
    with style.panels(directory, "odometry_timeline", 2, 1, (10.0, 5.0), sharex=True, gridspec_kw={"height_ratios": (1.0, 1.6)}) as (what, features):
        for at, name in enumerate(names):
            rows = images.where(policy=name)
            tracking, solved = rows["status"] == "tracking", np.isfinite(rows["iterations"])
            for keep, look in ((tracking & solved, {"color": COLORS[name]}), (tracking & ~solved, {"color": COLORS[name], "alpha": 0.35}),
                               (~tracking, {"color": PALE})):
                what.broken_barh(spans(rows, keep, end), (at - 0.3, 0.6), linewidth=0, **look)
            for letter, _, of in lettered(restarts(directory)):
                times = of.get(name, [])
                what.plot(times, [at] * len(times), "X", color=INK, markersize=11, markeredgecolor="white")
                for k, t in enumerate(times):  # near to one another they have one letter
                    if k == 0 or t - times[k - 1] > 0.03 * (end - begin):
                        what.text(t, at - 0.31, letter, ha="center", va="bottom", weight="bold", fontsize=12)
        for number, row in enumerate(warnings, start=1):
            if np.isfinite(row["t_s"]):
                what.text(row["t_s"], len(names), f"{number}", ha="center", va="center", weight="bold", fontsize=12)
        whole = ", ".join(f"{number}" for number, row in enumerate(warnings, start=1) if not np.isfinite(row["t_s"]))
        last = [f"warnings {whole}" if whole else "warnings"] if warnings else []
        what.set_yticks(range(len(names) + len(last)), [*(NAMES[name] for name in names), *last])
        what.set(ylim=(len(names) + len(last) - 0.4, -0.6), xlim=(begin, end))
        what.grid(axis="y", visible=False)
        seen = images.where(policy=names[0])
        features.plot(seen["t_s"], seen["tracks"], color=GRAY, linewidth=1.2, label="tracked in the image")
        for name in names:
            rows = images.where(policy=name)
            features.plot(rows["t_s"], rows["landmarks"], color=COLORS[name], linewidth=1.2, label=f"{NAMES[name]}: used in the solve")
        features.set(xlabel="time [s]", title="features")
        features.set_ylim(bottom=0)
        features.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=3, fontsize=10, borderaxespad=0.2)


def biases(directory):
    """The estimated biases over time, over the truth's where it has them."""
    path = read(directory, "odometry_path")
    truth = path.where(policy="truth")
    with style.panels(directory, "odometry_biases", 2, 3, (10.0, 5.0), legend=3, sharex=True) as panels:
        for line, (title, columns) in zip(panels, BIASES.items()):
            for axes, axis, column in zip(line, "xyz", columns):
                if np.any(np.isfinite(truth[column])):
                    axes.plot(truth["t_s"], truth[column], color=GRAY, linewidth=4.0, alpha=0.5, label="truth")
                for name in policies(path):
                    for k, rows in enumerate(segments(path.where(policy=name))):
                        axes.plot(rows["t_s"], rows[column], color=COLORS[name], linewidth=1.3, label=NAMES[name] if k == 0 else None)
                axes.set_title(f"{axis}: {title}" if axis == "x" else axis)
        for axes in panels[1]:
            axes.set_xlabel("time [s]")


def captions(directory, say):
    """{figure: its words}; those that need a truth only where there is one."""
    each = lambda tell, names: say("semicolon").join(tell(name) for name in names)  # noqa: E731
    images, words = read(directory, "odometry_windows"), {}
    table = read_estimates(directory, "odometry_lengths").where(quantity="position_m", share=0.1)
    if names := policies(table):
        median = lambda name: say("odometry_lengths.median", policy=NAMES[name], error=style.number(table.row(policy=name)["q50"], 2))  # noqa: E731
        words["odometry_lengths"] = say("odometry_lengths", medians=each(median, names), distance=style.number(table["distance_m"][0], 2))
    table = read_estimates(directory, "odometry_consistency")
    if names := policies(table):
        def nees(name):
            values = table.where(policy=name)["nees"]
            inside = ((values >= HONEST[0]) & (values <= HONEST[1])).mean()
            return say("odometry_consistency.nees", policy=NAMES[name], inside=style.percent(inside))
        words["odometry_consistency"] = say("odometry_consistency", found=each(nees, names))
    used = lambda name: say("odometry_timeline.used", policy=NAMES[name], used=style.number(np.nanmedian(images.where(policy=name)["landmarks"])))  # noqa: E731
    names = [name for name in policies(images) if np.any(np.isfinite(images.where(policy=name)["landmarks"]))]
    seen = images.where(policy=policies(images)[0])["tracks"]
    times = lambda of: say("semicolon").join(NAMES[name] + " " + ", ".join(f"{t:.1f}" for t in of[name]) for name in of)  # noqa: E731
    words["odometry_timeline"] = say("odometry_timeline", tracks=style.number(np.median(seen)), used=each(used, names)) + "".join(
        say("odometry_timeline.restarts", letter=letter, reason=say(f"failure.{reason}"), times=times(of)) for letter, reason, of in lettered(restarts(directory)))
    words["odometry_biases"] = say("odometry_biases")
    return words


def draw(directory):
    pieces(directory)
    sigmas(directory)
    timeline(directory)
    biases(directory)
