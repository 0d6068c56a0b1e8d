"""Axes and curves for the decks' plots."""

from math import ceil, floor, log10

from .svg import FAINT, MUTED


class Axes:
    """A frame with linear or logarithmic axes. On a logarithmic x axis the value 0 stands at the far left."""

    def __init__(self, svg, box, x_range, y_range, log_x=False, log_y=False, zero=False):
        self.svg, self.log_x, self.log_y = svg, log_x, log_y
        self.left, self.top, self.width, self.height = box
        self.x0, self.x1 = (log10(v) for v in x_range) if log_x else x_range
        self.y0, self.y1 = (log10(v) for v in y_range) if log_y else y_range
        self.gap = 70 if zero else 0  # room for w = 0

    def x(self, value):
        if self.log_x and value <= 0:
            return self.left + self.gap / 3
        value = log10(value) if self.log_x else value
        return self.left + self.gap + (self.width - self.gap) * (value - self.x0) / (self.x1 - self.x0)

    def y(self, value):
        value = log10(max(value, 1e-300)) if self.log_y else value
        share = min(1.0, max(0.0, (value - self.y0) / (self.y1 - self.y0)))
        return self.top + self.height * (1 - share)

    def draw(self, x_label, y_label, x_ticks, y_ticks):
        for tick in y_ticks:
            y = self.y(tick)
            self.svg.line(self.left, y, self.left + self.width, y, FAINT, 1)
            self.svg.text(self.left - 9, y + 5, power(tick) if self.log_y else f"{tick:g}", 15, MUTED, anchor="end")
        for tick in x_ticks:
            x = self.x(tick)
            self.svg.line(x, self.top + self.height, x, self.top + self.height + 5, MUTED, 1)
            name = power(tick) if self.log_x and tick > 0 else f"{tick:g}"
            self.svg.text(x, self.top + self.height + 23, name, 15, MUTED)
        self.svg.line(self.left, self.top + self.height, self.left + self.width, self.top + self.height, MUTED, 1.2)
        self.svg.text(self.left + self.width / 2, self.top + self.height + 50, x_label, 17)
        self.svg.text(self.left, self.top - 14, y_label, 17, anchor="start")

    def curve(self, xs, ys, colour, dash=None, dots=True, width=2.6):
        points = [(self.x(x), self.y(y)) for x, y in zip(xs, ys)]
        start = 1 if self.log_x and xs[0] <= 0 else 0
        self.svg.polyline(points[start:], colour, width, dash)
        for x, y in points if dots else points[:start]:
            self.svg.circle(x, y, 3.6, colour)


def power(value):
    """10ⁿ with a raised exponent."""
    exponent = round(log10(value))
    return "10" + "".join("⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".index(c)] for c in str(exponent))


def decades(values, step=1):
    low, high = floor(log10(min(values))), ceil(log10(max(values)))
    return [10.0 ** n for n in range(low, high + 1, step)]


def legend(svg, x, y, entries, gap=28):
    for i, (name, colour, dash) in enumerate(entries):
        svg.line(x, y + gap * i, x + 30, y + gap * i, colour, 3, dash)
        svg.text(x + 40, y + 6 + gap * i, name, 16, anchor="start")
