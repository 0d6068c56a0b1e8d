#!/usr/bin/python3
"""Draws the moving picture of the READMEs, slides/figures/flight.*.svg: a recording's estimates drawn over the truth as they came.

usage: flight.py DIR [--out FOLDER]

  DIR             out/euroc_v1_01_easy, which ./course run DATA/euroc_v1_01_easy has made
  --out FOLDER    default slides/figures

Two tables: odometry_path.csv (estimates laid upon the truth by a shift and a turn about gravity, and their distance from it) and
odometry_policies.csv (its root mean square).
"""
import argparse
import sys
from pathlib import Path

import numpy as np

from .atomic_write import write_whole
from .tables import TableError, read

ROOT = Path(__file__).resolve().parents[2]
POLICIES = {"vins": "VINS-Mono", "okvis": "OKVIS"}
WORDS = {  # what the picture says; the report's and the decks' words are in words/
    "en": {"alt": "EuRoC's V1_01 through two windows, from above: {vins} m and {okvis} m from the truth", "title": "{name}'s window",
           "error": "{error} m from the truth (RMS)", "truth": "truth", "estimate": "estimate", "distance": "distance from the truth",
           "scale": "1 m", "source": "EuRoC V1_01, {seconds} s from above, {times} times as fast as flown"},
    "zh": {"alt": "EuRoC 的 V1_01 经过两种窗口，俯视：离真值 {vins} m 和 {okvis} m", "title": "{name} 的窗口",
           "error": "离真值 {error} m（均方根）", "truth": "真值", "estimate": "估计", "distance": "到真值的距离",
           "scale": "1 m", "source": "EuRoC V1_01，{seconds} 秒，俯视，以 {times} 倍速度播放"}}
PANEL, MAP, STRIP, MARGIN = 430, 250, 60, 26  # a panel's width, the heights of the view from above and of the errors below it
TOP = 66
FOOT = TOP + MAP + 34 + STRIP
HEIGHT = FOOT + 50
TIMES, HOLD = 3, 3.0   # how much faster than flown it plays; how long it stands still, whole, before it begins [s]
STOPS = 60             # of the animation, between which a pen moves evenly

STYLE = """\
.paper { fill: #ffffff; }  /* a page may be dark where the reader's system is light */
text { font: 17px system-ui, 'Noto Sans', 'Noto Sans CJK SC', sans-serif; fill: #22303c; }
.title { font-weight: 600; font-size: 21px; } .small { fill: #55636f; }
.truth, .path { fill: none; stroke-linecap: round; stroke-linejoin: round; } .axis { stroke: #55636f; fill: none; }
.truth { stroke: #b4bec7; stroke-width: 7; } .path { stroke: #0072b2; stroke-width: 2.5; }
@media (prefers-color-scheme: dark) {
  .paper { fill: #161b22; } text { fill: #e6edf3; } .small { fill: #a5b3c0; } .axis { stroke: #a5b3c0; }
  .truth { stroke: #4d5a66; } .path { stroke: #56b4e9; }
}
"""


def pen(name, moments, duration):
    """A line that is there, and is then drawn anew as fast as `moments` says: at which share of the time how much of its length."""
    still = HOLD / (HOLD + duration)
    stops = [(0.0, 1.0), (still - 1e-4, 1.0), *((still + (1 - still) * time, share) for time, share in moments)]
    frames = " ".join(f"{100 * time:.3f}% {{ stroke-dashoffset: {1 - share:.4f}; }}" for time, share in stops)
    return (f"@keyframes {name} {{ {frames} }}\n"
            f".{name} {{ stroke-dasharray: 1; stroke-dashoffset: 0; animation: {name} {HOLD + duration:.1f}s linear infinite; }}")


def traveled(points, times, span):
    """[(share of the time, share of the length)], from 0 to 1."""
    length = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    grid = np.linspace(*span, STOPS + 1)
    return [*zip(np.linspace(0, 1, STOPS + 1), np.interp(grid, times, length / length[-1]))]


def line(points, kind):
    return f'<polyline pathLength="1" class="{kind}" points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in points)}"/>'


def text(x, y, words, kind="small", anchor="start"):
    return f'<text class="{kind}" x="{x:.0f}" y="{y:.0f}" text-anchor="{anchor}">{words}</text>'


