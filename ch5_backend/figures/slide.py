"""Figures of the decks: shapes and words placed in pixels, and axes for plots, drawn by matplotlib as SVG.

Words stay words: the reader's browser sets them, in its own font for Chinese, so that no font changes a file.
"""
import functools
import io
import logging
import re

import numpy as np
from matplotlib import colormaps, patches
from matplotlib.colors import LinearSegmentedColormap, to_hex, to_rgb
from matplotlib.path import Path
from matplotlib.text import Text
from matplotlib.textpath import TextPath
from matplotlib.transforms import Affine2D

from . import style
from .style import plt
from .words import Labels

# One meaning, one color, on every page: poses, landmarks, what ties them, priors.
INK, MUTED, FAINT, PAPER = "#22303c", "#6b7a88", "#d5dce2", "#ffffff"
POSE, LANDMARK, CROSS, PRIOR = "#3b76a8", "#d99a3c", "#5d9c86", "#c2555b"
PX = 0.75  # points
SUBSCRIPT = re.compile(r"\b([Hb])_([a-z]{2}|S)(?![A-Za-z])")  # of H_ll and b_S in a figure's words

LOOK = {
    "svg.fonttype": "none", "font.family": ["Noto Sans", "Noto Sans CJK SC", "Noto Sans CJK JP", "PingFang SC",
                                            "Microsoft YaHei", "sans-serif"],
    "font.sans-serif": ["DejaVu Sans"], "font.size": 18.1 * PX, "legend.fontsize": 18.1 * PX, "text.color": INK,
    "axes.prop_cycle": plt.cycler(color=[POSE, PRIOR, CROSS, LANDMARK, "#7ba3c4", "#7a5195"]),  # style.BLUE …
    "axes.titlesize": 18.5 * PX, "axes.titlepad": 10 * PX, "axes.labelsize": 18.5 * PX, "axes.labelcolor": INK,
    "axes.labelpad": 7 * PX, "axes.edgecolor": MUTED, "axes.linewidth": 1.2 * PX, "axes.spines.left": False,
    "axes.grid.axis": "y", "grid.color": FAINT, "grid.linewidth": PX, "xtick.color": MUTED, "ytick.color": MUTED,
    "ytick.major.size": 0, "xtick.major.size": 5 * PX, "xtick.major.width": PX, "xtick.major.pad": 6 * PX,
    "ytick.major.pad": 9 * PX, "lines.linewidth": 2.6 * PX, "lines.markersize": 7.2 * PX, "legend.handlelength": 1.9,
    "legend.labelspacing": 0.75, "legend.borderaxespad": 0, "legend.borderpad": 0,
    "image.cmap": "pose", "image.interpolation": "none",
}
colormaps.register(LinearSegmentedColormap.from_list("pose", ["#dce7f0", POSE]))
logging.getLogger("matplotlib.font_manager").setLevel(logging.ERROR)  # a font that is not here is the reader's affair


def mix(color, share):
    """`color` with `share` in 0…1 of itself and the rest white."""
    return to_hex(1 - share * (1 - np.array(to_rgb(color))))


class Figures(dict):
    """The figures of a deck's module: {name: draw(tables, language) -> SVG text, or draw(…, "pdf") -> bytes}; `names` says
    how a word of its tables reads."""

    def __init__(self, names):
        super().__init__()
        self.names = names

    def figure(self, width, height, title, **look):
        """Adds draw(slide, tables, say), which draws on a Slide of that size, under its name."""
        def add(draw):
            @functools.wraps(draw)
            def drawn(tables, language, kind="svg"):
                with plt.rc_context({**LOOK, **look}):
                    say = Labels(language, self.names)
                    slide = Slide(width, height, say(title))
                    draw(slide, tables, say)
                    return slide.render(kind)
            self[draw.__name__] = drawn
            return drawn
        return add


