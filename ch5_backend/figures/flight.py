#!/usr/bin/python3
"""Draws a flight whose window slides, image by image: the moving picture of the READMEs, slides/figures/flight.*.svg.

usage: flight.py [--lab PROGRAM] [--out DIR]

  --lab PROGRAM   the lab in a terminal, default build/release/bin/ch5_lab (ninja -C build/release ch5_lab)
  --out DIR       default slides/figures

A flight magnifies rounding: another compiler may draw other last digits.
"""
import argparse
import json
import subprocess
import sys
from pathlib import Path

from .atomic_write import write_whole

ROOT = Path(__file__).resolve().parents[2]
FLIGHT = "panel=window&rate=5&tracks=30"
POLICIES = {"vins": "VINS-Mono", "okvis": "OKVIS"}
WORDS = {  # what the picture says; the report's and the decks' words are in words/
    "en": {"alt": "Two windows slide along a simulated flight: VINS-Mono's keeps neighboring frames, OKVIS's keeps old keyframes",
           "full": "in the window, with its speed", "pose": "in the window, pose only", "prior": "held by the prior",
           "lines": "estimate; gray: the true path", "row": "the {} images of the flight"},
    "zh": {"alt": "两种滑动窗口沿一段仿真飞行前进：VINS-Mono 保留相邻的帧，OKVIS 保留较早的关键帧",
           "full": "在窗口里，带速度", "pose": "在窗口里，只有位姿", "prior": "先验所约束的", "lines": "估计的轨迹；灰色：真实轨迹", "row": "飞行中的 {} 帧图像"}}
SECONDS = 0.45  # an image is shown
PANEL, HEIGHT, MARGIN = 430, 300, 26
MAP = 190       # height of the view from above; below it a row of images

STYLE = """\
.paper { fill: #ffffff; }  /* a page may be dark where the reader's system is light */
text { font: 15px system-ui, 'Noto Sans', 'Noto Sans CJK SC', sans-serif; fill: #22303c; }
.title { font-weight: 600; font-size: 17px; } .small { font-size: 13px; fill: #5b6a78; }
.truth, .path { fill: none; stroke-width: 2; stroke-linecap: round; stroke-linejoin: round; }
.truth { stroke: #c3ccd4; stroke-width: 5; } .path { stroke: #3b76a8; }
.pose { fill: #3b76a8; } .full { fill: #d99a3c; } .prior { fill: none; stroke: #c2555b; stroke-width: 2.5; } .gone { fill: #dfe5ea; }
@media (prefers-color-scheme: dark) {
  .paper { fill: #161b22; } text { fill: #e6edf3; } .small { fill: #9fb0bf; } .truth { stroke: #45525e; } .path, .pose { stroke: #7fb2dd; }
  .path { fill: none; } .pose { fill: #7fb2dd; } .gone { fill: #34404b; } .prior { stroke: #f08a8f; }
}
"""
# Each image is shown in its turn; who wants no motion sees the last one.
MOTION = """\
.image {{ opacity: 0; animation: show {total:g}s step-end infinite; }}
@keyframes show {{ 0% {{ opacity: 1; }} {share:.4f}% {{ opacity: 0; }} }}
@media (prefers-reduced-motion: reduce) {{ .image {{ animation: none; }} .image:last-of-type {{ opacity: 1; }} }}
"""


def fly(lab):
    """What the lab answers for each image of the flight."""
    first = answer(lab, 0)
    return [first, *(answer(lab, k) for k in range(1, first["images"]))]


