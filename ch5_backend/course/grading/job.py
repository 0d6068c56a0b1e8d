"""What of a submission is right: a pure function of its files, the seed and the toolchain. The rubric makes points of it."""

import re
import shutil
import signal
import tempfile
import time
from pathlib import Path

from ..homework.blanks import explain
from ..homework.diagnosis import Verdict, because
from ..homework.judge import judge
from ..base.scratch import scratch
from . import unnamed
from .follow_through import follow_through
from .rubric import mark, marks
from .sandbox import Limits
from .submission import Submission
from .toolchain import Clock, Infrastructure, Toolchain, require_room
from .watch import Watch

SECONDS_A_TEST = 10.0   # the reference needs a tenth of one
SECONDS_A_SUBMISSION = 240.0  # for all its checks; they need 193 where a loop in each stage does not end
PATIENCE = (1, 4)  # times as long a check may take of the wall's clock, where the machine has given it too little of its own
FOLLOWED = ("wrong", "crashes", "not-started")  # what does not end would not end once for each blank
LONGEST_FOLLOWED = 10.0  # seconds of the compiler; the solutions need two
OUT_OF_TIME = "judge.submission_too_long"
RUNNING = Limits(seconds=10, wall_seconds=SECONDS_A_TEST + 5.0)


def grade_file(toolchain: Toolchain, file: str, content: bytes, stages: list, rubric: dict, seed: int, clock: Clock,
               by_blanks: bool = True) -> dict:
    """{"stages": a row for each, "cpu_seconds", "peak_mib", "complete", "solved"}, cpu and peak of the compiler; it is not complete where
    the clock has run out; for the last see likeness.as_solution. Raises Infrastructure."""
    folder, compiled = Path(tempfile.mkdtemp(dir=scratch())), clock.compiler
    try:
        built = toolchain.compile(file, content, folder, clock)
        rows, of_all = [], built.verdict
        for stage in stages:
            begin = time.monotonic()
            verdict = of_all or explain(run_stage(toolchain, built.worker, stage, seed, clock), stage, content)
            if any(re.search("TIMEOUT after .* in its start", str(test.get("failures"))) for test in verdict.tests):
                of_all = verdict._replace(tests=())  # nor will it start for another stage
            row = stage_row(stage, verdict, rubric[stage["id"]], time.monotonic() - begin)
            if verdict.state == "wrong":
                row["lines"] = unnamed.excerpt(stage, content, verdict.diagnosis.get("todo", ""))
            if by_blanks and verdict is not of_all and verdict.state in FOLLOWED and built.cpu_seconds < LONGEST_FOLLOWED:
                row.update(follow_through(stage, content, verdict,
                                          lambda text, stage=stage: judged(toolchain, file, text, stage, seed, clock)))
            rows.append(row)
        known, own = toolchain.solved(file) if built.worker else {}, built.functions
        solved = [None if own is None else [name for name, its in known.items() if own.get(name) == its], len(known)]
        return {"stages": rows, "cpu_seconds": round(compiled - clock.compiler, 2), "peak_mib": round(built.peak_mib), "solved": solved if known else None,
                "complete": min(clock.left, clock.compiler) > 0.0}
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def judged(toolchain: Toolchain, file: str, content: bytes, stage: dict, seed: int, clock: Clock) -> Verdict:
    """The verdict on a mended text, up to the first check that fails."""
    with tempfile.TemporaryDirectory(dir=scratch(), ignore_cleanup_errors=True) as folder:
        built = toolchain.compile(file, content, Path(folder), clock)
        return built.verdict or run_stage(toolchain, built.worker, stage, seed, clock, fail_fast=True)


def run_stage(toolchain: Toolchain, worker: Path, stage: dict, seed, clock: Clock, fail_fast: bool = False) -> Verdict:
    """With the usual random numbers where the seed is None. Raises Infrastructure where a check was not answered because the machine did not let it run."""
    seeds = [] if seed is None else [f"--seed={seed}"]
    for patience in PATIENCE:
        box = toolchain.box(read_only={"/worker": worker}, limits=RUNNING._replace(wall_seconds=patience * RUNNING.wall_seconds))
        with box.watch(str(worker)) as watch:
            verdict = judge(toolchain.judge, stage, patience * max(clock.left, 0.0),
                            [*seeds, f"--time-limit={patience * SECONDS_A_TEST:g}"],
                            box.wrap(["/worker"]), Path("/worker"), fail_fast=fail_fast,
                            words_of=lambda command, box=box: box.run(command).output)  # its debugging lines may be forged, too
        clock.left -= watch.own()
        if clock.left <= 0.0 and not verdict.tests:
            return Verdict("times-out", because(OUT_OF_TIME, n=f"{SECONDS_A_SUBMISSION:g}"))
        if not kept_waiting(verdict, watch):
            break
    else:
        raise Infrastructure(f"the machine was too busy, or stopped: a check of stage {stage['id']} did not get half of the "
                             f"{PATIENCE[-1] * SECONDS_A_TEST:g} s that it had. The same command judges this submission again")
    silent = not verdict.tests or any("START:" in str(test.get("failures")) for test in verdict.tests)
    if silent:  # that may be ours to answer for
        require_room()
        toolchain.box.preflight()
    return out_of_limits(verdict, watch.exceeded)


