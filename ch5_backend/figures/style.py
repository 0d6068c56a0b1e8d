"""What all figures share: the look, and files that are the same to the byte when drawn again."""
import argparse
import functools
import sys
from contextlib import contextmanager
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap, to_hex, to_rgb
from matplotlib.lines import Line2D
from matplotlib.text import Text

from . import translate
from .atomic_write import atomic_write
from .digits import number, percent, power_of_ten  # noqa: F401
from .tables import TableError

# Okabe and Ito's colors: told apart by color-blind eyes, and by their lightness in gray.
PALETTE = ["#0072B2", "#D55E00", "#009E73", "#E69F00", "#56B4E9", "#CC79A7"]
BLUE, VERMILION, GREEN, ORANGE, SKY, PINK = "C0", "C1", "C2", "C3", "C4", "C5"  # of the palette, or of the decks' own
INK, GRAY, PALE = "#222222", "#8a8a8a", "#d9d9d9"

# Beside its color each curve has dashes, or marks, of its own: in gray it can still be followed.
DASHES = ("-", (0, (5, 1.6)), (0, (6, 1.5, 1, 1.5)), (0, (1, 1.1)), (0, (3, 1.2, 1, 1.2, 1, 1.2)), (0, (9, 2)))
SOLID = (0, None)  # of a line that stays so in any color, because it is alone
MARKS = ("o", "s", "^", "D", "v", "P", "X")
SHADES = ListedColormap(plt.get_cmap("viridis")(np.linspace(0.0, 0.88, 256)))  # of lines in order, none as pale as the paper

WIDE = (10.0, 5.0)  # inches: fills a slide below its title

plt.rcParams.update({
    "axes.prop_cycle": plt.cycler(color=PALETTE),
    "figure.dpi": 100,
    "savefig.dpi": 160,
    "font.family": "DejaVu Sans",
    "font.size": 12,
    "axes.titlesize": 13,
    "axes.titlelocation": "left",
    "axes.titlepad": 9,
    "axes.edgecolor": GRAY,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#ececec",
    "xtick.color": INK,
    "ytick.color": INK,
    "text.color": INK,
    "lines.linewidth": 2.0,
    "lines.markersize": 5,
    "legend.frameon": False,
    "image.cmap": "viridis_r",  # zeros are white: the larger, the darker
    "image.interpolation": "nearest",
    "svg.hashsalt": "ch5",  # element names in an SVG are drawn from this, not from chance
    "svg.fonttype": "none",  # words stay words: they can be searched, and set in a paper's own font
    "pdf.fonttype": 42,      # the letters as TrueType, which publishers ask for
})


METADATA = {".png": {"Software": None}, ".svg": {"Date": None, "Creator": None},
            ".pdf": {"CreationDate": None, "Creator": None, "Producer": None}}  # without dates and versions


def save(figure, directory, name):
    """DIR/figures/NAME.png for the page, NAME.svg and NAME.pdf for a paper: the same table gives the same bytes. If this
    machine has the letters, NAME.zh.png and NAME.zh.svg too."""
    folder = Path(directory) / "figures"
    folder.mkdir(parents=True, exist_ok=True)
    for suffix in (".png", ".svg", ".pdf"):
        save_as(figure, folder / f"{name}{suffix}")
        freeze(figure)  # the others keep the first one's layout, and save half the time
    if translate.to_chinese(figure):
        for suffix in (".zh.png", ".zh.svg"):  # in a PDF matplotlib would embed these letters under a wrong kind
            save_as(figure, folder / f"{name}{suffix}")
    plt.close(figure)


@contextmanager
def panels(directory, name, rows, columns, size=WIDE, legend=0, **shape):
    """So many rows and columns to draw on; then the figure NAME is saved, with a legend of so many columns above, of what the
    first panel has labeled."""
    figure, axes = plt.subplots(rows, columns, figsize=size, layout="constrained", **shape)
    yield axes
    if legend:
        legend_above(figure.axes[0], legend)
    save(figure, directory, name)


def drawn(name, *shape, **more):
    """Makes draw(directory, tables) of a function that fills panels: fill(panels, tables)."""
    def of(fill):
        @functools.wraps(fill)
        def draw(directory, tables):
            with panels(directory, name, *shape, **more) as axes:
                fill(axes, tables)
        return draw
    return of


CONTRAST = 5.1  # of words on paper: WCAG 2 asks for 4.5, on pale bands too


def contrast(color, paper="white"):
    """As WCAG 2 has it."""
    channels = np.array([to_rgb(color), to_rgb(paper)])
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    light = 0.05 + linear @ (0.2126, 0.7152, 0.0722)
    return light.max() / light.min()


def readable(color):
    """A darker one if it is too weak for words on paper; white ones stand on something dark."""
    color = np.array(to_rgb(color))
    while 1.0 < contrast(color) < CONTRAST:
        color = 0.97 * color
    return color


def tell_apart(figure):
    """Gives each solid line the dashes of its color, and each round mark its color's shape; in legends too. A line with
    marks stays solid, and one that has dashes of its own keeps them."""
    colors = [to_hex(color) for color in plt.rcParams["axes.prop_cycle"].by_key()["color"]]
    for line in figure.findobj(Line2D):
        color = to_hex(line.get_color())
        if color not in colors or getattr(line.axes, "name", "") == "3d":  # there, lines are the edges of things
            continue
        k = colors.index(color)
        if line.get_marker() == "o":
            line.set_marker(MARKS[k])
        elif line.get_linestyle() == "-" and line.get_marker() in ("None", ""):
            line.set_linestyle(DASHES[k])


def darken_words(figure):
    """Words in a color too weak to be read get a darker one."""
    for text in figure.findobj(Text):
        text.set_color(readable(text.get_color()))


