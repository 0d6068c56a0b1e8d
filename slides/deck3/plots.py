"""The deck's plots of windows and priors, drawn from the chapter's tables."""

import sys
from math import ceil

from ..chart import Axes, decades, legend
from ..deck1.plots import cells
from ..svg import CROSS, FAINT, INK, LANDMARK, MUTED, PAPER, POSE, PRIOR, Svg, mix

WORDS = {
    "en": {"before": "before", "good": "landmarks, then frame 0", "bad": "frame 0 at once", "track": "track",
           "frame": "frame", "index": "eigenvalue, ascending", "absolute": "eigenvalues of H", "scaled": "of P⁻¹HP⁻¹",
           "vins cut": "VINS-Mono's cut", "okvis cut": "OKVIS's cut", "prior": "into the prior",
           "again": "into the prior, and used again", "lost": "lost", "stays": "untouched", "image": "image",
           "time": "time [s]", "error": "distance from the truth [cm]", "window": "H of the window",
           "after": "prior after the slide", "states": "states", "landmarks": "landmarks"},
    "zh": {"before": "之前", "good": "先路标点，再第 0 帧", "bad": "直接去掉第 0 帧", "track": "特征轨迹",
           "frame": "帧", "index": "特征值（升序）", "absolute": "H 的特征值", "scaled": "P⁻¹HP⁻¹ 的特征值",
           "vins cut": "VINS-Mono 的阈值", "okvis cut": "OKVIS 的阈值", "prior": "进入先验",
           "again": "进入先验，又被使用", "lost": "丢弃", "stays": "未动", "image": "图像",
           "time": "时间 [s]", "error": "与真值的距离 [cm]", "window": "窗口的 H",
           "after": "滑动后的先验", "states": "状态", "landmarks": "路标点"},
}
POLICIES = {"vins": ("VINS-Mono", POSE), "okvis": ("OKVIS", CROSS)}
FATES = {"prior": PRIOR, "again": LANDMARK, "lost": mix(INK, 0.3), "stays": POSE}


def fill(tables, lang):
    """H of a scene: whole, without landmarks and frame 0, and without frame 0 only."""
    words = WORDS[lang]
    svg = Svg(1090, 385, "What the order of marginalisation fills in")
    names = (("before", "before"), ("without landmarks and frame 0", "good"), ("without frame 0", "bad"))
    for k, (stage, name) in enumerate(names):
        size = int(tables.row("marginalize_fill", stage=stage)["size"])
        side = 320 * size / int(tables.row("marginalize_fill", stage="before")["size"])
        x = 20 + 365 * k + (320 - side) / 2
        cells(svg, x, 20 + (320 - side) / 2, side, tables.matrix("marginalize_scene", stage=stage), size)
        svg.text(20 + 365 * k + 160, 370, f"{words[name]}: {size} × {size}", 18)
    return svg.render()


def spectra(tables, policy="vins"):
    """Eigenvalues of the last prior of the flight, and of P⁻¹HP⁻¹ with OKVIS's P."""
    last = max(tables.column("odometry_spectrum", "t_s", policy=policy))
    return [tables.column("odometry_spectrum", name, policy=policy, t_s=last) for name in ("eigenvalue", "scaled")]


def cuts(scaled):
    """Up to where an eigenvalue counts as zero: VINS-Mono's kEps, OKVIS's ε·n·λ_max."""
    return 1e-8, sys.float_info.epsilon * len(scaled) * max(scaled)


def prior_spectrum(tables, lang):
    words = WORDS[lang]
    svg = Svg(1080, 370, "Eigenvalues of a prior, and where they are cut")
    plain, scaled = spectra(tables)
    panels = zip((plain, scaled), cuts(scaled), ("absolute", "scaled"), ("vins cut", "okvis cut"))
    for panel, (values, cut, title, name) in enumerate(panels):
        sizes = [max(abs(value), 1e-17) for value in values]
        ticks = decades([*sizes, cut])
        axes = Axes(svg, (75 + 545 * panel, 42, 440, 250), (0, len(values)), (ticks[0], ticks[-1]), log_y=True)
        axes.draw(words["index"], words[title], range(0, len(values) + 1, 10), ticks[::4])
        svg.line(axes.left, axes.y(cut), axes.left + axes.width, axes.y(cut), PRIOR, 1.6, dash="6 5")
        svg.text(axes.left + axes.width - 6, axes.y(cut) - 8, words[name], 16, PRIOR, anchor="end")
        for i, value in enumerate(sizes):
            svg.circle(axes.x(i + 0.5), axes.y(value), 5 if i < 4 else 3, LANDMARK if i < 4 else POSE)
    return svg.render()


class TrackGrid:
    """Landmarks to the right, frames downwards: one dot an observation."""

    def __init__(self, svg, tables, box, policy, lang):
        self.svg, self.rows = svg, tables.rows("slide_observations", policy=policy)
        self.left, self.top, width, height = box
        self.landmarks = sorted({row["landmark"] for row in self.rows},
                                key=lambda n: [row["frame"] for row in self.rows if row["landmark"] == n])
        self.frames = int(max(row["frame"] for row in self.rows)) + 1
        self.dx, self.dy = width / len(self.landmarks), height / self.frames
        self.words = WORDS[lang]

    def at(self, row):
        return self.left + (self.landmarks.index(row["landmark"]) + 0.5) * self.dx, self.top + (row["frame"] + 0.5) * self.dy

    def draw(self, colour_of, radius):
        for frame in range(self.frames):
            y = self.top + (frame + 0.5) * self.dy
            self.svg.line(self.left, y, self.left + self.dx * len(self.landmarks), y, FAINT, 1)
            self.svg.text(self.left - 10, y + 5, str(frame), 16, MUTED, anchor="end")
        for landmark in self.landmarks:
            places = [self.at(row) for row in self.rows if row["landmark"] == landmark]
            self.svg.line(*places[0], *places[-1], FAINT, 2)
        for row in self.rows:
            colour = colour_of(row)
            self.svg.circle(*self.at(row), radius, PAPER if row["host"] else colour, colour, 2.6)


