"""What makes every table and draws it, and how long both take. Nothing else knows."""

import shlex
import sys
from csv import DictReader
from dataclasses import dataclass, field
from pathlib import Path

from ..base.cmake_build import BIN, ROOT, data_folder


@dataclass(frozen=True)
class FigureSet:
    """Tables, and figures that are drawn together.

    In `made_by` and `drawn_by`, {out} is what --out names, {folder} the set's own, {data} the data folder. With `trials`,
    each of so many runs of `made_by STUDY --trial K --out FILE` writes the rows of one trial, K = 0, 1, …, and merging
    them gives csv/STUDY.csv.
    """
    name: str
    folder: str                # of its tables and figures, below --out
    tables: tuple              # CSV files in it
    made_by: str               # a program of build/release/bin, and its words; or ""
    drawn_by: str              # a Python module of the project, and its words
    seconds: tuple             # about how long the two take, with two cores
    quick: tuple = ()          # further words of made_by for --quick, and its seconds; None: the set is left out
    needs: str = ""            # what it reads from the data folder, one or several
    trials: dict = field(default_factory=dict)  # {study: (trials, with --quick)}
    beside: str = ""           # other sets, whose tables it draws too

    def lacks_tables(self, out: Path) -> bool:
        return not all((out / self.folder / name).exists() for name in self.tables)

    def has_data(self) -> bool:
        return all((data_folder() / name).exists() for name in self.needs.split())

    def command(self, template: str, out: Path) -> tuple:
        """The words of `made_by` or `drawn_by`, quoted as a shell's: each may hold spaces once it is filled in."""
        program, *words = (word.format(out=out, folder=out / self.folder, data=data_folder())
                           for word in shlex.split(template))
        is_module = "." in program and "/" not in program
        return (sys.executable, "-m", program, *words) if is_module else (str(BIN / program), *words)


def csv(names: str) -> tuple:
    return tuple(f"csv/{name}.csv" for name in names.split())


def written_by(program: str) -> tuple:
    """The tables of experiments/tables.csv that it writes."""
    with open(ROOT / "ch5_backend" / "experiments" / "tables.csv", newline="", encoding="utf-8") as file:
        return csv(" ".join(row["table"] for row in DictReader(file) if row["program"] == program))


def of_file(kind: str, path: str, tables: str, seconds: tuple, **more) -> FigureSet:
    """What ./course run FILE solves and draws."""
    stem = Path(path).stem
    return FigureSet(f"{kind}/{stem}", stem, tuple(f"{name}.csv" for name in tables.split()),
                     f"ch5_{kind} {{data}}/{path} --out {{folder}}", f"ch5_backend.figures.{kind} {{folder}}", seconds,
                     needs=path, **more)


def of_deck(number: int, beside: str = "", tables: tuple = (), made_by: str = "") -> FigureSet:
    """The figures of a deck of slides, in both languages."""
    draw = f"slides.build --figures {number}- --csv {{out}}/csv --out {{out}}/slides"
    return FigureSet(f"slides/{number}", "", tables, made_by, draw, (10 if made_by else 0, 1), beside=beside)


def of_gauge(part: str, needs: str, seconds: tuple, **trials) -> FigureSet:
    """Part of the gauge paper's experiments; all parts share a folder and a page, which shows those that are there."""
    return FigureSet(f"gauge_{part}", "gauge", csv(" ".join(trials)), "ch5_gauge --data {data}",
                     "ch5_backend.figures.gauge_report {folder}", seconds, needs=needs, trials=trials)


RECORDING = " ".join(f"csv/odometry_{name}" for name in
                     "policies results segments path lengths consistency windows spectrum gauge warnings machine".split())
SYSTEMS = {"ablation": (30, 1), "ablation_recording": (1, 1), "consistency_recording": (6, 1), "first_estimates": (18, 1), "walk_scale": (3, 1),
           "back_ends": (1, 1), "calibration": (6, 1),
           "preintegration": (1, 1), "distance": (1, 1), "window_size": (3, 1), "pose_graphs": (24, 1), "pose_graph_starts": (6, 1),
           "false_loops": (12, 1), "machine": (1, 1)}
SETS = (
    FigureSet("chapter", "", written_by("ch5_chapter"), "ch5_chapter --out {out}", "ch5_backend.figures.report {out}", (10, 12)),
    of_deck(1, "chapter"),
    of_deck(2, "chapter", tables=written_by("ch5_solvers"), made_by="ch5_solvers --out {out}"),
    of_deck(3, "chapter"),
    of_deck(4, "gauge_paper gauge_prior_choice"),
    of_deck(5),
    of_deck(6, "chapter"),
    of_deck(7, "chapter"),
    FigureSet("nees", "nees", csv("consistency consistency_summary"), "ch5_nees --out {folder}",
              "ch5_backend.figures.nees {folder}", (240, 3), quick=("--runs 4 --seconds 6", 2)),
    FigureSet("systems", "systems", csv(" ".join(SYSTEMS)), "ch5_systems --data {data}", "ch5_backend.figures.systems {folder}",
              (900, 8), quick=None, needs="euroc_v1_01_easy tango_walk posegraph windows", trials=SYSTEMS),
    FigureSet("endurance", "endurance", csv("endurance"), "ch5_endurance --out {folder}",
              "ch5_backend.figures.endurance {folder}", (40, 2), quick=("--frames 1000", 4)),
    FigureSet("bench", "bench", ("rows.csv", "traces.csv"), "ch5_backend.course bench --out {out}", "ch5_backend.figures.bench {folder}",
              (300, 4), quick=("--quick scene/3x20 scene/10x200 scene/30x200", 10)),
    *(of_file("bal", f"bal/{name}.txt", "points cameras trace summary", seconds) for name, seconds in (
        ("problem-49-7776-pre", (1, 2)), ("problem-16-22106-pre", (1, 3)), ("maplab-969-22767", (6, 4)))),
    *(of_file("pose_graph", f"posegraph/{name}.g2o", "poses edges trace summary", (1, 2))
      for name in ("intel", "MIT", "parking-garage", "sphere2500")),
    *(of_file("window", f"windows/{name}.txt", "frames trace summary", (1, 2)) for name in (
        "mono_10_500", "mono_20_1500", "vio_S", "vio_M", "vio_L", "vio_Md", "real_euroc_sub2", "real_tango_100")),
    of_file("recording", "euroc_v1_01_easy", RECORDING, (3, 9)),
    of_file("recording", "tango_walk", RECORDING, (40, 9), quick=None),
    of_gauge("paper", "", (60, 11), methods=(50, 5), sweep=(50, 3), near_start=(50, 3), variants=(20, 2),
             convergence=(10, 2), spectrum=(1, 1), covariance=(10, 2), deviations=(1, 1), matrices=(1, 1), audit=(1, 1)),
    of_gauge("prior_choice", "", (20, 10), prior_choice=(20, 2)),
    of_gauge("recordings", "euroc_v1_01_easy tango_walk", (15, 10), recordings=(50, 2)),
)
if not (ROOT / "slides" / "build.py").exists():  # the students' archive
    SETS = tuple(one for one in SETS if not one.name.startswith("slides/"))
