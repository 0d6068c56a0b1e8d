"""Curves for the page itself: inline SVG in the page's colors, of which a slider shows one position at a time."""

import numpy as np
from markupsafe import Markup

from .style import number

WIDTH, HEIGHT = 320, 220
LEFT, TOP, BOTTOM = 52, 24, 38  # room for the ticks and the titles


class Axes:
    """A pair of axes; what is drawn goes to `parts`."""

    def __init__(self, title, x_limits, y_limits, x_label="", x_log=False, y_log=False):
        self.limits, self.logs = (x_limits, y_limits), (x_log, y_log)
        self.parts = []
        bottom, right = HEIGHT - BOTTOM, WIDTH - 6
        self.parts.append(Markup('<path class="axis" d="M{} {}V{}H{}"/><text x="0" y="13">{}</text>'
                                 '<text x="{}" y="{}" text-anchor="end">{}</text>').format(
                                     LEFT, TOP, bottom, right, title, right, HEIGHT - 3, x_label))
        for tick, label in ticks(*x_limits, x_log):
            x, _ = self.at(tick, y_limits[0])
            self.parts.append(f'<text x="{x:.0f}" y="{bottom + 17}" text-anchor="middle">{label}</text>')
        for tick, label in ticks(*y_limits, y_log):
            _, y = self.at(x_limits[0], tick)
            self.parts.append(f'<path class="axis" d="M{LEFT} {y:.1f}h-4"/><text x="{LEFT - 6}" y="{y + 4:.0f}" '
                              f'text-anchor="end">{label}</text>')

    def at(self, x, y):
        """The place of a value on the drawing."""
        shares = []
        for value, (low, high), log in zip((x, y), self.limits, self.logs):
            low, high, value = (np.log10(np.maximum(v, 1e-300)) if log else v for v in (low, high, value))
            shares.append((value - low) / (high - low))
        return LEFT + shares[0] * (WIDTH - 6 - LEFT), HEIGHT - BOTTOM - shares[1] * (HEIGHT - BOTTOM - TOP)

    def curve(self, xs, ys, kind, at=None):
        x, y = self.at(np.asarray(xs, dtype=float), np.asarray(ys, dtype=float))
        points = [f"{a:.1f} {b:.1f}" for a, b in zip(x, y) if np.isfinite(a) and np.isfinite(b)]
        if points:
            self.path("M" + "L".join(points), f"curve {kind}", at)

    def dots(self, xs, ys, kind, at=None):
        x, y = self.at(np.asarray(xs, dtype=float), np.asarray(ys, dtype=float))
        self.path("".join(f"M{a:.1f} {b:.1f}h0" for a, b in zip(x, y)), f"dot {kind}", at)

    def path(self, d, kind, at=None):
        mark = "" if at is None else f' data-at="{at}"'
        self.parts.append(f'<path class="{kind}{"" if at is None else " at"}"{mark} d="{d}"/>')

    def svg(self, shows, kind=""):
        """The drawing; `shows` says what there is to see, for screen readers."""
        return Markup('<svg class="plot {}" viewBox="0 0 {} {}" role="img" aria-label="{}">{}</svg>').format(
            kind, WIDTH, HEIGHT, shows, Markup("\n".join(self.parts)))


def ticks(low, high, log):
    """At most six round numbers from low to high, and how each is written: with as many decimals as tell it from the next."""
    if log:
        first, last = np.ceil(np.log10(low) - 1e-9), np.floor(np.log10(high) + 1e-9)
        return [(tick, number(tick)) for tick in 10.0 ** np.arange(first, last + 1, max(1, np.ceil((last - first) / 5)))]
    step = 10.0 ** np.floor(np.log10(high - low))
    step = next(step * part for part in (0.1, 0.2, 0.5, 1, 2) if (high - low) / (step * part) <= 6)
    decimals = max(0, int(np.ceil(-np.log10(step) - 1e-9)))
    values = np.arange(np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9) + 1) * step + 0.0  # no −0
    return [(tick, f"{tick:.{decimals}f}".replace("-", "−")) for tick in values]


def powers(values):
    """The powers of ten around the positive ones of the values."""
    exponents = np.log10([value for value in values if value > 0])
    return 10.0 ** np.floor(exponents.min()), 10.0 ** np.ceil(exponents.max())
