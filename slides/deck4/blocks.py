"""The deck's picture that needs no table."""

import numpy as np

from ch5_backend.figures.gauge import weight_line
from ch5_backend.figures.slide import CROSS, INK, LANDMARK, POSE, PRIOR, Figures, mix

from . import toy

FIGURES = Figures("gauge.")


@FIGURES.figure(1060, 380, "Three ways into a valley")
def three_ways(slide, tables, say):
    """Damped steps on two numbers with one measured difference, and how many there are for each weight of a prior."""
    axes = slide.axes((60, 38, 420, 272), (-1.05, 0.55), (-0.1, 1.3), "b", "a", "", (-1, -0.5, 0, 0.5), (0, 0.5, 1))
    for shift in (-0.45, -0.2, 0.2, 0.45):  # level lines b = a + 1 + shift
        axes.axline((0, 1 + shift), slope=1, color=mix(POSE, 0.3), linewidth=1)
    axes.axline((0, 1), slope=1, color=LANDMARK, linewidth=3.75)
    axes.text(-1.0, 1.18, say("valley"), color=LANDMARK, fontsize=12.75)
    for weight, name, color in ((None, "fix", POSE), (0.0, "free", CROSS), (toy.WEAK, "weak", PRIOR)):
        axes.plot(*zip(*toy.walk(weight)), "o-", color=color, label=say(name), clip_on=False)
    axes.plot(0, 0, "o", color=INK, markersize=10.5, zorder=3)
    axes.annotate(say("start"), (0, 0), (10, 5), textcoords="offset points", fontsize=12.75)
    slide.legend(axes, 378, 160)
    weights = np.array([0.0] + [10.0 ** (k / 4) for k in range(-20, 13)])
    counts = np.array([len(toy.walk(weight)) - 1 for weight in weights])
    top = 10 * (counts.max() // 10 + 1)
    axes = slide.axes((600, 45, 430, 265), y=(0, top), title=say("steps"), yticks=range(0, top + 1, 10))
    weight_line(axes, weights, counts, PRIOR, None)
    axes.set_xlabel(say("weight"))
