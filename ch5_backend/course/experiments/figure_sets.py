"""The table of all figures: what makes their tables, what draws them, and how long it takes. Nothing else knows."""

import os
import sys
from dataclasses import dataclass, field
from pathlib import Path

from ..base.build import BIN, ROOT, data_folder


@dataclass(frozen=True)
class FigureSet:
    """Figures that are drawn together.

    In `made_by` and `drawn_by`, {out} is what --out names, {folder} the set's own, {data} the data folder. With `trials`,
    each of so many runs of `made_by STUDY --trial K --out FILE` writes the rows of one trial, K = 0, 1, …, and merging
    them gives csv/STUDY.csv.
    """
    name: str
    folder: str                # of its tables and figures, below --out
    tables: tuple              # CSV files in it
    figures: tuple             # names in its folder figures/
    made_by: str               # a program of build/release/bin, and its words; or ""
    drawn_by: str              # a Python module of the project, and its words
    seconds: tuple             # about how long the two take, with two cores
    quick: tuple = ()          # further words of made_by for --quick, and its seconds; None: the set is left out
    needs: str = ""            # what it reads from the data folder, one or several
    trials: dict = field(default_factory=dict)  # {study: (trials, with --quick)}
    endings: tuple = (".png", ".svg")
    beside: str = ""           # other sets, whose tables it draws too

    def lacks(self, out: Path) -> list:
        """The tables that are not there."""
        return [name for name in self.tables if not Path(os.path.normpath(out / self.folder / name)).exists()]

    def files(self, out: Path) -> list:
        return [out / self.folder / "figures" / (name + ending) for name in self.figures for ending in self.endings]

    def has_data(self) -> bool:
        return all((data_folder() / name).exists() for name in self.needs.split())

    def command(self, template: str, out: Path) -> tuple:
        """The words of `made_by` or `drawn_by`: each may hold spaces once it is filled in."""
        program, *words = (word.format(out=out, folder=out / self.folder, data=data_folder())
                           for word in template.split())
        if program == "course":
            return str(ROOT / "course"), *words
        is_module = "." in program and "/" not in program
        return (sys.executable, "-m", program, *words) if is_module else (str(BIN / program), *words)


def csv(names: str) -> tuple:
    return tuple(f"csv/{name}.csv" for name in names.split())


def of_file(kind: str, path: str, script: str, tables: str, figures: str, seconds: tuple, **more) -> FigureSet:
    """What ./course run FILE solves and draws."""
    stem = Path(path).stem
    tables = tuple(name + ".csv" for name in tables.split())
    return FigureSet(f"{kind}/{stem}", stem, tables, tuple(figures.split()), f"ch5_{kind} {{data}}/{path} --out {{folder}}",
                     f"ch5_backend.figures.{script} {{folder}}", seconds, needs=path, **more)


def of_deck(number: int, tables: tuple, figures: str, made_by: str = "", beside: str = "") -> FigureSet:
    """The figures of a deck of slides, in both languages."""
    return FigureSet(f"slides/{number}", "slides", tables, tuple(figures.split()), made_by,
                     f"slides.build --figures --deck {number} --csv {{out}}/csv --out {{folder}}",
                     (10 if made_by else 0, 1), beside=beside, endings=(".en.svg", ".zh.svg"))


ODOMETRY = "odometry_path odometry_timing odometry_spectrum odometry_gauge odometry_film_vins odometry_film_okvis"
ODOMETRY_TABLES = "policies path windows matrices spectrum gauge"
SLIDES_TABLES = csv("mono_ba_summary mono_ba_trace mono_ba_frames mono_ba_points hessian spectrum prior_sweep "
                    "prior_trials prior_damping")
WINDOW_TABLES = csv("marginalize_chain marginalize_scene marginalize_fill odometry_policies odometry_path odometry_spectrum "
                    "odometry_gauge slide_vertices slide_observations slide_matrices slide_priors slide_frames")
NEES_TABLES = csv("consistency consistency_summary")


def of_gauge(part: str, needs: str, seconds: tuple, figures: str, **trials) -> FigureSet:
    """Part of the gauge paper's experiments; all parts share a folder and a page, which shows those that are there."""
    return FigureSet(f"gauge_{part}", "gauge", csv(" ".join(trials)), tuple(figures.split()), "ch5_gauge --data {data}",
                     "ch5_backend.figures.gauge_report {folder}", seconds, needs=needs, trials=trials)


