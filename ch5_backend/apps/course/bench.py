"""./course bench: our solvers and Ceres on the same problems, side by side."""

import csv
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

from . import jsonout
from .build import BIN, build_or_fail, data_folder
from .errors import CourseError
from .progress import Progress
from .run import PLOT, app, make_writable

# name: what the programs read ("scene:" or a file below the data folder), and runs inside of one process: a short one
# needs several, of which the first warms up.
PROBLEMS = {
    **{f"scene/{size}": (f"scene:{size}", 6) for size in ("3x20", "10x200", "30x200", "30x1000", "30x4000")},
    **{f"window/{name}": (f"windows/{name}.txt", 6)
       for name in ("vio_S", "vio_M", "vio_L", "vio_Md", "real_euroc_sub2", "mono_10_500", "mono_20_1500")},
    **{f"pose_graph/{name}": (f"posegraph/{name}.g2o", 1) for name in ("parking-garage", "sphere2500")},
    "bal/49-7776": ("bal/problem-49-7776-pre.txt", 1),
    "bal/16-22106": ("bal/problem-16-22106-pre.txt", 1),
    "bal/maplab-969-22767": ("bal/maplab-969-22767.txt", 1),
}
TWO_THREADS = ("bal/",)  # also measured with two threads, ours against Ceres' better one
QUICK_SECONDS = 55.0     # then each problem is measured once more at most
FIELDS = ("problem", "threads", "ours_ms", "peer", "peer_ms", "ratio", "ours_cost", "peer_cost", "ours_peak_mb",
          "peer_peak_mb")


def bench(arguments) -> int:
    """Returns the exit code; raises CourseError for a name that no problem has, or a program that failed."""
    cases = [(name, threads) for name in chosen(arguments.names) for threads in (1, 2)
             if threads == 1 or (name.startswith(TWO_THREADS) and not arguments.quick)]
    out = Path(arguments.out or "out") / "bench"
    make_writable(out)
    build_or_fail(["bench_programs"])
    peer = "Ceres" if (BIN / "measure_ceres").exists() else None
    if peer is None:
        say("Ceres is not installed (Debian: libceres-dev): our times stand alone")
    repetitions = 3 if arguments.quick else 5
    deadline = time.monotonic() + QUICK_SECONDS if arguments.quick else None
    rows, traces = [], []
    with Progress("bench") as progress:
        for name, threads in cases:
            place = source(name)
            if place is None:
                say(f"{name} is left out: there is no {data_folder() / PROBLEMS[name][0]}")
                continue
            progress.step(f"{name}, {threads} thread{'s' if threads > 1 else ''}")
            ours, theirs = measure(name, place, threads, peer, repetitions, deadline)
            rows += rows_of(name, threads, ours, peer, theirs)
            traces += traces_of(name, threads, ours, theirs)
    if not rows:
        raise CourseError(f"nothing to measure: no data in {data_folder()}; set CH5_DATA_DIR")
    write(out / "rows.csv", FIELDS, [[row[field] for field in FIELDS] for row in rows])
    write(out / "traces.csv", ("problem", "threads", "side", "seconds", "cost"), traces)
    app([sys.executable, PLOT / "bench.py", out], arguments.json)
    if arguments.json:
        jsonout.emit({"rows": rows})
    else:
        print(table(rows) + f"\nThe tables and plots: {out}")
    return 0


def say(text: str) -> None:
    print(f"course: {text}", file=sys.stderr)


def chosen(names) -> list:
    """The problems whose name contains one of `names`; all without names."""
    for name in names:
        if not any(name in problem for problem in PROBLEMS):
            raise CourseError(f"no problem is called '{name}'; there are {', '.join(PROBLEMS)}")
    return [problem for problem in PROBLEMS if not names or any(name in problem for name in names)]


def source(name: str):
    """What the programs read, or None if the file is not there."""
    where = PROBLEMS[name][0]
    if where.startswith("scene:"):
        return where
    return data_folder() / where if (data_folder() / where).exists() else None


