"""Numbers and matrices in TeX, and how a fraction is typed."""

from math import floor, log10


def scientific(value, digits=3, shortest=True):
    """6.7 × 10⁻⁵ in TeX; plain digits where they are short."""
    if value == 0:
        return "0"
    exponent = floor(log10(abs(value)))
    if shortest and -3 <= exponent <= 3:
        return f"{value:.{max(0, digits - 1 - exponent)}f}"
    mantissa = f"{value / 10 ** exponent:.{digits - 1}f}"
    return f"10^{{{exponent}}}" if float(mantissa) == 1 else rf"{mantissa}\times 10^{{{exponent}}}"


def power(weight):
    """A weight of a sweep, 10⁵."""
    return f"${scientific(weight, 1, shortest=weight < 1e3)}$"


def short(value):
    return f"{value:.0f}" if value >= 20 else f"{value:.1f}" if value >= 1 else f"{value:.2f}"


def decimal(value):
    return f"{float(value):.6g}".replace("-", "−")


def tex(value):
    """A fraction in TeX."""
    if value.denominator == 1:
        return str(value)
    sign = "-" if value < 0 else ""
    return rf"{sign}\tfrac{{{abs(value.numerator)}}}{{{value.denominator}}}"


def bracketed(value):
    return rf"\left({tex(value)}\right)"


def matrix(rows, cell):
    return r"\begin{bmatrix}" + r" \\ ".join(" & ".join(cell(v) for v in row) for row in rows) + r"\end{bmatrix}"