def kept_waiting(verdict: Verdict, watch: Watch) -> bool:
    """Whether a check has timed out in which more than half of the time was the machine's, not the program's."""
    if not verdict.tests:
        return verdict.state == "times-out" and watch.own() < watch.end / 2
    begin = 0.0
    for test in verdict.tests:
        seconds = float(str(test.get("time", "0")).rstrip("s"))
        if "TIMEOUT" in str(test.get("failures")) and watch.own(begin, begin + seconds) < seconds / 2:
            return True
        begin += seconds
    return False


def out_of_limits(verdict: Verdict, exceeded: str) -> Verdict:
    """What the processor's limit has ended does not end by itself, which is how a student reads it."""
    cause = verdict.diagnosis.get("cause") or {}
    ended_by = str(cause.get("signal", "")) if verdict.state == "crashes" else ""
    if exceeded == "memory" and signal.strsignal(signal.SIGKILL) in ended_by:
        return verdict._replace(diagnosis={**verdict.diagnosis, **because("judge.takes_too_much", n=RUNNING.memory >> 30, where=cause.get("where", ""))})
    if signal.strsignal(signal.SIGXCPU) not in ended_by and (exceeded != "seconds" or signal.strsignal(signal.SIGKILL) not in ended_by):
        return verdict
    return verdict._replace(state="times-out", diagnosis={**verdict.diagnosis, **because(
        "judge.does_not_end", n=f"{RUNNING.seconds:g}", where=cause.get("where", ""))})


def stage_row(stage: dict, verdict: Verdict, checks: dict, seconds: float) -> dict:
    passed = {test["name"] for test in verdict.tests if test.get("result") == "COMPLETED" and not test.get("failures")}
    rows = marks(checks, passed)
    failed = next((test for test in verdict.tests if test.get("failures")), {})
    return {"id": stage["id"], "name": stage["name"], "file": stage["file"],
            "state": verdict.state, "diagnosis": verdict.diagnosis, "output": verdict.output, "printed": verdict.printed[-4000:],
            "checks": rows,
            "picture": failed.get("picture", ""),
            "margins": {test["name"]: float(test["margin"]) for test in verdict.tests if "margin" in test},
            "seconds": round(seconds, 2)}


def missing_row(stage: dict, checks: dict, unread: bool) -> dict:
    """Of a file that is not there, or may be in what could not be read."""
    verdict = Verdict("unread", because("submission.stage_unread", file=stage["file"])) if unread else \
        Verdict("missing", because("submission.file_missing", file=stage["file"]))
    return stage_row(stage, verdict, checks, 0.0)


def grade(submission: Submission, toolchain: Toolchain, stages: list, rubric: dict, seed: int, cached,
          by_blanks: bool = True) -> dict:
    """The record of a submission. `cached(file, stages, content, make)` returns make() or what it was for the same
    content."""
    begin, record = time.monotonic(), {"status": "graded", "faults": submission.faults, "unread": submission.unread, "stages": [], "solved": {}}
    cpu, peak, clock = 0.0, 0, Clock(SECONDS_A_SUBMISSION)
    try:
        for file in dict.fromkeys(stage["file"] for stage in stages):
            own = [stage for stage in stages if stage["file"] == file]
            if file not in submission.files:
                record["stages"] += [missing_row(stage, rubric[stage["id"]], bool(submission.unread)) for stage in own]
                continue
            content = submission.files[file]
            result = cached(file, own, content, lambda: grade_file(toolchain, file, content, own, rubric, seed, clock, by_blanks))
            record["stages"] += result["stages"]
            record["solved"][file] = result.get("solved")
            cpu, peak = cpu + result["cpu_seconds"], max(peak, result["peak_mib"])
        if any(row["state"] == "unread" for row in record["stages"]):
            record["status"] = "not-read"
    except Exception as error:  # whatever fails here is ours, and never a mark
        record.update(status="infrastructure-error", error=str(error) if isinstance(error, Infrastructure) else f"{type(error).__name__}: {error}", stages=[])
    order = [stage["id"] for stage in stages]
    record["stages"].sort(key=lambda row: order.index(row["id"]))
    record.update(cpu_seconds=round(cpu, 2), peak_mib=peak, seconds=round(time.monotonic() - begin, 2))
    return mark(record, rubric)
