"""The deck's picture that needs no table."""

from ..chart import Axes, legend
from ..svg import CROSS, INK, LANDMARK, MUTED, POSE, PRIOR, Svg, mix

from . import toy

WORDS = {
    "en": {"valley": "b − a = 1: the valley", "start": "start", "fix": "fixation", "free": "free", "weak": "weak prior",
           "weight": "weight w", "steps": "iterations of this walk"},
    "zh": {"valley": "b − a = 1：山谷", "start": "初值", "fix": "固定", "free": "自由", "weak": "弱先验",
           "weight": "权重 w", "steps": "这个例子的迭代次数"},
}


def three_ways(lang):
    """Damped steps on two numbers with one measured difference, and how many there are for each weight of a prior."""
    words = WORDS[lang]
    svg = Svg(1060, 380, "Three ways into a valley")
    axes = Axes(svg, (60, 38, 420, 272), (-1.05, 0.55), (-0.1, 1.3))
    axes.draw("a", "b", (-1, -0.5, 0, 0.5), (0, 0.5, 1))
    for shift in (-0.45, -0.2, 0.2, 0.45):  # level lines b = a + 1 + shift, within the frame
        ends = [(a, a + 1 + shift) for a in (max(-1.05, -1.1 - shift), min(0.55, 0.3 - shift))]
        svg.polyline([(axes.x(a), axes.y(b)) for a, b in ends], mix(POSE, 0.3), 1.3)
    svg.line(axes.x(-1.05), axes.y(-0.05), axes.x(0.3), axes.y(1.3), LANDMARK, 5)
    svg.text(axes.x(-1.0), axes.y(1.18), words["valley"], 17, LANDMARK, anchor="start")
    for weight, colour in ((toy.WEAK, PRIOR), (0.0, CROSS), (None, POSE)):
        points = [(axes.x(a), axes.y(b)) for a, b in toy.walk(weight)]
        svg.polyline(points, colour, 2.6)
        for x, y in points[1:]:
            svg.circle(x, y, 4.6, colour)
    svg.circle(axes.x(0), axes.y(0), 7, INK)
    svg.text(axes.x(0) + 14, axes.y(0) - 6, words["start"], 17, anchor="start")
    legend(svg, axes.x(0.16), axes.y(0.62), [(words["fix"], POSE, None), (words["free"], CROSS, None),
                                             (words["weak"], PRIOR, None)])
    weights = [0.0] + [10.0 ** (k / 4) for k in range(-20, 13)]
    counts = [len(toy.walk(weight)) - 1 for weight in weights]
    top = 10 * (max(counts) // 10 + 1)
    right = Axes(svg, (600, 45, 430, 265), (1e-5, 1e3), (0, top), log_x=True, zero=True)
    right.draw(words["weight"], words["steps"], [0, 1e-4, 1e-2, 1, 1e2], range(0, top + 1, 10))
    right.curve(weights, counts, PRIOR, dots=False)
    return svg.render()


ALL = {"three_ways": three_ways}
