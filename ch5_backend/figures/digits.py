"""How pages and figures write numbers; a missing one is a dash."""
import math
import re

MISSING = "–"


def power_of_ten(exponent):
    """10⁻³ as plain letters, which are set ten times faster than a formula."""
    return "10" + str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def minus(words):
    """The same words with a real minus before each negative number."""
    return re.sub(r"(?<![\w.])-(?=\.?\d)", "−", words)


def fixed(value, digits=0):
    return MISSING if math.isnan(value) else minus(f"{value:.{digits}f}")


def number(value, digits=3):
    """A number for reading: 0.0132, 4620, 2.17 × 10⁹."""
    if math.isnan(value):
        return MISSING
    if value == 0:
        return "0"
    if 1e-3 <= abs(value) < 1e5:
        return minus(f"{value:.{digits}g}" if abs(value) < 10**digits else f"{value:.0f}")
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    power = power_of_ten(int(exponent))
    return power if float(mantissa) == 1 else f"{minus(mantissa)} × {power}"


def percent(share, digits=0, sign=""):
    """0.12 as 12 %, which no line breaks."""
    return minus(f"{100 * share:{sign}.{digits}f}\u00a0%")
