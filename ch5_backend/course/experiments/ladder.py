"""./course ladder: the student's stage 7, optimized as the library is, beside the solution's, the other solvers and Ceres; and which
rungs it has reached, small changes of lecture 5's kind, each with what it gains where it was measured (measure_ladder.py)."""

import csv
import math
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

from ch5_backend.figures import tables
from ch5_backend.figures.numbers.windows import KEPT

from ..base import jsonout
from ..base.cmake_build import BIN, build_or_fail
from ..base.errors import CourseError, warn
from ..base.language import aligned, fitted, sentence, speaker
from ..base.progress import Progress
from ..homework.check import judge_stages, select
from .bench import Case, iteration_seconds, processor, run_side, ways_of
from .programs import check_exit

PROBLEM, ROUNDS = "scene/30x1000", 5
SOURCE = PROBLEM.replace("/", ":")
OWN = os.environ.get("CH5_CHECK_PREFIX", "") + "measure_steps_mine"
SOLVERS = {"ladder.dense": ("measure_steps", "dense"), "ladder.solution": ("measure_steps", "plain"), "ladder.yours": (OWN, "plain"),
           "ladder.sparse": ("measure_steps", "sparse")}
PEER = "Ceres"
COLUMNS = {"linearize": "ladder.linearize", "solve": "ladder.solve", "iteration": "ladder.iteration"}
RUNGS = ("ladder.looked_up_once", "ladder.no_temporaries", "ladder.sizes_known", "ladder.linearized_so_too")
NOISE = 0.95  # of a rung's gain counts as the rung
BOARD = ("name", "times", "processor", "date")


def ladder(arguments) -> int:
    """Returns the exit code; raises CourseError while stage 7 is not right: a wrong answer may be as fast as it likes."""
    if arguments.board and not arguments.name:
        raise CourseError(sentence("ladder.no_name"))
    stage, = select(["7"])
    if judge_stages([stage])[0].state != "right":
        raise CourseError(sentence("ladder.not_right", command="./course check 7"), 1)
    build_or_fail(["bench_programs", "measure_steps", OWN])
    times, say = measured(), speaker(arguments.language)
    gain = statistics.median(map(gained, times["ladder.solution"], times["ladder.yours"]))
    steps = rungs(gain)
    if arguments.json:
        jsonout.emit({"times": gain, "processor": processor(), "rungs": steps,
                      "solvers": {name.removeprefix("ladder."): middle(rounds) for name, rounds in times.items()}})
    else:
        print(fitted(page(times, gain, steps, say), sys.stdout))
    if arguments.board:
        shown = board(Path(arguments.board), {"name": arguments.name, "times": f"{gain:.2f}", "processor": processor(), "date": time.strftime("%Y-%m-%d")})
        if not arguments.json:
            print("\n" + shown)
    return 0


def measured() -> dict:
    """{solver: [{step: milliseconds} of each round]}. A round goes through all of them, so that what disturbs falls on all alike."""
    times = {name: [] for name in SOLVERS}
    ceres = Case(PROBLEM, SOURCE, 1) if (BIN / "measure_ceres").exists() else None
    if ceres is None:
        warn(Progress.say("ladder.no_ceres"))
    with Progress("ladder") as progress:
        for turn in range(ROUNDS):
            for name, (program, solver) in SOLVERS.items():
                progress.step(f"[{turn + 1}/{ROUNDS}] {solver}")
                times[name].append(steps_of(program, solver))
            if ceres:
                runs = run_side("ceres", ceres, ways_of(PROBLEM)[0])
                times.setdefault(PEER, []).append({"iteration": 1e3 * statistics.median(map(iteration_seconds, runs))})
    return times


def steps_of(program: str, solver: str) -> dict:
    """{step: milliseconds}, and of a trial that is accepted as a whole."""
    command = [BIN / program, SOURCE, "--solver", solver, "--repeat", "3"]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace")
    check_exit(command, done.returncode, done.stderr.strip())
    steps = {name: float(value) for name, value, *_ in csv.reader(done.stdout.splitlines())}
    solve = sum(value for step, value in steps.items() if step not in ("linearize", "update", "rollback", "cost"))
    return {"linearize": steps["linearize"], "solve": solve, "iteration": steps["linearize"] + solve + steps["update"] + steps["cost"]}


def gained(one: dict, other: dict) -> float:
    return one["iteration"] / other["iteration"]


def middle(rounds: list) -> dict:
    """Of each step the median of the rounds."""
    return {step: statistics.median(turn[step] for turn in rounds) for step in rounds[0]}


def rungs(gain: float) -> list:
    """Each with what it and those below gained where they were measured, and whether the student's solver is there."""
    return [{"rung": int(row["rung"]), "times": float(row["times"]), "reached": bool(gain >= NOISE * row["times"])} for row in KEPT("ladder").rows()]


def page(times: dict, gain: float, steps: list, say) -> str:
    rows = [(name if name == PEER else say(name), *(f"{turn[step]:.2f}" if step in turn else "" for step in COLUMNS),
             f"{statistics.median(map(gained, times['ladder.solution'], times[name])):.2f}") for name in times for turn in [middle(times[name])]]
    head = (say("ladder.solver"), *map(say, COLUMNS.values()), say("ladder.times"))
    about = KEPT("measured", table="ladder").rows()[0]
    told = [f"{'✓' if one['reached'] else '·'} {one['times']:.2f}  {say(RUNGS[one['rung'] - 1])}" for one in steps]
    return "\n".join((say("ladder.head", processor=processor()), "", aligned([head, *rows], math.inf), "",
                      say("ladder.rungs", date=about["date"], processor=about["processor"]), *told, "", say("ladder.yours_are", times=f"{gain:.2f}")))


def board(path: Path, own: dict) -> str:
    """Puts the student's row into the class's file in place of an earlier one; all rows, the fastest first."""
    rows = [own]
    if path.exists():
        try:
            with open(path, newline="", encoding="utf-8-sig") as file:
                others = [{key: row[key] for key in BOARD} for row in csv.DictReader(file)]
            rows = [row for row in sorted([*others, own], key=lambda row: -float(row["times"])) if row is own or row["name"] != own["name"]]
        except (KeyError, TypeError, ValueError) as error:
            raise CourseError(sentence("ladder.no_board", path=str(path), columns=",".join(BOARD))) from error
    tables.write(path, BOARD, [[row[key] for key in BOARD] for row in rows])
    return aligned([BOARD, *(tuple(row.values()) for row in rows)], math.inf)
