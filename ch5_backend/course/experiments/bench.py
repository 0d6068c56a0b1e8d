"""./course bench: our solvers and Ceres on the same problems, side by side."""

import json
import math
import os
import platform
import re
import shutil
import statistics
import subprocess
import sys
import time
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path

from ch5_backend.figures import tables
from ch5_backend.figures.numbers.peers import BEST, LDLT, QUESTIONS, SAME, VINS, kinds_of

from ..base import jsonout
from ..base.cmake_build import BIN, build_or_fail, data_folder
from ..base.processes import running
from ..base.errors import CourseError, warn
from ..base.language import aligned
from ..base.progress import Progress
from ..base.output_dir import locked_dir
from .programs import figures, run_programs

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
    **{f"city/{cameras}": (f"city:{cameras}", 1) for cameras in (100, 300, 1000, 10000)},
    **{f"marginalize/{name}": (f"marginalize:windows/{name}.txt", 6)
       for name in ("vio_S", "vio_M", "vio_L", "vio_Md", "real_euroc_sub2")},
    **{f"covariance/{name}": (f"covariance:windows/{name}.txt", 6) for name in ("vio_M", "vio_L")},
    **{f"odometry/{policy}_{tracks}": (f"odometry:{policy}:{tracks}", 1) for policy in ("vins", "okvis") for tracks in (200, 1000)},
}
TASKS = ("marginalize/", "covariance/")  # no solves: one time, and the trace of JᵀJ or Σ in place of a cost
ODOMETRY = "odometry/"   # an estimator on a simulated flight at 20 Hz, so many tracks an image: an answer is one image
IMAGE_MS, RECORDING = 50.0, "the recording"  # its peer: a ratio says how many times faster than the recording
MARGINALIZERS = {"": VINS, "ldlt": LDLT}  # {way: peer}, where Ceres has nothing to offer
TWO_THREADS = ("scene/30x1000", "scene/30x4000", "bal/")  # also measured with two threads, by the clock

# Ceres at its best: what serves it best by a row's own measure. All these ways are tried in the first round, then those that
# were best at something. The first one is the same problem for both sides.
UNASKED = ""  # the way of ours at its best
PLAIN = "lm,xyz,radius=1e4,whole"
RAYS = "lm,ray,radius=3.3e5", "lm,ray,radius=3.3e4"  # points on rays; the first radius is 1/λ₀ of ours unasked
WAYS = {
    "scene/": ("lm,radius=1e4,whole", "lm,unscaled", "lm,radius=1e8", "lm,inner", "lm,mixed", "dogleg", "dogleg,unscaled"),
    "window/": ("dogleg,radius=1e4,whole", "dogleg,unscaled", "dogleg,radius=1e8", "lm", "lm,unscaled", "lm,radius=1e8", "lm,inner",
                "lm,mixed"),
    "bal/maplab": (PLAIN, "unscaled", "radius=1e8", *RAYS, "sparse", f"sparse,{RAYS[0]}"),
    "bal/": (PLAIN, "unscaled", "radius=1e8", "inner", "mixed", "dogleg", *RAYS, *(f"{way},mixed" for way in RAYS), f"{RAYS[0]},inner"),
    "city/10000": (PLAIN,),
    "city/1000": (PLAIN, *RAYS, "iterative"),
    "city/": (PLAIN, "unscaled", "radius=1e8", "mixed", "sparse", "sparse,eigen", "dogleg", *RAYS, f"{RAYS[0]},inner"),
    "pose_graph/": ("dogleg,radius=1e4", *(",".join(words) for words in product(("dogleg", "lm"), ("scaled", "unscaled"),
                                                                                ("radius=1e4", "radius=1e8"), ("suite", "eigen")))),
    "marginalize/": tuple(MARGINALIZERS), "": (UNASKED,)}