def save_as(figure, path):
    """One file, of the kind that its ending tells."""
    tell_apart(figure)
    darken_words(figure)
    with atomic_write(path) as partial:
        figure.savefig(partial, metadata=METADATA[Path(path).suffix])


def discard(directory, name):
    """Removes what an earlier run has drawn, where this one has nothing to draw."""
    for suffix in (".png", ".svg", ".pdf", ".zh.png", ".zh.svg"):
        (Path(directory) / "figures" / f"{name}{suffix}").unlink(missing_ok=True)


def space(figure, **settings):
    """Sets `wspace` or `rect` of the constrained layout."""
    if hasattr(figure, "get_layout_engine"):
        figure.get_layout_engine().set(**settings)
    elif "rect" in settings:  # Matplotlib 3.5 has neither; an empty title keeps the space above
        figure.suptitle(" ", fontsize=24)
    else:
        figure.set_constrained_layout_pads(**settings)


def freeze(figure):
    """The layout stays as it is."""
    if hasattr(figure, "set_layout_engine"):
        figure.set_layout_engine("none")
    else:
        figure.set_constrained_layout(False)


def log_axis(axis):
    """A logarithmic axis with at most nine labeled powers of ten."""
    (axis.axes.set_xscale if axis.axis_name == "x" else axis.axes.set_yscale)("log")
    axis.set_major_locator(plt.matplotlib.ticker.LogLocator(numticks=9))
    axis.set_major_formatter(lambda value, _: power_of_ten(round(np.log10(value))))
    axis.set_minor_locator(plt.NullLocator())


def cost_axis(axes, costs):
    """A logarithmic axis for costs, unless they fall by little or all are 0; a single 0, where the data fit exactly, is
    not drawn there."""
    positive = costs[costs > 0]
    if not len(positive):
        axes.set_ylim(-1, 1)
        axes.set_yticks([0])
    elif costs.max() < 30 * costs.min():
        return
    elif positive.max() < 100 * positive.min():  # powers of ten alone would be too few
        plain_log(axes.yaxis)
    else:
        log_axis(axes.yaxis)


def plain_log(axis, ticks=None):
    """A logarithmic axis whose ticks read 5, 10, 20 …; by default those of 1, 2 and 5 times a power of ten."""
    log_axis(axis)
    axis.set_major_locator(plt.FixedLocator(ticks) if ticks else plt.matplotlib.ticker.LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter(lambda value, _: number(value, 1))


def cost_panel(axes, trace, summary, title):
    """How the cost of a solve fell, from where to where, and in what time."""
    cost, seconds = trace["cost"], float(summary["seconds"])
    time = f"{seconds:.2f} s" if seconds >= 0.1 else f"{1e3 * seconds:.1f} ms"
    axes.plot(trace["iteration"], cost, color=BLUE, marker="o", markersize=3.5)
    cost_axis(axes, cost)
    axes.xaxis.set_major_locator(plt.MaxNLocator(6, integer=True))
    axes.set(xlabel="iteration", title=title)
    axes.text(0.97, 0.95, f"{number(cost[0], 4)} → {number(cost[-1], 4)}\n{time}", ha="right", va="top",
              transform=axes.transAxes, fontsize=11.5)


def bare(axes, frame=False):
    """Without ticks and grid, as suits a matrix or a map."""
    axes.grid(False)
    axes.set(xticks=[], yticks=[])
    axes.spines[:].set_visible(frame)


def magnitudes(axes, matrix, low, high, **look):
    """log10 |entry| as shades; zeros stay white."""
    with np.errstate(divide="ignore"):
        shown = np.ma.masked_where(matrix == 0, np.log10(np.abs(matrix)))
    return axes.imshow(shown, vmin=low, vmax=high, **look)


def weight_axis(axes, weights):
    """A logarithmic axis of prior weights with a place for w = 0; returns where each weight is drawn."""
    positive = weights[weights > 0]
    zero_at = positive.min() / 30
    if axes.get_xscale() != "log":
        log_axis(axes.xaxis)
        axes.set_xlim(zero_at / 3, positive.max() * 3)
        first, last = np.floor(np.log10(positive.min())), np.log10(positive.max()) + 0.5
        exponents = np.arange(0, last, 3) if last > 6 else np.arange(first, last)
        axes.set_xticks([zero_at, *10.0**exponents], ["0", *map(power_of_ten, exponents)])
        axes.set_xlabel("prior weight w")
    return np.where(weights > 0, weights, zero_at)


def legend_above(axes, columns=3):
    """One legend for all panels, above them; none where nothing is labeled."""
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        figure, lines = axes.figure, -(-len(labels) // columns)
        space(figure, rect=(0, 0, 1, 1 - (0.21 + 0.24 * lines) / figure.get_figheight()))
        figure.legend(handles, labels, loc="upper left", bbox_to_anchor=(0.005, 1.0), ncol=columns, fontsize=12,
                      columnspacing=1.8, handlelength=2.2)


def legend_over(axes, title):
    """The title, and below it, still above the axes, what the lines are."""
    legend = axes.legend(title=title, title_fontsize=plt.rcParams["axes.titlesize"], fontsize=11, loc="lower left",
                         bbox_to_anchor=(0, 1), borderaxespad=0.3, borderpad=0, handlelength=2.2)
    legend._legend_box.align = "left"  # Matplotlib 3.5 has no word for it


def main(draw):
    """Command line of a plot script: DIR, out/ unless given."""
    parser = argparse.ArgumentParser(prog=Path(sys.argv[0]).name, description="Reads DIR/csv and writes DIR/figures.")
    parser.add_argument("directory", metavar="DIR", type=Path, nargs="?", default=Path("out"), help="default: out")
    try:
        draw(parser.parse_args().directory)
    except (TableError, OSError) as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
