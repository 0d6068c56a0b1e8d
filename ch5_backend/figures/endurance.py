"""Thousands of images through each estimator: memory of the process, error against the way, time an image."""
from . import style
from .odometry import COLORS, NAMES, policies
from .tables import read


def draw(directory):
    table = read(directory, "endurance")
    with style.panels(directory, "endurance", 1, 3) as panels:
        for name, width in zip(policies(table), (3.0, 1.3)):  # of memory, the second line may lie on the first
            rows = table.where(policy=name)
            for axes, (x, y) in zip(panels, (("frame", "resident_mb"), ("distance_m", "error_m"),
                                             ("frame", "milliseconds"))):
                axes.plot(rows[x], rows[y], color=COLORS[name], label=NAMES[name],
                          linewidth=width if axes is panels[0] else 1.3)
        for axes, (x, title) in zip(panels, (("images", "resident memory [MB]"), ("distance traveled [m]", "distance from the truth [m],\naligned over the first minute"),
                                             ("images", "time per image [ms]"))):
            axes.set(xlabel=x, title=title)
            axes.set_ylim(bottom=0)
        panels[0].legend(loc="lower right")


if __name__ == "__main__":
    style.main(draw)
