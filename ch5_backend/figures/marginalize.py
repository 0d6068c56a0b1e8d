"""Marginalization as pictures: the slides' chain of three scalars with its numbers, and fill-in on a scene."""
import numpy as np

from . import style
from .hessian import bracket, magnitudes
from .style import GRAY, INK, plt
from .tables import dense, read


def numbers(axes, matrix, names, limit):
    """A heat map with every entry written out."""
    image = axes.imshow(matrix, cmap="RdBu_r", vmin=-limit, vmax=limit)
    for (i, j), value in np.ndenumerate(matrix):
        ground = image.cmap(image.norm(value))
        axes.text(j, i, f"{value:.6g}".replace("-", "−"), ha="center", va="center", fontsize=10.5,
                  color=max("white", INK, key=lambda ink: style.contrast(ink, ground)))
    axes.set_xticks(range(len(names)))
    axes.set_yticks(range(len(names)))
    axes.set_xticklabels(names, fontsize=14)
    axes.set_yticklabels(names, fontsize=14)
    axes.tick_params(length=0, top=False)
    axes.grid(False)
    axes.spines[:].set_visible(False)


def arrow(fig, start, end):
    fig.add_artist(plt.matplotlib.patches.FancyArrowPatch(start, end, transform=fig.transFigure, color=GRAY,
                                                          arrowstyle="-|>", mutation_scale=18, linewidth=1.6))


def chain(directory):
    table = read(directory, "marginalize_chain")
    matrices = {stage: dense(table.where(stage=stage), size, size)
                for stage, size in (("before", 3), ("moved", 3), ("after", 2))}
    limit = max(np.abs(M).max() for M in matrices.values())
    fig = plt.figure(figsize=(10.0, 3.5))
    width, bottom, tall = 0.245, 0.10, 0.245 * 10.0 / 3.5
    names = {"before": ("$x_0$", "$x_1$", "$x_2$"), "moved": ("$x_0$", "$x_2$", "$x_1$"), "after": ("$x_0$", "$x_2$")}
    titles = {"before": "$H$", "moved": "$H$, with $x_1$ moved to the end", "after": "the prior on $x_0$ and $x_2$"}
    for stage, left in (("before", 0.05), ("moved", 0.40), ("after", 0.79)):
        scale = 1.0 if stage != "after" else 2 / 3
        axes = fig.add_axes([left, bottom + (1 - scale) / 2 * tall, width * scale, tall * scale])
        numbers(axes, matrices[stage], names[stage], limit)
        axes.set_title(titles[stage], pad=10, loc="center")
        if stage == "moved":
            for line in (axes.axhline, axes.axvline):
                line(1.5, color=INK, linewidth=1.2, linestyle=(0, (4, 3)))
    middle = bottom + tall / 2
    for start, end, text in ((0.305, 0.36, "move"), (0.66, 0.75, "Schur\ncomplement")):
        fig.text((start + end) / 2, middle + 0.045, text, ha="center", va="bottom", fontsize=11, linespacing=1.3)
        arrow(fig, (start, middle), (end, middle))
    style.save(fig, directory, "marginalize_chain")


FRAMES, POINTS = 5, 12  # of the scene, as in studies/marginalize_study.cc


def scene(directory):
    table, fill = read(directory, "marginalize_scene"), read(directory, "marginalize_fill")
    high = np.log10(np.abs(table["value"]).max())
    fig = plt.figure(figsize=(10.0, 5.6))
    places = {"before": ([0.055, 0.22, 0.28, 0.50], "before", FRAMES, POINTS),
              "without landmarks": ([0.47, 0.545, 0.196, 0.35], "landmarks gone", FRAMES, 0),
              "without landmarks and frame 0": ([0.775, 0.545, 0.196, 0.35], "then frame 0 gone", FRAMES - 1, 0),
              "without frame 0": ([0.47, 0.04, 0.196, 0.35], "frame 0 gone", FRAMES - 1, POINTS)}
    for stage, (place, title, frames, points) in places.items():
        row = fill.row(stage=stage)
        size = int(row["size"])
        axes = fig.add_axes(place)
        M = dense(table.where(stage=stage), size, size)
        image = magnitudes(axes, M, [6 * i for i in range(1, frames + (points > 0))], (high - 8, high))
        filled = f"{100 * row['density']:.0f} %"
        axes.set_title(f"{title}\n{size} × {size}, {filled} filled", fontsize=11.5, loc="center", pad=6)
        if points:
            bracket(axes, 0, 6 * frames, "poses")
            bracket(axes, 6 * frames, size, "landmarks")
    note = ("Frame 0 hosts every landmark.\nOnce it is gone, all landmarks\nare tied to each other, and the\n"
            "cheap diagonal corner is lost.")
    fig.text(0.715, 0.385, note, fontsize=11, va="top", linespacing=1.45)
    bar = fig.add_axes([0.715, 0.13, 0.256, 0.025])
    fig.colorbar(image, cax=bar, orientation="horizontal", label="log₁₀ |entry|")
    for start, end in (((0.35, 0.58), (0.445, 0.70)), ((0.35, 0.38), (0.425, 0.25)), ((0.685, 0.73), (0.755, 0.73))):
        arrow(fig, start, end)
    style.save(fig, directory, "marginalize_scene")


def draw(directory):
    chain(directory)
    scene(directory)