ROUNDS, QUICK_ROUNDS = 5, 3
LONG = ("city/1000", "city/10000")  # one round, and none if it is to be quick
TOUCHED_BYTES = 1 << 31
QUICK_SECONDS = 85.0     # what would end later is not begun, or stopped; the plots want some too
FIELDS = ("problem", "setting", "threads", "ours_ms", "peer", "peer_way", "peer_ms", "ratio", "ours_cost", "peer_cost", "ours_peak_mb",
          "peer_peak_mb", "ours_bytes", "peer_bytes")  # the last two: what the solver adds to the problem, an observation


@dataclass
class Case:
    """One problem with one number of threads. A turn, the runs of one process, is a list; each way of a side has one a round."""
    name: str
    source: str
    threads: int
    ours: dict = field(default_factory=dict)    # {way: turns}
    theirs: dict = field(default_factory=dict)
    ways: tuple = ()        # of the peer, yet to be tried; then those that were best at something
    alone: object = None    # with two threads: the same case with one, whose best ways are tried with both numbers
    seconds: float = 0.0    # that the last round took

    @property
    def same_way(self) -> str:
        return ways_of(self.name)[0]


def ways_of(name: str) -> tuple:
    return next(ways for prefix, ways in WAYS.items() if name.startswith(prefix))


def bench(arguments) -> int:
    """Returns the exit code; raises CourseError for a name that no problem has, or a program that failed."""
    names = chosen(arguments.names)
    out = Path(arguments.out or "out") / "bench"
    with locked_dir(out):
        build_or_fail(["bench_programs"])
        peer = "Ceres" if (BIN / "measure_ceres").exists() else None
        if peer is None:
            warn("Ceres is not installed (Debian: libceres-dev): only our times are measured")
        if not arguments.quick:
            touch_memory()
        measured = run_rounds(cases_of(names, arguments.quick), peer, arguments.quick)
        rows = [row for case in measured for row in rows_of(case, peer)]
        traces = [row for case in measured for row in traces_of(case)]
        tables.write(out / "rows.csv", FIELDS, [[row[field] for field in FIELDS] for row in rows])
        tables.write(out / "traces.csv", ("problem", "threads", "side", "seconds", "cost"), traces)
        about = conditions(measured)
        tables.write(out / "about.csv", tuple(about), [tuple(about.values())])
        if traces:
            run_programs([figures("bench", out)], arguments.json)
    if arguments.json:
        jsonout.emit({"rows": rows})
    else:
        columns = shutil.get_terminal_size().columns if sys.stdout.isatty() else math.inf
        print(f"{table(rows, columns)}\n{kinds_table(rows, columns)}\n" + ", ".join(f"{key}: {value}" for key, value in about.items())
              + f"\nThe tables and plots: {out}")
    return 0


def conditions(measured: list) -> dict:
    """On what, when and with which BLAS; warns of a slow one."""
    blas = sorted({run["blas"] for case in measured for turns in case.theirs.values() for turn in turns for run in turn if run.get("blas")})
    if any("openblas" not in file for file in blas):
        warn(f"Ceres calls {', '.join(blas)}; OpenBLAS (Debian: libopenblas0-pthread) is faster")
    rounds = max(len(turns) for case in measured for turns in case.ours.values())
    return {"processor": processor(), "cores": os.cpu_count(), "date": time.strftime("%Y-%m-%d"), "rounds": rounds,
            "load": f"{os.getloadavg()[0]:.1f}", "blas": " ".join(blas)}