def measure(name: str, place, threads: int, peer, repetitions: int, deadline) -> tuple:
    """Lists of runs of both sides, taking turns; each turn is a process of its own, of which a list of runs comes."""
    ours, theirs = [], []
    for turn in range(repetitions):
        if turn and deadline and time.monotonic() > deadline:
            break
        ours.append(run_side("ours", name, place, threads))
        if peer:  # which is faster with one thread on all of these
            theirs.append(run_side("ceres", name, place, 1))
    return ours, theirs


def run_side(side: str, name: str, place, threads: int) -> list:
    repeat = PROBLEMS[name][1]
    done = subprocess.run([BIN / f"measure_{side}", str(place), "--threads", str(threads), "--repeat", str(repeat)],
                          capture_output=True, text=True, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"})
    if done.returncode:
        raise CourseError(f"measuring {name} failed: {done.stderr.strip()}", 1)
    return [json.loads(line) for line in done.stdout.splitlines()][-max(1, repeat - 1):]


def seconds_to(run: dict, cost: float):
    """When the run had reached `cost`, or None."""
    return next((seconds for seconds, reached in run["trace"] if reached <= cost), None)


def rows_of(name: str, threads: int, ours: list, peer, theirs: list) -> list:
    """A row for each question that the runs answer; ratio is peer_ms / ours_ms, null where a side has no answer."""
    best = min(run["final_cost"] for turn in ours + theirs for run in turn)
    questions = {"iteration": lambda run: run["seconds"] / max(1, run["steps"]),
                 "total": lambda run: run["seconds"],
                 "to 1 %": lambda run: seconds_to(run, 1.01 * best),
                 "to 0.1 %": lambda run: seconds_to(run, 1.001 * best)}
    if theirs:
        reached = statistics.median(run["final_cost"] for turn in theirs for run in turn)
        questions["to the peer's cost"] = lambda run: seconds_to(run, reached * (1 + 1e-6))
    rows = []
    for question, answer in questions.items():
        ours_ms, peer_ms = milliseconds(ours, answer), milliseconds(theirs, answer)
        rows.append({"problem": f"{name} {question}", "threads": threads, "ours_ms": ours_ms, "peer": peer,
                     "peer_ms": peer_ms, "ratio": peer_ms / ours_ms if ours_ms and peer_ms else None,
                     "ours_cost": median(ours, "final_cost"), "peer_cost": median(theirs, "final_cost"),
                     "ours_peak_mb": median(ours, "peak_mb"), "peer_peak_mb": median(theirs, "peak_mb")})
    return rows


def milliseconds(turns: list, answer):
    """The median over the turns of the median within each; None if a run had no answer, or there was none."""
    values = [[answer(run) for run in turn] for turn in turns]
    if not values or any(value is None for turn in values for value in turn):
        return None
    return 1e3 * statistics.median(statistics.median(turn) for turn in values)


def median(turns: list, key: str):
    return statistics.median(run[key] for turn in turns for run in turn) if turns else None


def traces_of(name: str, threads: int, ours: list, theirs: list) -> list:
    """The iterations of each side's last run."""
    return [[name, threads, side, seconds, cost] for side, turns in (("ours", ours), ("Ceres", theirs)) if turns
            for seconds, cost in turns[-1][-1]["trace"]]


def write(path: Path, head, rows) -> None:
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(head)
        writer.writerows([["nan" if cell is None else cell for cell in row] for row in rows])


def table(rows: list) -> str:
    def cell(value, form):
        return "–" if value is None else format(value, form)
    lines = [f"{'problem':<42} threads {'ours ms':>10} {'Ceres ms':>10} {'ratio':>7} {'ours cost':>14} {'Ceres cost':>14}"
             f" {'ours MB':>8} {'Ceres MB':>8}"]
    for row in rows:
        lines.append(f"{row['problem']:<42} {row['threads']:>7} {row['ours_ms'] and format(row['ours_ms'], '.3f') or '–':>10}"
                     f" {cell(row['peer_ms'], '.3f'):>10} {cell(row['ratio'], '.2f'):>7} {row['ours_cost']:>14.7g}"
                     f" {cell(row['peer_cost'], '.7g'):>14} {row['ours_peak_mb']:>8.1f} {cell(row['peer_peak_mb'], '.1f'):>8}")
    return "\n".join(lines)