def slide_tracks(tables, lang):
    """The window that both policies get."""
    svg = Svg(1060, 345, "Which frame sees which landmark")
    grid = TrackGrid(svg, tables, (70, 25, 970, 275), "vins", lang)
    grid.draw(lambda row: POSE, 7.5)
    svg.text(555, 335, WORDS[lang]["track"], 17)
    svg.text(22, 165, WORDS[lang]["frame"], 17, rotate=-90)
    return svg.render()


def slide_fates(tables, lang):
    """What a slide of each policy makes of each observation."""
    words = WORDS[lang]
    svg = Svg(1100, 300, "What becomes of each observation")
    for panel, policy in enumerate(POLICIES):
        grid = TrackGrid(svg, tables, (35 + 550 * panel, 40, 500, 205), policy, lang)
        grid.draw(lambda row: FATES[row["fate"]], 5.5)
        svg.text(35 + 550 * panel + 250, 24, POLICIES[policy][0], 19, weight="bold")
    x = 60
    for fate, colour in FATES.items():
        svg.circle(x, 277, 7, colour)
        svg.text(x + 16, 283, words[fate], 17, anchor="start")
        x += 310 if fate == "again" else 220
    return svg.render()


def slide_priors(tables, lang):
    """H of the window with what goes marked, and the prior afterwards, on the same scale."""
    words = WORDS[lang]
    svg = Svg(1080, 350, "The two priors")
    for panel, (policy, (name, _)) in enumerate(POLICIES.items()):
        left = 15 + 545 * panel
        rows = tables.rows("slide_matrices", policy=policy, stage="window")
        size, side = int(rows[0]["size"]), 270
        unit = side / size
        cells(svg, left, 45, side, {(int(r["row"]), int(r["column"])): r["value"] for r in rows}, size)
        for vertex in tables.rows("slide_vertices", policy=policy, fate="marginalised"):
            y, height = 45 + vertex["row"] * unit, vertex["rows"] * unit
            svg.rect(left, y, side, height, mix(PRIOR, 0.6), opacity=0.42)
            svg.rect(left + y - 45, 45, height, side, mix(PRIOR, 0.6), opacity=0.42)
        svg.line(left + side + 12, 180, left + side + 42, 180, arrow=True)
        prior = tables.matrix("slide_matrices", policy=policy, stage="after")
        columns = int(tables.row("slide_priors", policy=policy, stage="after")["columns"])
        shown = columns * 190 / 51
        cells(svg, left + side + 55, 180 - shown / 2, shown, prior, columns)
        svg.text(left + 135, 30, f"{name}: {words['window']}", 17)
        svg.text(left + 135, 340, f"{size} × {size}", 17, MUTED)
        svg.text(left + side + 55 + shown / 2, 340, f"{words['after']}: {columns} × {columns}", 17, MUTED)
    return svg.render()


def slide_film(tables, lang):
    """Which frames each policy's window holds after each image."""
    words = WORDS[lang]
    images = int(max(tables.column("slide_frames", "image"))) + 1
    svg = Svg(1120, 412, "The windows image by image")
    width, height = 15.5, 11.0
    for panel, (policy, (name, _)) in enumerate(POLICIES.items()):
        left, top = 70 + 550 * panel, 35
        svg.text(left + images * width / 2, 22, name, 19, weight="bold")
        for row in tables.rows("slide_frames", policy=policy):
            svg.rect(left + row["frame"] * width + 1, top + row["image"] * height + 0.8, width - 3, height - 2,
                     mix(POSE, 0.85 if row["speed"] else 0.3), PRIOR if row["in_prior"] else None,
                     stroke_width=1.5 if row["in_prior"] else None)
        for n in range(0, images, 5):
            svg.text(left + (n + 0.5) * width, top + images * height + 20, str(n), 15, MUTED)
            svg.text(left - 8, top + (n + 0.5) * height + 5, str(n), 15, MUTED, anchor="end")
        svg.text(left + images * width / 2, 407, words["frame"], 17)
        svg.text(left - 45, top + images * height / 2, words["image"], 17, rotate=-90)
    return svg.render()


def odometry_error(tables, lang):
    """The distance from the truth over the longer flight."""
    words = WORDS[lang]
    svg = Svg(1060, 330, "Distance from the truth")
    paths = {policy: tables.rows("odometry_path", policy=policy) for policy in POLICIES}
    end = max(row["t_s"] for rows in paths.values() for row in rows)
    top = 5 * ceil(20 * max(row["error_m"] for rows in paths.values() for row in rows))
    axes = Axes(svg, (70, 40, 800, 225), (0, end), (0, top))
    axes.draw(words["time"], words["error"], range(0, int(end) + 1, 5), range(0, top + 1, 5))
    for policy, rows in paths.items():
        axes.curve([row["t_s"] for row in rows], [100 * row["error_m"] for row in rows], POLICIES[policy][1], dots=False)
    legend(svg, 900, 70, [(name, colour, None) for name, colour in POLICIES.values()])
    return svg.render()


ALL = {"fill": fill, "prior_spectrum": prior_spectrum, "slide_tracks": slide_tracks, "slide_fates": slide_fates,
       "slide_priors": slide_priors, "slide_film": slide_film, "odometry_error": odometry_error}