SETS = (
    FigureSet("chapter", "", SLIDES_TABLES + WINDOW_TABLES + NEES_TABLES + csv(
        "mono_ba_iterations hessian_vertices hessian_edges hessian_blocks prior_trace odometry_windows odometry_matrices"),
        tuple(("scene_course scene_large mono_ba_convergence hessian_course hessian_large spectrum marginalize_chain "
               "marginalize_scene prior_sweep prior_costs prior_traces prior_trials prior_damping consistency "
               + ODOMETRY).split()),
        "ch5_chapter --out {out}", "ch5_backend.figures.report {out}", (10, 12)),
    of_deck(1, tuple(f"../{name}" for name in SLIDES_TABLES),
            "overview scene sparsity convergence spectrum prior_iterations prior_damping prior_answer graph one_edge schur "
            "chain moves river valley", "ch5_chapter --out {out}"),
    of_deck(2, tuple(f"../{name}" for name in csv(
        "solver_pcg solver_spectrum solver_rules solver_half_damped solver_stop solver_paths solver_dogleg solver_losses "
        "solver_outliers solver_corrections")),
            "questions order trust pcg conditioning first_step factors rules half_damped dogleg paths losses curvature "
            "outliers", "ch5_solvers --out {out}"),
    of_deck(3, tuple(f"../{name}" for name in WINDOW_TABLES),
            "clique chain_graph windows product fill prior_spectrum slide_tracks slide_fates slide_priors slide_film "
            "odometry_error nees_twice nees_modes yaw_information yaw_leak", "ch5_chapter --out {out}", beside="nees"),
    of_deck(4, (), "three_ways gauge_zeros gauge_iterations gauge_weights gauge_arrival choice_damping choice_place "
            "gauge_sigma gauge_covariances", beside="gauge_paper gauge_prior_choice"),
    of_deck(5, (), "g2o mapping flow lanes groups shares rungs lanes_gain roofline peers reduced"),
    FigureSet("nees", "nees", NEES_TABLES, ("consistency",), "ch5_nees --out {folder}",
              "ch5_backend.figures.nees {folder}", (60, 3), quick=("--runs 4 --seconds 6", 2)),
    FigureSet("endurance", "endurance", csv("endurance"), ("endurance",), "ch5_endurance --out {folder}",
              "ch5_backend.figures.endurance {folder}", (40, 2), quick=("--frames 1000", 4)),
    FigureSet("bench", "bench", ("rows.csv", "traces.csv"), ("bench_cost", "bench_size"), "course bench --out {out}",
              "ch5_backend.figures.bench {folder}", (300, 4), quick=("--quick scene/3x20 scene/10x200 scene/30x200", 10)),
    *(of_file("bal", f"bal/{name}.txt", "bal", "points cameras trace summary", "before_after", seconds)
      for name, seconds in (("problem-49-7776-pre", (1, 2)), ("problem-16-22106-pre", (1, 3)),
                            ("maplab-969-22767", (6, 4)))),
    *(of_file("pose_graph", f"posegraph/{name}.g2o", "pose_graph", "poses edges trace summary", "pose_graph", (1, 2))
      for name in ("intel", "MIT", "parking-garage", "sphere2500")),
    *(of_file("window", f"windows/{name}.txt", "window", "frames trace summary", "window", (1, 2))
      for name in ("mono_10_500", "mono_20_1500", "vio_S", "vio_M", "vio_L", "vio_Md", "real_euroc_sub2",
                   "real_tango_100")),
    *(of_file("recording", name, "recording", " ".join(f"csv/odometry_{table}" for table in ODOMETRY_TABLES.split()),
              ODOMETRY, seconds, quick=quick)
      for name, seconds, quick in (("euroc_v1_01_easy", (3, 9), ()), ("tango_walk", (40, 9), None))),
    of_gauge("paper", "", (41, 10), "gauge_methods gauge_errors gauge_sweep gauge_convergence gauge_spectrum "
             "gauge_matrices gauge_deviations", methods=(50, 5), sweep=(50, 3), convergence=(10, 2), spectrum=(1, 1),
             covariance=(10, 2), deviations=(1, 1), matrices=(1, 1), audit=(1, 1)),
    of_gauge("prior_choice", "", (20, 10), "gauge_prior_choice", prior_choice=(20, 2)),
    of_gauge("recordings", "euroc_v1_01_easy tango_walk", (15, 10), "gauge_recordings", recordings=(50, 2)),
)
if not (ROOT / "slides" / "build.py").exists():  # the students' archive
    SETS = tuple(one for one in SETS if one.folder != "slides")