def processor() -> str:
    """The model's name, which some machines do not tell apart, with family and model."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor()
    found = {key: value for key, value in re.findall(r"^(model name|cpu family|model)\s*: (.*)$", text, re.M)}
    numbers = f" (family {found['cpu family']} model {found['model']})" if {"cpu family", "model"} <= found.keys() else ""
    return found.get("model name", platform.processor()).replace(",", " ").strip() + numbers


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
        warn(f"left out, because their files are not in {data_folder()}: {', '.join(missing)}")
    cases = []
    for name in names:
        if not sources[name] or (quick and name in LONG):
            continue
        cases.append(Case(name, sources[name], 1, ways=ways_of(name)))
        if name.startswith(TWO_THREADS) and not quick:
            cases.append(Case(name, sources[name], 2, alone=cases[-1]))
    return cases


def source(name: str):
    """What the programs read, or None if the file is not there."""
    task, _, file = PROBLEMS[name][0].partition(":") if ":" in PROBLEMS[name][0] else ("", "", PROBLEMS[name][0])
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
        warn(f"left out, because time ran out: {', '.join(late)}; without --quick there is enough")
    if not measured:
        raise CourseError("nothing was measured", 1)
    return measured


def touch_memory() -> None:
    """Has the host give its memory to a virtual machine, which is 12 µs a page and no solver's time, before anything is timed."""
    with Progress("bench") as progress:
        progress.step("touch memory")
        spare = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2
        _ = b"\1" * min(spare, TOUCHED_BYTES)


def run_turn(case: Case, peer, seconds) -> None:
    """One process of each side for each way of it that is still of interest.

    Raises subprocess.TimeoutExpired after `seconds`, with nothing kept.
    """
    start = time.monotonic()

    def run(side: str, way: str) -> list:
        return run_side(side, case, way, seconds and max(0.1, seconds - (time.monotonic() - start)))

    is_solve = not case.name.startswith((*TASKS, ODOMETRY))
    if case.alone and not case.ways:
        case.ways = tuple(way + more for way in case.alone.ways for more in ("", ",threads=1"))
    ours = {way: run("ours", way) for way in ((UNASKED, case.same_way) if is_solve else (UNASKED,))}
    theirs = {way: run("ceres", way) for way in case.ways} if peer and not case.name.startswith(ODOMETRY) else {}
    for kept, new in ((case.ours, ours), (case.theirs, theirs)):
        for way, turn in new.items():
            kept.setdefault(way, []).append(turn)
    if theirs and is_solve:
        best = {way for answers in answers_of(case, BEST).values() for way in answers if way is not None}
        case.ways = tuple(way for way in case.ways if way in best or way == case.same_way)
    case.seconds = time.monotonic() - start


def run_side(side: str, case: Case, way: str, seconds=None) -> list:
    """The runs of one process, without the first, which warms up, if there are several; of an estimator its images."""
    repeat = PROBLEMS[case.name][1]
    command = [BIN / f"measure_{side}", case.source, "--threads", str(case.threads), "--repeat", str(repeat)]
    if way:
        command += ["--way", way]
    if case.threads > 1:
        command += ["--wall"]  # the processor's time would be the threads' sum
    if case.name.startswith(ODOMETRY):
        policy, tracks = case.source.split(":")[1:]
        command = [BIN / "measure_odometry", policy, "--tracks", tracks, "--repeat", str(repeat)]
    with running(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                 env={**os.environ, "OPENBLAS_NUM_THREADS": "1"}) as process:
        output, errors = process.communicate(timeout=seconds)
    if process.returncode:
        raise CourseError(f"measuring {case.name} {way} failed: {errors.strip()}", 1)
    runs = [json.loads(line) for line in output.splitlines()]
    return runs if case.name.startswith(ODOMETRY) else runs[-max(1, repeat - 1):]


def iteration_seconds(run: dict) -> float:
    """The mean time of a trial, without the set-up: the first entry of a trace is the start's cost and its time."""
    return (run["seconds"] - run["trace"][0][0]) / max(1, run["trials"])


def seconds_to(run: dict, cost: float):
    """When the run had reached `cost`, or None."""
    return next((seconds for seconds, reached in run["trace"] if reached <= cost), None)


