#!/usr/bin/python3
"""Draws both policies' errors on many recordings, without and with first estimates, beside published ones of EuRoC's flights:
DIR/figures/recordings.*, DIR/report.html, in Chinese DIR/report.zh.html.

usage: recordings.py DIR        the folder that ./course run DATA … --table --out DIR has filled

A flight of EuRoC's that was not given keeps its place in both, empty.
"""
import re
from pathlib import Path

import numpy as np
from markupsafe import Markup

from . import page, style
from .digits import fixed
from .odometry import COLORS, NAMES
from .style import GRAY
from .tables import read, read_table
from .words import Labels

PUBLISHED = Path(__file__).resolve().parents[1] / "experiments" / "published.csv"  # ATE [m] of whole flights with one camera
MODES = {"none": ("", "recordings.without"), "full": (", first estimates", "recordings.with")}  # in a figure, and the page's sentence
QUANTITIES = {"ate_m": ("ATE [m]", "recordings.ate"), "rpe_m": ("RPE over 1 s [m]", "recordings.rpe"),
              "nees_motion": ("NEES of the motion (6)", "recordings.nees")}


def flight(name):
    """EuRoC's short name of it, if it is one."""
    found = re.search(r"(MH|V[12])_0\d", name.upper())
    return found and found.group()


def places(rows, published):
    """The recordings' names, in EuRoC's order; where none is of a flight, that flight's."""
    names = list(dict.fromkeys(rows["recording"].tolist()))
    flights = [name for name in published.columns if flight(name)]
    return [name for one in flights for name in [given for given in names if flight(given) == one] or [one]] + \
           [name for name in names if flight(name) not in flights]


def value(rows, name, policy, mode, quantity):
    """NaN where there is none."""
    found = rows.where(recording=name, policy=policy, first_estimates=mode)[quantity]
    return float(found[0]) if len(found) else np.nan


def draw_errors(directory, rows, published):
    names = places(rows, published)
    with style.panels(directory, "recordings", 3, 1, (10.0, 9.0), sharex=True) as panels:
        at = np.arange(len(names))
        for axes, (quantity, (title, _)) in zip(panels, QUANTITIES.items()):
            for k, (policy, mode) in enumerate((policy, mode) for policy in COLORS for mode in MODES):
                values = [value(rows, name, policy, mode, quantity) for name in names]
                axes.plot(at + 0.12 * (k - 1.5), values, "s" if mode == "full" else "o", color=COLORS[policy], markersize=7,
                          fillstyle="none" if mode == "full" else "full", label=NAMES[policy] + MODES[mode][0])
            axes.set_title(title)
            style.plain_log(axes.yaxis)
        for mark, system in zip(style.MARKS[2:], published.rows()):
            values = [system.get(flight(name), np.nan) for name in names]
            panels[0].plot(at, values, mark, color=GRAY, markersize=5, label=system["system"])
        panels[2].axhline(6, color=GRAY, linewidth=1)
        panels[2].set_xticks(at, names, rotation=35, ha="right")
        panels[2].set_xlim(-0.6, len(names) - 0.4)
        style.legend_above(panels[0], 2)
        style.space(panels[0].figure, rect=(0, 0, 1, 0.86))


def tables(rows, published, say):
    """A row a recording: its path, and each quantity without and with first estimates; then the published ones."""
    names = places(rows, published)
    named = Labels(say.language)
    settings = [(policy, mode) for policy in COLORS for mode in MODES]
    heads = [say(MODES[mode][1], policy=NAMES[policy]) for policy, mode in settings]
    for quantity, (_, title) in QUANTITIES.items():
        others = published.rows() if quantity == "ate_m" else []
        digits = 1 if quantity == "nees_motion" else 3
        cells = [(name, fixed(value(rows, name, *settings[0], "path_m"), 1),
                  *(fixed(value(rows, name, *setting, quantity), digits) for setting in settings),
                  *(fixed(one.get(flight(name), np.nan), 2) for one in others)) for name in names]
        yield Markup("<h2>{}</h2>").format(say(title))
        yield page.table((say("recordings.name"), say("path_length"), *heads, *(named(one["system"]) for one in others)), cells)
        if others:
            links = [Markup('<a href="{}">{}</a>').format(one["source"], named(one["system"])) for one in others]
            yield Markup("<p>{}</p>").format(Markup(say("recordings.published", links="{}")).format(Markup(say("list")).join(links)))


def body_of(directory, say):
    rows, published = read(directory, "recordings"), read_table(PUBLISHED)
    return [*page.opening(say("recordings.title"), say("recordings.lead"), say),
            page.figure(directory, "recordings", say("recordings.caption"), say("recordings.alt"), say),
            *tables(rows, published, say), page.paragraph(say("recordings.gauge"), say), page.links_to_tables(directory, say)]


def draw(directory):
    draw_errors(directory, read(directory, "recordings"), read_table(PUBLISHED))
    page.write_all(directory, "recordings.title", body_of)


if __name__ == "__main__":
    style.main(draw)