class Slide:
    """Shapes and words on a page of pixels, y points down; what comes later lies on top."""

    def __init__(self, width, height, title):
        self.width, self.height, self.title, self.parts = width, height, title, 0
        self.figure = plt.figure(figsize=(width / 96, height / 96))
        self.page = self.figure.add_axes([0, 0, 1, 1], xlim=(0, width), ylim=(height, 0))
        self.page.set_axis_off()

    def add(self, artist):
        """On top of what is there."""
        self.parts += 1
        artist.set(zorder=self.parts, clip_on=False)
        return artist

    def patch(self, kind, *shape, fill=None, stroke=None, width=1.5, dash=None, **more):
        """A patch of matplotlib's; `dash` is in pixels."""
        lines = "-" if dash is None else (0, [float(length) / width for length in dash.split()])
        return self.add(self.page.add_artist(kind(
            *shape, facecolor=fill or "none", edgecolor=stroke or "none", linewidth=width * PX if stroke else 0,
            linestyle=lines, capstyle=more.pop("cap", "butt"), joinstyle="round", **more)))

    def rect(self, x, y, width, height, fill=None, stroke=None, radius=0, line=1, **more):
        if radius:
            shape = patches.BoxStyle.Round(pad=0, rounding_size=radius)
            return self.patch(patches.FancyBboxPatch, (x, y), width, height, boxstyle=shape, fill=fill, stroke=stroke,
                              width=line, **more)
        return self.patch(patches.Rectangle, (x, y), width, height, fill=fill, stroke=stroke, width=line, **more)

    def circle(self, x, y, radius, fill=None, stroke=None, width=1.5):
        return self.patch(patches.Circle, (x, y), radius, fill=fill, stroke=stroke, width=width)

    def line(self, x1, y1, x2, y2, stroke=MUTED, width=1.5, dash=None, arrow=False):
        return self.polyline([(x1, y1), (x2, y2)], stroke, width, dash, arrow)

    def polyline(self, points, stroke=MUTED, width=2.5, dash=None, arrow=False, curved=False):
        """Through the points; `curved` makes the inner ones, one or two, the control points of a Bézier curve."""
        codes = [Path.MOVETO] + [(Path.CURVE3, Path.CURVE4)[len(points) - 3]] * (len(points) - 1) if curved else None
        cap = "butt" if dash else "round"
        self.patch(patches.PathPatch, Path(points, codes), stroke=stroke, width=width, dash=dash, cap=cap)
        if arrow:  # its head is a triangle at the end
            (x0, y0), (x1, y1) = points[-2:]
            head = np.array([[1, 0], [-7, 4], [-7, -4]]) @ np.array([[x1 - x0, y1 - y0], [y0 - y1, x1 - x0]])
            head = head * 1.1 / np.hypot(x1 - x0, y1 - y0) + (x1, y1)
            self.patch(patches.Polygon, head, fill=stroke)

    def text(self, x, y, words, size=18, fill=INK, anchor="middle", weight="normal", mono=False, rotate=0, italic=False):
        place = {"middle": "center", "start": "left", "end": "right"}[anchor]
        return self.add(self.page.text(x, y, str(words), fontsize=size * PX, color=fill, ha=place, va="baseline",
                                       weight=weight, style="italic" if italic else "normal", rotation=-rotate,
                                       rotation_mode="anchor", **({"family": "monospace"} if mono else {})))

    def formula(self, x, y, tex, size):
        """A formula of matplotlib's as outlines about (x, y); a white rim keeps it legible on blocks."""
        outline = TextPath((0, 0), f"${tex}$", size=size)
        middle = outline.get_extents()
        outline = Affine2D().translate(-middle.x0 - middle.width / 2, 0).scale(1, -1).translate(x, y).transform_path(outline)
        self.patch(patches.PathPatch, outline, stroke=PAPER, width=5)
        self.patch(patches.PathPatch, outline, fill=INK)

    def cells(self, x, y, side, matrix, largest=None, decades=9):
        """A matrix as a field of squares, darker where log|value| is larger; zeros are white."""
        high = np.log10(largest or np.abs(matrix).max())
        self.add(style.magnitudes(self.page, matrix, high - decades, high, extent=(x, x + side, y + side, y), aspect="auto"))
        self.rect(x, y, side, side, stroke=MUTED, line=1)

    def axes(self, box, x=None, y=None, title="", below="", log="", xticks=None, yticks=None):
        """matplotlib's axes in a box (left, top, width, height) with these limits; `log` names the logarithmic ones."""
        left, top, width, height = box
        axes = self.figure.add_axes([left / self.width, 1 - (top + height) / self.height, width / self.width,
                                     height / self.height])
        axes.set_title(title, x=0)
        axes.set_xlabel(below)
        for axis, name, limits, ticks in ((axes.xaxis, "x", x, xticks), (axes.yaxis, "y", y, yticks)):
            if name in log:
                style.log_axis(axis)
            else:
                axis.set_major_formatter(lambda value, _: f"{value:g}".replace("-", "−"))
            if ticks is not None:
                axis.set_ticks(list(ticks))
            if limits is not None:
                axes.set(**{f"{name}lim": limits})
        return axes

    def legend(self, axes, x, y, columns=1, **look):
        """What the curves of the axes are, from (x, y) downwards, or with more columns to the right."""
        return self.figure.legend(*axes.get_legend_handles_labels(), loc="upper left", ncol=columns, **look,
                                  bbox_to_anchor=(x / self.width, 1 - y / self.height))

    def render(self, kind="svg"):
        """The SVG's text, or the bytes of a PDF."""
        style.tell_apart(self.figure)
        style.darken_words(self.figure)
        for words in self.figure.findobj(Text):
            words.set_text(in_chinese_marks(words.get_text()))
        text = io.StringIO() if kind == "svg" else io.BytesIO()
        self.figure.savefig(text, format=kind, metadata={**style.METADATA[f".{kind}"], "Title": self.title})
        plt.close(self.figure)
        if kind == "pdf":
            return text.getvalue()
        svg = re.sub(r' ?\n(?=[MLQCz"])', " ", text.getvalue()[text.getvalue().index("<svg"):])  # a path is a line
        return SUBSCRIPT.sub(r'\1<tspan dy=".25em" font-size="75%">\2</tspan><tspan dy="-.19em">&#8203;</tspan>', svg)


def in_chinese_marks(words):
    """A sentence with Chinese in it has Chinese commas and colons, but for those in brackets, as in [m, rad]."""
    if not re.search("[\u4e00-\u9fff]", words):
        return words
    return re.sub(r"([,:]) (?![^\[]*\])", lambda mark: {",": "，", ":": "："}[mark[1]], words)


def decades(values, step=1):
    """The powers of ten around the values."""
    low, high = np.floor(np.log10(min(values))), np.ceil(np.log10(max(values)))
    return 10.0 ** np.arange(low, high + 1, step)
