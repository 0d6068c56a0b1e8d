#!/usr/bin/python3
"""Draws every figure of the chapter and writes one self-contained page in each language, DIR/report.html and
DIR/report.zh.html.

usage: report.py [DIR]        DIR is out/ unless given; ch5_chapter --out DIR must have filled DIR/csv

The tables in DIR/csv and their columns: ch5_backend/experiments/tables.csv. Each has one row of names, then numbers in meters and
radians; costs are ½ Σ rᵀWr.
"""

import os
import shutil
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from markupsafe import Markup

from . import blocks, captions, convergence, film, hero, hessian, marginalize, nees, odometry, page, prior, scene, sliders, style, systems
from .numbers.chapter import Chapter
from .numbers.windows import KEPT
from .tables import Tables

# The longest first, so that two processes finish together.
SCRIPTS = (odometry, systems, nees, prior, scene, hessian, convergence, marginalize, hero)
EXPLORERS = {"bundle-adjustment": sliders.iterations, "odometry": lambda directory, say: film.player(directory, say, "simulated"), "the-priors-weight": sliders.weights,
             "the-hessian": lambda directory, say: blocks.explorer(directory, "course", say)}

# The kept tables of each figure that does not show this run.
KEPT_OF = {"consistency_causes": ("consistency", "consistency_summary"), "consistency": ("consistency", "consistency_summary"),
           "systems_ablation": ("ablation", "ablation_recording"), "systems_back_ends": ("back_ends",),
           "systems_calibration": ("calibration",), "systems_preintegration": ("preintegration",), "systems_distance": ("distance",),
           "systems_window_size": ("window_size",), "systems_pose_graphs": ("pose_graphs", "pose_graph_starts")}

# Beside each finding a part of a figure: left, top, right, bottom.
THUMBNAILS = {"bundle-adjustment": ("scene_large", (0.5, 0.17, 1.0, 0.93)), "the-hessian": ("hessian_course", (0.0, 0.08, 0.5, 1.0)),
              "the-priors-weight": ("prior_trials", (0.0, 0.0, 0.5, 1.0)), "odometry": ("odometry_path", (0.0, 0.0, 0.48, 0.57))}

BESIDE = ("lab.html", "api/index.html")

# {section: (lectures, stages of the homework)}
BELONGS = {"bundle-adjustment": ("1", "1.1", "1.2"), "the-hessian": ("1", "1.1", "1.2", "7"), "marginalization": ("1", "2"),
           "the-priors-weight": ("1", "3"), "odometry": ("3", "5", "6"), "consistency": ("6", "6"),
           "systems": ("6", "5", "6", "7")}
NEXT = {"check": "./course check", "lab": "./course lab", "plots": "./course plots", "data": "./course run DATA"}


def solves_table(n, directory, say):
    """The table of the solves, a column a scene."""
    scenes = [n.solve(name) for name in n.tables("mono_ba_summary")["scene"]]
    rows = (("sizes", lambda row: f"{row['frames']:.0f} × {row['points']:.0f}"),
            ("unknowns", lambda row: f"{row['unknowns']:.0f}"), ("edges", lambda row: f"{row['edges']:.0f}"),
            ("first_cost", lambda row: style.number(row["initial_cost"])),
            ("last_cost", lambda row: style.number(row["final_cost"], 4)),
            ("iterations", lambda row: f"{row['iterations']:.0f}"),
            ("time", lambda row: style.number(row["milliseconds"], 2)),
            ("stopped_by", lambda row: say(row["termination"])))
    return (page.table((say("scene"), *(say(f"scene.{row['scene']}") for row in scenes)),
                       [(say(title), *map(cell, scenes)) for title, cell in rows], "words") +
            page.paragraph(say("solves_note", machine=odometry.machine(directory, say))))


def measured(figure, say):
    """Of a figure from kept tables: when and on what they were made, with links to them; else nothing."""
    about = [KEPT("measured").row(table=name) for name in KEPT_OF.get(figure, ())]
    marks = []
    for date, processor in dict.fromkeys((row["date"], row["processor"]) for row in about):
        names = [row["table"] for row in about if (row["date"], row["processor"]) == (date, processor)]
        links = [Markup('<a href="kept/{0}.csv">{0}.csv</a>').format(name) for name in names]
        marks.append(Markup("<em>{}</em> {}").format(
            say("measured", date=date, processor=processor and say("list") + processor), Markup(say("list")).join(links)))
    return Markup(" · ").join(marks)


def keep_tables(directory):
    """The kept tables beside the page, which links to them."""
    shutil.copytree(KEPT.folder, Path(directory) / "kept", dirs_exist_ok=True)


def contents(sections, directory, say):
    """Links to the sections, and to the pages beside this one that have been made."""
    titles = {**{section: say(f"section.{section}") for section in sections}, "tables": say("tables")}
    links = [(f"#{section}", title) for section, title in titles.items()]
    links += [(place, say(place)) for place in BESIDE if (Path(directory) / place).exists()]
    return page.PIECES.contents(links, say)


def body_of(directory, say):
    """The page's pieces."""
    n = Chapter(Tables(Path(directory) / "csv"))
    sections = {**captions.sections(n, say), "odometry": odometry.captions(directory, say),
                "consistency": nees.captions(say), "systems": systems.captions(directory, say)}
    found = {section: (words, page.thumbnail(directory, *THUMBNAILS[section], say)) for section, words in captions.findings(n, say).items()}
    body = [*page.opening(say("heading"), say("lead"), say), page.figure(directory, "hero", hero.caption(directory, say), say("hero.alt"), say),
            page.PIECES.findings(say("findings"), found),
            contents(sections, directory, say), solves_table(n, directory, say)]
    for section, figures in sections.items():
        lecture, *stages = BELONGS[section]
        pieces = [Markup("<p class=\"belongs\">{}</p>").format(say("belongs", lectures=lecture, stages=say("list").join(stages)))]
        if section == "the-hessian":
            pieces.append(page.paragraph(say("hessian_size", **captions.names_of(n))))
        pieces += [EXPLORERS[section](directory, say)] if section in EXPLORERS else []
        pieces += [page.figure(directory, name, caption, say(f"{name}.alt"), say, measured(name, say))
                   for name, caption in figures.items()]
        if section == "consistency":
            pieces += [nees.cases_table(say), page.paragraph(say("consistency.hosts"), say), nees.hosts_table(say),
                       page.paragraph(nees.why_none(say), say), nees.first_estimates_table(say),
                       nees.paired_table(say)]
        if section == "systems":
            pieces.insert(2, systems.ablation_table(say))  # below its figure
            pieces += [page.paragraph(say("starts.lead"), say), systems.starts_table(say)]
        body.append(page.PIECES.section(section, say(f"section.{section}"), pieces))
    steps = [(command, say(f"next.{name}")) for name, command in NEXT.items()]
    return [*body, page.PIECES.steps(say("next"), steps), page.links_to_tables(directory, say)]


def draw_one(index, directory):
    SCRIPTS[index].draw(directory)


def draw(directory):
    """All figures and the pages."""
    with ProcessPoolExecutor(max_workers=min(len(SCRIPTS), os.cpu_count() or 1)) as pool:
        for done, _ in enumerate(pool.map(draw_one, range(len(SCRIPTS)), [directory] * len(SCRIPTS)), start=1):
            if sys.stderr.isatty():
                print(f"\r\033[Kfigures {done} of {len(SCRIPTS)}", end="", file=sys.stderr, flush=True)
    keep_tables(directory)
    page.write_all(directory, "title", body_of)
    if sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr)


if __name__ == "__main__":
    style.main(draw)