def answer(question: str, run: dict, least: float, peers: float):
    """Seconds, or None where the run has no answer. `least` is the least cost of all, `peers` the peer's."""
    return {"iteration": lambda: iteration_seconds(run), "total": lambda: run["seconds"],
            "to 1 %": lambda: seconds_to(run, 1.01 * least), "to 0.1 %": lambda: seconds_to(run, 1.001 * least),
            "to the peer's cost": lambda: seconds_to(run, peers * (1 + 1e-6))}[question]()


def answers_of(case: Case, setting: str) -> dict:
    """{question: {way of the peer, None for ours: milliseconds, one a round}}; of the peer its best way by this question, if
    any has an answer. A total counts where the run ended as near the least cost as any of the peer's did."""
    ours = case.ours[case.same_way if setting == SAME else UNASKED]
    rounds = max((len(turns) for turns in case.theirs.values()), default=0)
    theirs = {way: turns for way, turns in case.theirs.items()
              if len(turns) == rounds and (setting == BEST or way == case.same_way)}
    ends = {way: median(turns, "final_cost") for way, turns in theirs.items()}
    least = min([median(ours, "final_cost"), *ends.values()])
    good = list(theirs)
    for cost in (math.inf, 1.001 * min(ends.values(), default=0.0), 1.01 * least, 1.001 * least):
        good = [way for way in good if ends[way] <= cost] or good
    quickest = min(good, key=lambda way: statistics.median(milliseconds(theirs[way], "total")), default=None)
    found = {}
    for question in QUESTIONS if theirs else QUESTIONS[:-1]:
        told = least, ends.get(quickest)
        times = {way: milliseconds(turns, question, *told) for way, turns in theirs.items()}
        times = {way: values for way, values in times.items() if values and (question != "total" or way in good)}
        best = min(times, key=lambda way: statistics.median(times[way]), default=None)
        found[question] = {None: milliseconds(ours, question, *told), **({best: times[best]} if times else {})}
    return found


def milliseconds(turns: list, question: str, least=math.inf, peers=math.inf):
    """Of each turn the median; None if a run had no answer, or there was none."""
    values = [[answer(question, run, least, peers) for run in turn] for turn in turns]
    if not values or any(value is None for turn in values for value in turn):
        return None
    return [1e3 * statistics.median(turn) for turn in values]


def rows_of(case: Case, peer) -> list:
    """A row for each question that the runs answer, in each setting; raises CourseError if one cannot be."""
    if case.name.startswith(ODOMETRY):
        return odometry_rows(case.name, case.ours[UNASKED])
    if case.name.startswith(TASKS):
        marginalizes = case.name.startswith("marginalize/")
        return [row_of(case, "total", None, MARGINALIZERS[way] if peer and marginalizes else peer, case.ours[UNASKED],
                       milliseconds(case.ours[UNASKED], "total"), way, turns, milliseconds(turns, "total"))
                for way, turns in (case.theirs or {UNASKED: []}).items()]
    rows = []
    for setting in (SAME, BEST):
        ours = case.ours[case.same_way if setting == SAME else UNASKED]
        for question, answers in answers_of(case, setting).items():
            way = next((way for way in answers if way is not None), None)
            rows.append(row_of(case, question, setting, peer, ours, answers[None], way, case.theirs.get(way, []), answers.get(way)
                               if way is not None else None))
    check_order(rows)
    return rows


def row_of(case, question, setting, peer, ours, ours_ms, way, theirs, peer_ms) -> dict:
    """Times are medians over the rounds, the ratio the median of the rounds' ratios, each of two neighbors in time."""
    paired = [b / a for a, b in zip(ours_ms, peer_ms)] if ours_ms and peer_ms else None
    return {"problem": f"{case.name} {question}", "setting": setting, "threads": case.threads,
            "ours_ms": ours_ms and statistics.median(ours_ms), "peer": peer, "peer_way": way,
            "peer_ms": peer_ms and statistics.median(peer_ms), "ratio": paired and statistics.median(paired),
            "ours_cost": median(ours, "final_cost"), "peer_cost": median(theirs, "final_cost"),
            "ours_peak_mb": median(ours, "peak_mb"), "peer_peak_mb": median(theirs, "peak_mb"),
            "ours_bytes": bytes_per_observation(ours), "peer_bytes": bytes_per_observation(theirs)}


