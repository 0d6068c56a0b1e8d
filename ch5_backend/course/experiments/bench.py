"""./course bench: our solvers and Ceres on the same problems, side by side."""

import json
import os
import statistics
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

from ch5_backend.figures import tables

from ..base import jsonout
from ..base.cmake_build import BIN, build_or_fail, data_folder
from ..base.processes import running
from ..base.errors import CourseError, warn
from ..base.progress import Progress
from ..base.output_dir import locked_dir
from .programs import app

# name: what the programs read ("scene:", "city:", or a file below the data folder), and runs inside of one process: a short one
# needs several, of which the first warms up.
PROBLEMS = {
    **{f"scene/{size}": (f"scene:{size}", repeat) for size, repeat in
       (("3x20", 6), ("10x200", 6), ("30x200", 4), ("30x1000", 2), ("30x4000", 2))},
    **{f"window/{name}": (f"windows/{name}.txt", 6)
       for name in ("vio_S", "vio_M", "vio_L", "vio_Md", "real_euroc_sub2", "mono_10_500", "mono_20_1500")},
    **{f"pose_graph/{name}": (f"posegraph/{name}.g2o", 1) for name in ("intel", "parking-garage", "sphere2500")},
    "bal/49-7776": ("bal/problem-49-7776-pre.txt", 1),
    "bal/16-22106": ("bal/problem-16-22106-pre.txt", 1),
    "bal/maplab-969-22767": ("bal/maplab-969-22767.txt", 1),
    **{f"city/{cameras}": (f"city:{cameras}", 1) for cameras in (100, 1000, 10000)},
    **{f"marginalize/{name}": (f"marginalize:windows/{name}.txt", 6)
       for name in ("vio_S", "vio_M", "vio_L", "vio_Md", "real_euroc_sub2")},
    **{f"covariance/{name}": (f"covariance:windows/{name}.txt", 6) for name in ("vio_M", "vio_L")},
    **{f"odometry/{policy}": (f"odometry:{policy}", 1) for policy in ("vins", "okvis")},
}
TASKS = ("marginalize/", "covariance/")  # no solves: one time, and the trace of JᵀJ or Σ in place of a cost
ODOMETRY = "odometry/"   # an estimator on a simulated flight, 200 tracks an image at 20 Hz: an answer is one image
IMAGE_MS, RECORDING = 50.0, "the recording"  # its peer: a ratio says how many times faster than the recording
VINS = "VINS-Mono's way"                 # the peer where Ceres has nothing to offer
TWO_THREADS = ("scene/30x1000", "scene/30x4000", "bal/")  # also measured with two threads, ours against Ceres with the number that serves it better
ROUNDS, QUICK_ROUNDS = 5, 3
LONG = ("city/1000", "city/10000")  # one round, and none if it is to be quick
QUICK_SECONDS = 85.0     # what would end later is not begun, or stopped; the plots want some too
FIELDS = ("problem", "threads", "ours_ms", "peer", "peer_ms", "ratio", "ours_cost", "peer_cost", "ours_peak_mb",
          "peer_peak_mb", "ours_bytes", "peer_bytes")  # the last two: what the solver adds to the problem, an observation


@dataclass
class Case:
    """One problem with one number of threads. A turn, the runs of one process, is a list; each side has one a round."""
    name: str
    source: str
    threads: int
    ours: list = field(default_factory=list)
    theirs: list = field(default_factory=list)
    peer_threads: tuple = ()  # those yet to be tried; then the faster one
    seconds: float = 0.0      # that the last round took


def bench(arguments) -> int:
    """Returns the exit code; raises CourseError for a name that no problem has, or a program that failed."""
    names = chosen(arguments.names)
    out = Path(arguments.out or "out") / "bench"
    with locked_dir(out):
        build_or_fail(["bench_programs"])
        peer = "Ceres" if (BIN / "measure_ceres").exists() else None
        if peer is None:
            warn("Ceres is not installed (Debian: libceres-dev): our times stand alone")
        measured = run_rounds(cases_of(names, arguments.quick), peer, arguments.quick)
        rows = [row for case in measured for row in rows_of(case.name, case.threads, case.ours, peer, case.theirs)]
        traces = [row for case in measured for row in traces_of(case)]
        tables.write(out / "rows.csv", FIELDS, [[row[field] for field in FIELDS] for row in rows])
        tables.write(out / "traces.csv", ("problem", "threads", "side", "seconds", "cost"), traces)
        if traces:
            app([sys.executable, "-m", "ch5_backend.figures.bench", out], arguments.json)
    if arguments.json:
        jsonout.emit({"rows": rows})
    else:
        print(table(rows) + f"\nThe tables and plots: {out}")
    return 0


