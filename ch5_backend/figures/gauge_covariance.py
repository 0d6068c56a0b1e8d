"""The gauge in the eigenvalues of H, and in the covariances: Figs. 8, 9 and 10 of the gauge paper."""
import numpy as np

from . import style
from .gauge import ERRORS
from .numbers.gauge import ZERO, relative_spectrum
from .hessian import magnitudes
from .style import BLUE, GREEN, GRAY, VERMILION
from .tables import dense

KEYFRAME = 9  # rows: p, δθ, v


def spectrum_dots(axes, values):
    """A dot an eigenvalue, those that are zero in another color; returns their numbers and how many are zero."""
    zeros, number = int((values < ZERO).sum()), 1 + np.arange(len(values))
    axes.plot(number[:zeros], values[:zeros], "o", color=VERMILION, markersize=7)
    axes.plot(number[zeros:], values[zeros:], ".", color=BLUE, markersize=5)
    style.plain_log(axes.xaxis, [1, 2, 4, 7, 10, 20, 50, 100, 200])
    style.log_axis(axes.yaxis)
    return number, zeros


@style.drawn("gauge_spectrum", 1, 2, (10.0, 4.6), sharey=True)
def spectrum(panels, table):
    for axes, problem in zip(panels, ("camera and IMU", "camera alone")):
        values = relative_spectrum(table, problem)
        number, zeros = spectrum_dots(axes, values)
        axes.axhline(ZERO, color=GRAY, linewidth=1.0, linestyle=(0, (4, 3)))
        axes.text(number[zeros], values[:zeros].max(), f"  {zeros} zeros", color=VERMILION, va="center", fontsize=13)
        axes.text(number[-1], ZERO * 1.6, "10⁻⁸", color=GRAY, ha="right", fontsize=11)
        axes.set_title(f"{problem}: {len(values)} eigenvalues")
        axes.set_xlabel("number of the eigenvalue, ascending")
    panels[0].set_ylabel("|λ| / largest λ")


def matrix_of(table, gauge):
    """The symmetric matrix whose lower half the table holds."""
    rows = table.where(gauge=gauge)
    size = int(rows["row"].max()) + 1
    lower = dense(rows, size, size)
    return lower + np.tril(lower, -1).T


@style.drawn("gauge_matrices", 1, 4, (12.0, 3.3))
def matrices(panels, table):
    fixed, free, moved = (matrix_of(table, gauge) for gauge in ("fixed", "free", "free to fixed"))
    top = np.log10(max(np.abs(fixed).max(), np.abs(free).max()))
    shown = (("Σ fixed", fixed), ("Σ free", free), ("Σ free, transformed", moved), ("their difference", moved - fixed))
    for axes, (title, matrix) in zip(panels, shown):
        image = magnitudes(axes, matrix, range(KEYFRAME, len(matrix), KEYFRAME), (top - 12, top))
        axes.set_title(title)
    panels[0].set_ylabel("keyframes 0 to 9: p, δθ, v", fontsize=11)
    fig = panels[0].figure
    fig.colorbar(image, ax=list(panels), label="log₁₀ |entry|", shrink=0.8, pad=0.02)
    style.space(fig, wspace=0.04)


GAUGES = {"fixed": "fixed", "free": "free", "free to fixed": "free, transformed to fixed",
          "fixed to free": "fixed, transformed to free"}
LOOKS = {"fixed": dict(color=BLUE, marker="o"), "free": dict(color=GREEN, marker="^"),
         "free to fixed": dict(color=BLUE, marker="o", markersize=11, markerfacecolor="none", linestyle="none"),
         "fixed to free": dict(color=GREEN, marker="^", markersize=12, markerfacecolor="none", linestyle="none")}


def deviation_lines(axes, table, column, names, scale=1.0):
    """σ against the keyframe in each gauge; open marks have been transformed."""
    for gauge, look in LOOKS.items():
        rows = table.where(gauge=gauge)
        axes.plot(rows["keyframe"], scale * rows[column], label=names[gauge], **look)


@style.drawn("gauge_deviations", 1, 3, (10.5, 4.4), legend=4)
def deviations(panels, table):
    for axes, (column, title) in zip(panels, ERRORS.items()):
        deviation_lines(axes, table, column, GAUGES)
        axes.set_xticks(range(0, int(table["keyframe"].max()) + 1, 3))
        axes.set(title=f"σ of {title}", xlabel="keyframe")