def check_order(rows: list) -> None:
    """Raises CourseError if a side arrives somewhere after its own end, as it would if a part of its time counted twice."""
    for setting in {row["setting"] for row in rows}:
        here = {row["problem"].split(" ", 1)[1]: row for row in rows if row["setting"] == setting}
        for question, row in here.items():
            for side in ("ours_ms", "peer_ms"):
                end = here["total"][side]
                if question.startswith("to ") and row[side] is not None and end is not None and row[side] > end:
                    raise CourseError(f"'{row['problem']}', {setting}: {side} is {row[side]:.6g}, after the total of {end:.6g}; "
                                      "some time is counted twice", 1)


def odometry_rows(name: str, turns: list) -> list:
    """A row for each question about an image's time."""
    questions = {"mean": statistics.mean, "median": statistics.median,
                 "99th percentile": lambda seconds: statistics.quantiles(seconds, n=100)[-1], "worst": max}
    rows = []
    for question, of in questions.items():
        ours_ms = 1e3 * statistics.median(of([image["seconds"] for image in turn]) for turn in turns)
        rows.append({**dict.fromkeys(FIELDS), "problem": f"{name} {question}", "threads": 1, "ours_ms": ours_ms,
                     "peer": RECORDING, "peer_ms": IMAGE_MS, "ratio": IMAGE_MS / ours_ms})
    return rows


def median(turns: list, key: str):
    return statistics.median(run[key] for turn in turns for run in turn) if turns else None


def bytes_per_observation(turns: list):
    """What the solver held at its peak beside the problem itself; None without observations. Of each process the first
    run: later ones find memory that it has left."""
    values = [turn[0]["solver_bytes"] / turn[0]["observations"] for turn in turns if turn[0].get("observations")]
    return statistics.median(values) if values else None


def traces_of(case: Case) -> list:
    """The iterations of each side's last run: of ours unasked, of the peer's quickest way to 0.1 %."""
    if case.name.startswith((*TASKS, ODOMETRY)):
        return []
    best = next((way for way in answers_of(case, BEST)["to 0.1 %"] if way is not None), case.same_way)
    return [[case.name, case.threads, side, seconds, cost]
            for side, turns in (("ours", case.ours[UNASKED]), ("Ceres", case.theirs.get(best)))
            if turns for seconds, cost in turns[-1][-1]["trace"]]


def kinds_table(rows: list, columns: float = math.inf) -> str:
    return aligned([("times as fast, one thread", "mean", "least", "most", "problems"), *(
        (f"{kind}, {setting}, {question}", *(f"{value:.2f}" for value in (mean, least, most)), f"{there} of {every}")
        for kind, setting, question, mean, least, most, there, every in kinds_of(rows))], columns)


def table(rows: list, columns: float = math.inf) -> str:
    shown = (("ratio", "ratio", ".2f"), ("ours_ms", "ours ms", ".3f"), ("peer_ms", "peer ms", ".3f"), ("threads", "threads", "d"),
             ("setting", "setting", ""), ("ours_cost", "ours cost", ".7g"), ("peer_cost", "peer cost", ".7g"),
             ("ours_peak_mb", "ours MB", ".1f"), ("peer_peak_mb", "peer MB", ".1f"), ("ours_bytes", "ours B/obs", ".0f"),
             ("peer_bytes", "peer B/obs", ".0f"))
    return aligned([("problem", *(name for _, name, _ in shown), "peer"), *(
        (row["problem"], *("–" if row[key] is None else format(row[key], form) for key, _, form in shown),
         " ".join(filter(None, (row["peer"], row["peer_way"])))) for row in rows)], columns)