class Recording:
    """The tables of a recording's run, and how they are laid out."""

    def __init__(self, directory):
        path, self.summary = read(directory, "odometry_path"), read(directory, "odometry_policies")
        self.truth, self.rows = path.where(policy="truth"), {policy: path.where(policy=policy) for policy in POLICIES}
        for policy, rows in self.rows.items():
            if not len(rows) or np.any(rows["segment"] != 0) or not len(self.truth):
                raise TableError(f"{directory}/csv/odometry_path.csv: the picture needs the truth and one segment of {policy}")
        self.span = min(rows["t_s"][0] for rows in self.rows.values()), max(rows["t_s"][-1] for rows in self.rows.values())
        self.low, high = (of(self.truth.matrix("x_m", "y_m"), axis=0) for of in (np.min, np.max))
        self.scale = min((PANEL - 2 * MARGIN) / (high - self.low)[0], MAP / (high - self.low)[1])
        self.left = (PANEL - self.scale * (high - self.low)[0]) / 2
        self.worst = 0.05 * np.ceil(max(np.nanmax(rows["error_m"]) for rows in self.rows.values()) / 0.05)

    def error(self, policy):
        return f"{self.summary.row(policy=policy)['ate_m']:.3f}"

    def above(self, rows):
        """From above, x to the right."""
        x, y = (rows.matrix("x_m", "y_m") - self.low).T
        return np.column_stack((self.left + self.scale * x, TOP + MAP - self.scale * y))

    def errors(self, rows):
        """Over time, on one axis for all."""
        share = (rows["t_s"] - self.span[0]) / (self.span[1] - self.span[0])
        return np.column_stack((MARGIN + 50 + (PANEL - 2 * MARGIN - 50) * share, FOOT - STRIP * rows["error_m"] / self.worst))


def panel(flight, policy, words):
    """One policy: the path over the truth, and below it how far they are apart."""
    rows = flight.rows[policy]
    yield text(MARGIN, 28, words["title"].format(name=POLICIES[policy]), "title")
    yield text(MARGIN, 52, words["error"].format(error=flight.error(policy)), "")
    some = slice(None, None, 1 + len(flight.truth) // 400)  # more, no eye would see
    yield line(flight.above(flight.truth)[some], "truth")
    yield line(flight.above(rows), f"path {policy}-path")
    yield f'<path class="axis" d="M{PANEL - MARGIN:.0f} {TOP + MAP}h{-flight.scale:.1f}" stroke-width="3"/>'
    yield text(PANEL - MARGIN - flight.scale / 2, TOP + MAP - 7, words["scale"], anchor="middle")
    yield f'<path class="axis" d="M{MARGIN + 50} {FOOT - STRIP}v{STRIP}H{PANEL - MARGIN}"/>'
    yield text(MARGIN + 44, FOOT - STRIP + 8, f"{100 * flight.worst:.0f} cm", anchor="end") + text(MARGIN + 44, FOOT + 4, "0", anchor="end")
    yield text(PANEL - MARGIN, FOOT - STRIP + 8, words["distance"], anchor="end")
    yield line(flight.errors(rows), f"path {policy}-error")


def picture(flight, language):
    """The SVG."""
    words, duration = WORDS[language], (flight.span[1] - flight.span[0]) / TIMES
    pens = [pen(f"{policy}-{what}", traveled(at(rows), rows["t_s"], flight.span), duration)
            for policy, rows in flight.rows.items() for what, at in (("path", flight.above), ("error", flight.errors))]
    alt = words["alt"].format(**{policy: flight.error(policy) for policy in POLICIES})
    source = words["source"].format(seconds=f"{flight.span[1] - flight.span[0]:.0f}", times=TIMES)
    keys = "".join(f'<path class="{kind}" d="M{x} {HEIGHT - 20}h26"/>' + text(x + 36, HEIGHT - 14, words[name])
                   for x, kind, name in ((MARGIN + 4, "truth", "truth"), (MARGIN + 124, "path", "estimate")))
    return "\n".join([
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {2 * PANEL} {HEIGHT}" role="img" aria-label="{alt}">',
        f"<style>\n{STYLE}" + "\n".join(pens) + "\n@media (prefers-reduced-motion: reduce) { .path { animation: none; } }\n</style>",
        f'<rect class="paper" width="{2 * PANEL}" height="{HEIGHT}" rx="10"/>',
        *(f'<g transform="translate({k * PANEL} 0)">{"".join(panel(flight, policy, words))}</g>' for k, policy in enumerate(POLICIES)),
        keys, text(2 * PANEL - MARGIN, HEIGHT - 14, source, anchor="end"), "</svg>\n"])


def main(argv):
    parser = argparse.ArgumentParser(prog="flight.py", description=__doc__.split("\n\n")[0])
    parser.add_argument("directory", type=Path, metavar="DIR")
    parser.add_argument("--out", type=Path, default=ROOT / "slides/figures")
    arguments = parser.parse_args(argv)
    try:
        flight = Recording(arguments.directory)
    except TableError as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    for language in WORDS:
        write_whole(arguments.out / f"flight.{language}.svg", picture(flight, language))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
