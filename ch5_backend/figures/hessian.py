"""The Hessian and its Schur complement as pictures of their entries; the eigenvalues under each gauge."""
import numpy as np

from . import style
from .style import BLUE, GREEN, GRAY, INK, ORANGE, VERMILION, plt
from .tables import dense, read


def percent(fraction):
    return f"{100 * fraction:.0f} %"


def magnitudes(axes, matrix, lines, limits):
    """log10 |entry|, zeros left white, with the frames' and the landmarks' borders."""
    with np.errstate(divide="ignore"):
        shown = np.ma.masked_where(matrix == 0, np.log10(np.abs(matrix)))
    image = axes.imshow(shown, vmin=limits[0], vmax=limits[1], interpolation="nearest")
    thin = 0.8 if len(matrix) < 100 else 0.3
    for at in lines:
        axes.axhline(at - 0.5, color="white", linewidth=thin)
        axes.axvline(at - 0.5, color="white", linewidth=thin)
    axes.grid(False)
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_visible(True)
    return image


def bracket(axes, first, last, text):
    """Names the rows from first to last, left of the matrix."""
    transform = axes.get_yaxis_transform()
    gap = 0.008 * axes.get_ylim()[0]
    axes.plot([-0.025, -0.025], [first - 0.5 + gap, last - 0.5 - gap], transform=transform, color=INK, linewidth=1.2,
              clip_on=False)
    axes.text(-0.045, (first + last) / 2 - 0.5, text, transform=transform, rotation=90, ha="right", va="center",
              fontsize=11)


def pair(directory, scene, table, summary):
    row = summary.row(scene=scene)
    poses, size = 6 * int(row["frames"]), 6 * int(row["frames"]) + int(row["points"])
    H = dense(table.where(scene=scene, matrix="H"), size, size)
    S = dense(table.where(scene=scene, matrix="S"), poses, poses)
    high = np.log10(max(np.abs(H).max(), np.abs(S).max()))
    limits = high - 8, high
    fig, (left, right) = plt.subplots(1, 2, figsize=style.WIDE, layout="constrained")
    borders = range(6, poses + 1, 6)
    magnitudes(left, H, borders, limits)
    image = magnitudes(right, S, [b for b in borders if b < poses], limits)
    bracket(left, 0, poses, "poses")
    bracket(left, poses, size, "landmarks")
    filled = lambda M: f"{percent(np.count_nonzero(M) / M.size)} filled"
    left.set_title(f"$H$: {size} × {size}, {filled(H)}")
    right.set_title(f"$H_{{pp}} - H_{{pm}} H_{{mm}}^{{-1}} H_{{mp}}$: {poses} × {poses}, {filled(S)}")
    fig.colorbar(image, ax=[left, right], label="log₁₀ |entry|", shrink=0.85, pad=0.02)
    style.space(fig, wspace=0.04)
    style.save(fig, directory, f"hessian_{scene}")


def spectrum(directory):
    """One row a gauge, one tick an eigenvalue."""
    table = read(directory, "spectrum")
    gauges = list(dict.fromkeys(table["gauge"]))
    fig, axes = plt.subplots(figsize=(10.0, 4.2), layout="constrained")
    for y, (gauge, color) in enumerate(zip(gauges, (VERMILION, BLUE, GREEN, ORANGE))):
        values = table.where(gauge=gauge)["eigenvalue"]
        zero = np.abs(values) <= 1e-10 * values.max()
        axes.vlines(np.maximum(np.abs(values), 1e-10), y - 0.3, y + 0.3, color=color, linewidth=2)
        count = f"{zero.sum()} of {len(values)} are zero" if zero.any() else f"none of {len(values)} is zero"
        axes.text(3e-1, y, count, ha="right", va="center", fontsize=11, color=color)
    axes.axvspan(1e-10, 1e-6, color="#f3f3f3", zorder=0)
    axes.text(1.5e-10, -0.62, "rounding of zero", color=GRAY, fontsize=10, va="center")
    style.log_axis(axes.xaxis)
    axes.set_xlim(1e-10, 3e9)
    axes.set_ylim(len(gauges) - 0.5, -0.85)
    axes.set_yticks(range(len(gauges)))
    axes.set_yticklabels(gauges)
    axes.tick_params(axis="y", length=0)
    axes.grid(False, axis="y")
    axes.set_xlabel("|eigenvalue| of $H$ at the optimum")
    style.save(fig, directory, "spectrum")


def draw(directory):
    table, summary = read(directory, "hessian"), read(directory, "mono_ba_summary")
    for scene in summary["scene"]:
        pair(directory, scene, table, summary)
    spectrum(directory)


if __name__ == "__main__":
    style.main(draw)