def answer(lab, image):
    done = subprocess.run([lab, f"{FLIGHT}&image={image}"], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


class View:
    """From above, y to the right and x upward, as large as the panel allows."""

    def __init__(self, points, left):
        self.left = left
        self.low = [min(point[k] for point in points) for k in (0, 1)]
        high = [max(point[k] for point in points) for k in (0, 1)]
        self.high_x = high[0]
        self.scale = min((PANEL - 2 * MARGIN) / (high[1] - self.low[1]), (MAP - 60) / (high[0] - self.low[0]))

    def __call__(self, point):
        return self.left + MARGIN + self.scale * (point[1] - self.low[1]), 48 + self.scale * (self.high_x - point[0])

    def line(self, points, kind):
        return f'<polyline class="{kind}" points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in map(self, points))}"/>'


def marks(x, y, frame, radius):
    """A frame of the window: its pose, with its speed if that is kept, and a ring if the prior holds it."""
    dot = f'<circle class="{"full" if frame["speed"] else "pose"}" cx="{x:.1f}" cy="{y:.1f}" r="{radius}"/>'
    ring = f'<circle class="prior" cx="{x:.1f}" cy="{y:.1f}" r="{radius + 3}"/>'
    return dot + ring * frame["in_prior"]


def tick(left, image, images):
    """Where an image has its place in the row below the view."""
    return left + MARGIN + (PANEL - 2 * MARGIN) * image / (images - 1)


def shown(seen, policy, view, image):
    """One policy's window after an image."""
    window = seen[policy]
    drawn = [view.line(window["positions"][:image + 1], "path")]
    for frame in window["frames"]:
        drawn.append(marks(*view(frame["p"]), frame, 5))
        drawn.append(marks(tick(view.left, frame["id"], seen["images"]), MAP + 36, frame, 4))
    return "".join(drawn)


def legend(words, y):
    """What the marks mean, in one row."""
    entries = (({"speed": True, "in_prior": False}, words["full"]), ({"speed": False, "in_prior": False}, words["pose"]),
               ({"speed": True, "in_prior": True}, words["prior"]))
    for k, (frame, meaning) in enumerate(entries):
        x = MARGIN + 10 + k * (2 * PANEL - MARGIN) / 3
        yield marks(x, y - 5, frame, 5) + f'<text class="small" x="{x + 16:.0f}" y="{y}">{meaning}</text>'


def picture(flight, language):
    """The SVG of all images, from what the lab has answered."""
    words, images = WORDS[language], len(flight)
    points = flight[-1]["truth"] + [p for policy in POLICIES for p in flight[-1][policy]["positions"]]
    views = {policy: View(points, k * PANEL) for k, policy in enumerate(POLICIES)}
    total = SECONDS * images
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {2 * PANEL} {HEIGHT}" role="img" aria-label="{words["alt"]}">',
             f"<style>\n{STYLE}{MOTION.format(total=total, share=100 / images)}</style>",
             f'<rect class="paper" width="{2 * PANEL}" height="{HEIGHT}" rx="10"/>']
    for policy, view in views.items():
        lines.append(f'<text class="title" x="{view.left + MARGIN}" y="26">{POLICIES[policy]}</text>')
        lines.append(f'<text class="small" x="{view.left + MARGIN + 110}" y="26">{words["lines"]}</text>')
        lines.append(view.line(flight[-1]["truth"], "truth"))
        lines += [f'<circle class="gone" cx="{tick(view.left, k, images):.1f}" cy="{MAP + 36}" r="4"/>' for k in range(images)]
        lines.append(f'<text class="small" x="{view.left + MARGIN}" y="{MAP + 62}">{words["row"].format(images)}</text>')
    lines += legend(words, HEIGHT - 12)
    for k, seen in enumerate(flight):
        windows = "".join(shown(seen, policy, view, k) for policy, view in views.items())
        lines.append(f'<g class="image" style="animation-delay:{SECONDS * k - total:.2f}s">{windows}</g>')
    return "\n".join([*lines, "</svg>\n"])


def main(argv):
    parser = argparse.ArgumentParser(prog="flight.py", description=__doc__.split("\n\n")[0])
    parser.add_argument("--lab", type=Path, default=ROOT / "build/release/bin/ch5_lab")
    parser.add_argument("--out", type=Path, default=ROOT / "slides/figures")
    arguments = parser.parse_args(argv)
    flight = fly(arguments.lab)
    for language in WORDS:
        write_whole(arguments.out / f"flight.{language}.svg", picture(flight, language))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