def chosen(names) -> list:
    """The problems whose name contains one of `names`; all without names."""
    for name in names:
        if not any(name in problem for problem in PROBLEMS):
            raise CourseError(f"no problem is called '{name}'; there are {', '.join(PROBLEMS)}")
    return [problem for problem in PROBLEMS if not names or any(name in problem for name in names)]


def cases_of(names: list, quick: bool) -> list:
    """What can be measured; says which problems have no file, and raises CourseError if none has."""
    sources = {name: source(name) for name in names}
    missing = [name for name in names if sources[name] is None]
    if len(missing) == len(names):
        raise CourseError(f"nothing to measure: {', '.join(names)} are read from {data_folder()}, where no such file is; "
                          "set CH5_DATA_DIR")
    if missing:
        warn(f"left out, for want of their files in {data_folder()}: {', '.join(missing)}")
    return [Case(name, sources[name], threads, peer_threads=tuple(range(1, threads + 1)))
            for name in names if sources[name] and not (quick and name in LONG) for threads in (1, 2)
            if threads == 1 or (name.startswith(TWO_THREADS) and not quick)]


def source(name: str):
    """What the programs read, or None if the file is not there."""
    task, file = PROBLEMS[name][0].rpartition(":")[::2]
    if task in ("scene", "city", "odometry"):
        return PROBLEMS[name][0]
    return (f"{task}:" if task else "") + str(data_folder() / file) if (data_folder() / file).exists() else None


def run_rounds(cases: list, peer, quick: bool) -> list:
    """The cases that were measured. Each round goes through all of them, so that a slow quarter of an hour of the
    machine falls on all alike."""
    start, rounds = time.monotonic(), QUICK_ROUNDS if quick else ROUNDS
    with Progress("bench") as progress:
        for turn in range(1, rounds + 1):
            for case in cases:
                if turn > 1 and case.name in LONG:
                    continue
                left = QUICK_SECONDS - (time.monotonic() - start) if quick else None
                if quick and case.seconds > left:
                    continue
                progress.step(f"round {turn} of {rounds}: {case.name}, {case.threads} thread{'s' * (case.threads > 1)}")
                try:
                    run_turn(case, peer, left)
                except subprocess.TimeoutExpired:
                    case.seconds = float("inf")
    measured = [case for case in cases if case.ours]
    late = [case.name for case in cases if not case.ours]
    if late:
        warn(f"left out, for want of time: {', '.join(late)}; without --quick there is enough")
    if not measured:
        raise CourseError("nothing was measured", 1)
    return measured


def run_turn(case: Case, peer, seconds) -> None:
    """One process of each side, or of Ceres one for each number of threads that is yet to be tried.

    Raises subprocess.TimeoutExpired after `seconds`, with nothing kept.
    """
    start = time.monotonic()

    def run(side: str, threads: int) -> list:
        return run_side(side, case, threads, seconds and max(0.1, seconds - (time.monotonic() - start)))

    ours = run("ours", case.threads)
    if peer and not case.name.startswith(ODOMETRY):
        tried = {threads: run("ceres", threads) for threads in case.peer_threads}
        fastest = min(tried, key=lambda threads: statistics.median(one["seconds"] for one in tried[threads]))
        case.peer_threads = (fastest,)
        case.theirs.append(tried[fastest])
    case.ours.append(ours)
    case.seconds = time.monotonic() - start


def run_side(side: str, case: Case, threads: int, seconds) -> list:
    """The runs of one process, without the first, which warms up, if there are several; of an estimator its images."""
    repeat = PROBLEMS[case.name][1]
    command = [BIN / f"measure_{side}", case.source, "--threads", str(threads), "--repeat", str(repeat)]
    if case.name.startswith(ODOMETRY):
        command = [BIN / "measure_odometry", case.source.rpartition(":")[2], "--repeat", str(repeat)]
    with running(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                 env={**os.environ, "OPENBLAS_NUM_THREADS": "1"}) as process:
        output, errors = process.communicate(timeout=seconds)
    if process.returncode:
        raise CourseError(f"measuring {case.name} failed: {errors.strip()}", 1)
    runs = [json.loads(line) for line in output.splitlines()]
    return runs if case.name.startswith(ODOMETRY) else runs[-max(1, repeat - 1):]


def iteration_seconds(run: dict) -> float:
    """The mean time of an iteration, without the set-up: the first entry of a trace is the start's cost and its time."""
    return (run["seconds"] - run["trace"][0][0]) / max(1, run["steps"])


