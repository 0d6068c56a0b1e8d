"""./course run --mine and ./course fly: the student's functions at work on the chapter's problems, beside the solution's.

DIR/mine/EXPERIMENT/own and …/solution hold the tables of both; DIR/mine/runs.json what became of each file and run. From
these figures/mine.py makes the page, and says in the terminal what differs.
"""

import json
import os
import re
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from ch5_backend.figures.numbers.mine import EXPERIMENTS, FLIGHTS

from ..base import jsonout
from ..base.cmake_build import BIN, BUILD, CORES, build_or_fail
from ..base.errors import CourseError
from ..base.language import LANGUAGES, sentence, speaker
from ..base.output_dir import locked_dir
from ..base.processes import running
from ..base.progress import Progress
from ..homework import blanks
from ..homework.check import folder
from ..homework.compiler import does_not_compile
from ..homework.diagnosis import in_short
from ..homework.make_skeleton import skeleton
from ..homework.own_functions import unfinished
from ..homework.regions import FILES, STAGES
from .data import kind_of
from .programs import TRACKER, figures, run_programs, tracking

NEEDS = {"recording": FLIGHTS, "images": FLIGHTS, "bal": ("blocks",)}  # what flies, or adjusts, the data that is given
SOLUTION, OWN = "ch5_homework", os.environ.get("CH5_CHECK_PREFIX", "") + "ch5_homework_mine"
TIME_LIMIT, SLOWER = 20.0, 10.0  # seconds, and so many times what the solution takes


def fly(arguments, only_flights: bool) -> int:
    """Runs the experiments, those of the data alone where some is given; 0 if every one ran, whatever the numbers are."""
    data = arguments.data[0] if arguments.data else ""
    if len(arguments.data) > 1:
        raise CourseError(sentence("fly.one_data"))
    kind = kind_of(data) if data else ""
    if data and kind not in NEEDS:
        raise CourseError(sentence("fly.no_such_data", path=data))
    chosen = NEEDS[kind] if data else FLIGHTS if only_flights else tuple(EXPERIMENTS)
    require_own(chosen)
    out = Path(arguments.out or "out")
    with locked_dir(out):
        files = compile_files()
        if kind == "images":
            build_or_fail([TRACKER])
            run_programs([tracking(data, out / "mine" / "recording", arguments)], arguments.json)
            data = str(out / "mine" / "recording")
        runs = {"files": files, "experiments": run_all(chosen, out / "mine", data)}
        (out / "mine" / "runs.json").write_text(json.dumps(runs, ensure_ascii=False), encoding="utf-8")
        run_programs([figures("mine", out, "--language", arguments.language)], arguments.json)
    if arguments.json:
        jsonout.emit({"out": str(out), "report": str(out / "mine.html"), "failures": runs["experiments"]})
    return 0


# ---- The two programs -----------------------------------------------------------------------------------------------

def require_own(chosen) -> None:
    """Raises CourseError where a file is missing, or none of the student's functions would run."""
    for file in FILES:
        if not (folder() / file).exists():
            raise CourseError(sentence("compiler.file_missing", file=file, command=f"./course reset {file}"))
    stages = [stage for stage in STAGES if any(stage["id"] in EXPERIMENTS[experiment] for experiment in chosen)]
    if not any(todo in own_todos(stage["file"]) for stage in stages for todo in stage["todos"]):
        raise CourseError(sentence("fly.nothing_yet", files=", ".join(dict.fromkeys(stage["file"] for stage in stages)),
                                   command=f"./course check {stages[0]['id']}"), exit_code=1)


def own_todos(file: str) -> list:
    """The TODOs of the functions in which no blank is left."""
    empty = unfinished((folder() / file).read_text(encoding="utf-8", errors="replace"))
    return [todo for function, todos in unfinished(skeleton(file)).items() if function not in empty for todo in todos]


def compile_files() -> dict:
    """Builds both programs; {file: {"errors": {language: sentence}, or none, "unfinished": {function: TODOs}, "own": TODOs}}."""
    build_or_fail([SOLUTION, OWN])
    return {file: report_of(file) for file in FILES}


def report_of(file: str) -> dict:
    """What own_functions.py has told of a file, with a compiler's errors in the readers' words."""
    told = json.loads((BUILD / f"{OWN}.{Path(file).stem}.json").read_text(encoding="utf-8"))
    told["own"] = [] if told["errors"] else own_todos(file)
    if told["errors"]:
        verdict = does_not_compile(file, told["errors"], blanks.content_of(folder() / file))
        told["errors"] = {language: in_short(verdict.diagnosis, speaker(language)) for language in LANGUAGES}
    return told


# ---- The runs -------------------------------------------------------------------------------------------------------

def run_all(chosen, place: Path, data: str) -> dict:
    """{experiment: what the student's program said when it failed, or ""}, a processor for each experiment."""
    said = {}
    with Progress("fly") as progress, ThreadPoolExecutor(CORES) as pool:
        for experiment, message in zip(chosen, pool.map(lambda name: run_both(name, place / name, data), chosen)):
            said[experiment] = message
            progress.step(f"[{len(said)}/{len(chosen)}] {experiment}")
    return said


def run_both(experiment: str, place: Path, data: str) -> str:
    start = time.monotonic()
    if message := run_one(SOLUTION, experiment, place / "solution", data, None):
        raise CourseError(message)
    return run_one(OWN, experiment, place / "own", data, TIME_LIMIT + SLOWER * (time.monotonic() - start))


def run_one(program: str, experiment: str, place: Path, data: str, limit) -> str:
    """What the program said last if it failed, else nothing. Tables of an earlier run are removed first."""
    place.mkdir(parents=True, exist_ok=True)
    for table in place.glob("*.csv"):
        table.unlink()
    command = [str(BIN / program), experiment, "--out", str(place), *(["--data", data] if data else [])]
    with running(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace") as process:
        try:
            printed = process.communicate(timeout=limit)[1]
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            return f"stopped after {limit:.0f} s"
    if not process.returncode:
        return ""
    last = [f"signal {-process.returncode}", *printed.strip().splitlines()][-1]
    assertion = re.search(r"Assertion [`'].*' failed", last)  # without the names of Eigen's types
    return assertion[0] if assertion else last.removeprefix(f"{SOLUTION}: ")
