"""The Hessian and its Schur complement as pictures of their entries; the eigenvalues under each gauge."""
import numpy as np

from . import style
from .style import BLUE, GREEN, GRAY, INK, ORANGE, VERMILION
from .tables import dense, read
from .words import Labels


def magnitudes(axes, matrix, lines, limits):
    """log10 |entry| with the frames' and the landmarks' borders."""
    image = style.magnitudes(axes, matrix, *limits)
    thin = 0.8 if len(matrix) < 100 else 0.3
    for at in lines:
        axes.axhline(at - 0.5, color="white", linewidth=thin)
        axes.axvline(at - 0.5, color="white", linewidth=thin)
    style.bare(axes, frame=True)
    return image


def bracket(axes, first, last, text):
    """Names the rows from first to last, left of the matrix."""
    transform = axes.get_yaxis_transform()
    gap = 0.008 * axes.get_ylim()[0]
    axes.plot([-0.025, -0.025], [first - 0.5 + gap, last - 0.5 - gap], transform=transform, color=INK, linewidth=1.2,
              clip_on=False)
    axes.text(-0.045, (first + last) / 2 - 0.5, text, transform=transform, rotation=90, ha="right", va="center",
              fontsize=12.6)


def pair(axes, entries, say, names=("$H$", "$H_{pp} - H_{pm} H_{mm}^{-1} H_{mp}$")):
    """H of a scene and its Schur complement, on two axes; `entries` is its part of the table. Returns the image of S."""
    matrices = [dense(entries.where(matrix=name)) for name in "HS"]
    size, poses = map(len, matrices)
    high = np.log10(max(np.abs(matrix).max() for matrix in matrices))
    for panel, matrix, name in zip(axes, matrices, names):
        image = magnitudes(panel, matrix, [at for at in range(6, poses + 1, 6) if at < len(matrix)], (high - 8, high))
        filled = f"{100 * np.count_nonzero(matrix) / matrix.size:.0f}"
        panel.set_title(say("{matrix}, {n} % filled", matrix=f"{name}: {len(matrix)} × {len(matrix)}", n=filled))
    bracket(axes[0], 0, poses, say("poses"))
    bracket(axes[0], poses, size, say("landmarks"))
    return image


def draw_pair(directory, scene, entries):
    with style.panels(directory, f"hessian_{scene}", 1, 2) as panels:
        image = pair(panels, entries, Labels("en"))
        panels[0].figure.colorbar(image, ax=list(panels), label="log₁₀ |entry|", shrink=0.85, pad=0.02)
        style.space(panels[0].figure, wspace=0.04)


def eigenvalues(axes, table, gauges, say):
    """One row a gauge, {gauge: label}, one tick an eigenvalue."""
    for y, (gauge, color) in enumerate(zip(gauges, (VERMILION, BLUE, GREEN, ORANGE))):
        values = table.where(gauge=gauge)["eigenvalue"]
        zeros = (np.abs(values) <= 1e-10 * values.max()).sum()
        axes.vlines(np.maximum(np.abs(values), 1e-10), y - 0.3, y + 0.3, color=color, linewidth=2)
        axes.text(3e-1, y, say("{n} of {m} are zero", n=zeros, m=len(values)), ha="right", va="center", fontsize=12.6, color=color)
    axes.axvspan(1e-10, 1e-6, color="#f3f3f3", zorder=0)
    axes.text(1.5e-10, -0.62, say("rounding of zero"), color=GRAY, fontsize=12, va="center")
    style.log_axis(axes.xaxis)
    axes.set_xlim(1e-10, 3e9)
    axes.set_ylim(len(gauges) - 0.5, -0.85)
    axes.set_yticks(range(len(gauges)))
    axes.set_yticklabels(gauges.values())
    axes.tick_params(axis="y", length=0)
    axes.grid(False, axis="y")
    axes.set_xlabel(say("|eigenvalue| of H at the optimum"))


def draw(directory):
    table, spectrum = read(directory, "hessian"), read(directory, "spectrum")
    for scene in dict.fromkeys(table["scene"]):
        draw_pair(directory, scene, table.where(scene=scene))
    with style.panels(directory, "spectrum", 1, 1, (10.0, 4.2)) as axes:
        eigenvalues(axes, spectrum, {gauge: gauge for gauge in spectrum["gauge"]}, Labels("en"))