def seconds_to(run: dict, cost: float):
    """When the run had reached `cost`, or None."""
    return next((seconds for seconds, reached in run["trace"] if reached <= cost), None)


def rows_of(name: str, threads: int, ours: list, peer, theirs: list) -> list:
    """A row for each question that the runs answer; ratio is peer_ms / ours_ms, null where a side has no answer."""
    if name.startswith(ODOMETRY):
        return odometry_rows(name, ours)
    best = min(run["final_cost"] for turn in ours + theirs for run in turn)
    questions = {"iteration": iteration_seconds,
                 "total": lambda run: run["seconds"],
                 "to 1 %": lambda run: seconds_to(run, 1.01 * best),
                 "to 0.1 %": lambda run: seconds_to(run, 1.001 * best)}
    if name.startswith(TASKS):
        questions = {"total": questions["total"]}
        peer = VINS if peer and name.startswith("marginalize/") else peer
    elif theirs:
        reached = statistics.median(run["final_cost"] for turn in theirs for run in turn)
        questions["to the peer's cost"] = lambda run: seconds_to(run, reached * (1 + 1e-6))
    rows = []
    for question, answer in questions.items():
        ours_ms, peer_ms = milliseconds(ours, answer), milliseconds(theirs, answer)
        rows.append({"problem": f"{name} {question}", "threads": threads, "ours_ms": ours_ms, "peer": peer,
                     "peer_ms": peer_ms, "ratio": peer_ms / ours_ms if ours_ms and peer_ms else None,
                     "ours_cost": median(ours, "final_cost"), "peer_cost": median(theirs, "final_cost"),
                     "ours_peak_mb": median(ours, "peak_mb"), "peer_peak_mb": median(theirs, "peak_mb"),
                     "ours_bytes": bytes_per_observation(ours), "peer_bytes": bytes_per_observation(theirs)})
    return rows


def odometry_rows(name: str, turns: list) -> list:
    """A row for each question about an image's time."""
    questions = {"mean": statistics.mean, "median": statistics.median,
                 "99th percentile": lambda seconds: statistics.quantiles(seconds, n=100)[-1]}
    rows = []
    for question, answer in questions.items():
        ours_ms = 1e3 * statistics.median(answer([image["seconds"] for image in turn]) for turn in turns)
        rows.append({**dict.fromkeys(FIELDS), "problem": f"{name} {question}", "threads": 1, "ours_ms": ours_ms,
                     "peer": RECORDING, "peer_ms": IMAGE_MS, "ratio": IMAGE_MS / ours_ms})
    return rows


def milliseconds(turns: list, answer):
    """The median over the turns of the median within each; None if a run had no answer, or there was none."""
    values = [[answer(run) for run in turn] for turn in turns]
    if not values or any(value is None for turn in values for value in turn):
        return None
    return 1e3 * statistics.median(statistics.median(turn) for turn in values)


def median(turns: list, key: str):
    return statistics.median(run[key] for turn in turns for run in turn) if turns else None


def bytes_per_observation(turns: list):
    """What the solver held at its peak beside the problem itself; None without observations. Of each process the first
    run: later ones find memory that it has left."""
    values = [turn[0]["solver_bytes"] / turn[0]["observations"] for turn in turns if turn[0].get("observations")]
    return statistics.median(values) if values else None


def traces_of(case: Case) -> list:
    """The iterations of each side's last run."""
    return [[case.name, case.threads, side, seconds, cost] for side, turns in (("ours", case.ours), ("Ceres", case.theirs))
            if turns and not case.name.startswith((*TASKS, ODOMETRY)) for seconds, cost in turns[-1][-1]["trace"]]


def table(rows: list) -> str:
    def cell(value, width, form):
        return format("–" if value is None else format(value, form), f">{width}")
    lines = [f"{'problem':<42} threads {'ours ms':>10} {'peer ms':>10} {'ratio':>7} {'ours cost':>14} {'peer cost':>14}"
             f" {'ours MB':>8} {'peer MB':>8} {'ours B/obs':>10} {'peer B/obs':>10}"]
    for row in rows:
        cells = [cell(row[key], width, form) for key, width, form in (
            ("threads", 7, "d"), ("ours_ms", 10, ".3f"), ("peer_ms", 10, ".3f"), ("ratio", 7, ".2f"),
            ("ours_cost", 14, ".7g"), ("peer_cost", 14, ".7g"), ("ours_peak_mb", 8, ".1f"), ("peer_peak_mb", 8, ".1f"),
            ("ours_bytes", 10, ".0f"), ("peer_bytes", 10, ".0f"))]
        lines.append(" ".join([f"{row['problem']:<42}", *cells]))
    return "\n".join(lines)
