"""The deck's plots of certainty: NEES, the information on yaw, and what has leaked into a prior."""

from math import ceil

from ..chart import Axes, decades, legend
from ..svg import CROSS, LANDMARK, MUTED, POSE, PRIOR, Svg, mix, number

WORDS = {
    "en": {"time": "time [s]", "nees": "NEES of the pose, mean of the flights", "none": "no constraints",
           "prior_only": "prior only", "full": "all edges", "twice": "used twice", "once": "used once",
           "band": "95 % of honest means", "yaw": "information on yaw, of its start", "leak": "nᵀHn of the prior",
           "yaw of": "yaw, ", "position of": "position, "},
    "zh": {"time": "时间 [s]", "nees": "位姿的 NEES（各次飞行的均值）", "none": "无约束", "prior_only": "只约束先验",
           "full": "约束所有边", "twice": "用了两次", "once": "只用一次", "band": "一致时均值的 95% 区间",
           "yaw": "航向角的信息（相对起点）", "leak": "先验的 nᵀHn", "yaw of": "航向，", "position of": "位置，"},
}
MODES = {"none": LANDMARK, "prior_only": PRIOR, "full": POSE}
CONSISTENCY = "../nees/csv/consistency"


def rows_of(tables, policy, mode):
    return tables.rows(CONSISTENCY, policy=policy, mode=mode)


def nees_axes(svg, tables, lang, top, rows):
    """Axes with the χ² band of the mean, which narrows where runs have ended."""
    words, end = WORDS[lang], max(row["t_s"] for row in rows)
    axes = Axes(svg, (70, 40, 740, 245), (0, end), (0, top))
    low = [(axes.x(row["t_s"]), axes.y(row["pose_low"])) for row in rows]
    high = [(axes.x(row["t_s"]), axes.y(row["pose_high"])) for row in rows]
    outline = "M" + " L".join(f"{number(x)} {number(y)}" for x, y in low + high[::-1]) + "Z"
    svg.path(outline, None, None, fill=mix(CROSS, 0.25))
    axes.draw(words["time"], words["nees"], range(0, int(end) + 1, 2 if end < 15 else 5), range(0, top + 1, top // 5))
    return axes


def draw_nees(axes, rows, colour):
    axes.curve([row["t_s"] for row in rows], [row["nees_pose"] for row in rows], colour, dots=False)


def band_entry(svg, x, y, words):
    svg.rect(x, y - 8, 30, 16, mix(CROSS, 0.25))
    svg.text(x + 40, y + 6, words["band"], 16, anchor="start")


def nees_twice(tables, lang):
    """VINS-Mono's observations used twice, as published, and once."""
    words = WORDS[lang]
    svg = Svg(1080, 350, "NEES of observations used twice and once")
    twice, once = rows_of(tables, "vins twice", "none"), rows_of(tables, "vins", "none")
    axes = nees_axes(svg, tables, lang, 20 * ceil(max(row["nees_pose"] for row in twice) / 20), once)
    draw_nees(axes, twice, PRIOR)
    draw_nees(axes, once, POSE)
    legend(svg, 840, 80, [(words["twice"], PRIOR, None), (words["once"], POSE, None)])
    band_entry(svg, 840, 140, words)
    return svg.render()


def nees_modes(tables, lang):
    """The three modes of the VINS policy."""
    words = WORDS[lang]
    svg = Svg(1080, 350, "NEES of three modes of first estimates")
    rows = {mode: rows_of(tables, "vins", mode) for mode in MODES}
    top = 5 * ceil(max(row["nees_pose"] for own in rows.values() for row in own) / 5)
    axes = nees_axes(svg, tables, lang, top, rows["none"])
    for mode, own in rows.items():
        draw_nees(axes, own, MODES[mode])
    legend(svg, 840, 80, [(words[mode], colour, None) for mode, colour in MODES.items()])
    band_entry(svg, 840, 168, words)
    return svg.render()


def yaw_information(tables, lang):
    """The mean information on the newest frame's yaw, of that at the start."""
    words = WORDS[lang]
    svg = Svg(1060, 350, "The information on yaw over time")
    rows = {mode: rows_of(tables, "vins", mode) for mode in MODES}
    end = max(row["t_s"] for row in rows["none"])
    top = max(row["yaw_information"] / own[0]["yaw_information"] for own in rows.values() for row in own)
    axes = Axes(svg, (70, 40, 740, 245), (0, end), (0, ceil(top)))
    axes.draw(words["time"], words["yaw"], range(0, int(end) + 1, 2 if end < 15 else 5), range(0, ceil(top) + 1))
    for mode, own in rows.items():
        axes.curve([row["t_s"] for row in own], [row["yaw_information"] / own[0]["yaw_information"] for row in own],
                   MODES[mode], dots=False)
    legend(svg, 840, 80, [(words[mode], colour, None) for mode, colour in MODES.items()])
    return svg.render()


def yaw_leak(tables, lang):
    """What the priors of the longer flight claim to know of yaw and of position."""
    words = WORDS[lang]
    svg = Svg(1060, 340, "Information on what nothing measures")
    series = []
    for policy, name, colour in (("vins", "VINS-Mono", POSE), ("okvis", "OKVIS", CROSS)):
        for of, dash in (("yaw", None), ("x", "3 6")):
            rows = tables.rows("odometry_gauge", policy=policy, direction=of)
            series.append((words["yaw of" if of == "yaw" else "position of"] + name, rows, colour, dash))
    ticks = decades([1e-6] + [row["information"] for _, rows, *_ in series for row in rows if row["information"] > 0])
    low = 1e-6
    end = max(row["t_s"] for _, rows, *_ in series for row in rows)
    axes = Axes(svg, (80, 40, 690, 230), (0, end), (low, ticks[-1]), log_y=True)
    axes.draw(words["time"], words["leak"], range(0, int(end) + 1, 5), [t for t in ticks if t >= low][::2])
    for _, rows, colour, dash in series:
        used = [row for row in rows if abs(row["information"]) > low]
        axes.curve([row["t_s"] for row in used], [abs(row["information"]) for row in used], colour, dash, dots=False)
    legend(svg, 800, 90, [(name, colour, dash) for name, _, colour, dash in series])
    return svg.render()


ALL = {"nees_twice": nees_twice, "nees_modes": nees_modes, "yaw_information": yaw_information, "yaw_leak": yaw_leak}
