"""The grade of one submission: a pure function of its files, the seed, the rubric and the toolchain."""

import re
import shutil
import tempfile
import time
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from ..homework.blanks import explain
from ..homework.diagnosis import Verdict, because
from ..homework.judge import judge
from ..base.scratch import scratch
from .follow_through import follow_through
from .rubric import marks
from .sandbox import Limits, Sandbox, preflight
from .submission import Submission
from .toolchain import Toolchain, require_room

SECONDS_A_TEST = 10.0   # the reference needs a tenth of one
SECONDS_A_SUBMISSION = 240.0  # for all its checks; they need 193 where a loop in each stage does not end
FOLLOWED = ("wrong", "crashes", "not-started")  # what does not end would not end once for each blank
LONGEST_FOLLOWED = 10.0  # seconds of the compiler; the solutions need two
OUT_OF_TIME = "judge.submission_too_long"
RUNNING = Limits(seconds=10, wall_seconds=SECONDS_A_TEST + 5.0)


@dataclass
class Clock:
    """The time of a submission's checks [s]. The compiler has no share in it: its limit is one of processor time."""
    left: float

    @contextmanager
    def running(self):
        begin = time.monotonic()
        try:
            yield
        finally:
            self.left -= time.monotonic() - begin


def grade_file(toolchain: Toolchain, file: str, content: bytes, stages: list, rubric: dict, seed: int, clock: Clock) -> dict:
    """{"stages": a row for each, "cpu_seconds", "peak_mib", "complete"}, cpu and peak of the compiler; it is not complete where
    the clock has run out. Raises Infrastructure."""
    folder = Path(tempfile.mkdtemp(dir=scratch()))
    try:
        built = toolchain.compile(file, content, folder)
        rows, of_all = [], built.verdict
        for stage in stages:
            begin = time.monotonic()
            verdict = of_all or explain(run_stage(toolchain, built.worker, stage, seed, clock), stage, content)
            if any(re.search("TIMEOUT after .* in its start", str(test.get("failures"))) for test in verdict.tests):
                of_all = verdict._replace(tests=())  # nor will it start for another stage
            row = stage_row(stage, verdict, rubric[stage["id"]], time.monotonic() - begin)
            if verdict is not of_all and verdict.state in FOLLOWED and built.cpu_seconds < LONGEST_FOLLOWED:
                row.update(follow_through(stage, content, verdict, row,
                                          lambda text, stage=stage: judged(toolchain, file, text, stage, seed, clock)))
            rows.append(row)
        return {"stages": rows, "cpu_seconds": round(built.cpu_seconds, 2), "peak_mib": round(built.peak_mib),
                "complete": clock.left > 0.0}
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def judged(toolchain: Toolchain, file: str, content: bytes, stage: dict, seed: int, clock: Clock) -> Verdict:
    """The verdict on a mended text, up to the first check that fails."""
    with tempfile.TemporaryDirectory(dir=scratch(), ignore_cleanup_errors=True) as folder:
        built = toolchain.compile(file, content, Path(folder))
        return built.verdict or run_stage(toolchain, built.worker, stage, seed, clock, fail_fast=True)


def run_stage(toolchain: Toolchain, worker: Path, stage: dict, seed: int, clock: Clock, fail_fast: bool = False) -> Verdict:
    box = toolchain.box(read_only={"/worker": worker}, limits=RUNNING)
    with clock.running():
        verdict = judge(toolchain.judge, stage, max(clock.left, 0.0), [f"--seed={seed}", f"--time-limit={SECONDS_A_TEST:g}"],
                        box.wrap(["/worker"]), Path("/worker"), fail_fast=fail_fast,
                        words_of=lambda command: box.run(command).output)  # its debugging lines may be forged, too
    if clock.left <= 0.0 and not verdict.tests:
        return Verdict("times-out", because(OUT_OF_TIME, n=f"{SECONDS_A_SUBMISSION:g}"))
    silent = not verdict.tests or any("START:" in str(test.get("failures")) for test in verdict.tests)
    if silent:  # that may be ours to answer for
        require_room()
        if toolchain.box is Sandbox:
            preflight()
    return verdict


def stage_row(stage: dict, verdict: Verdict, checks: dict, seconds: float) -> dict:
    passed = {test["name"] for test in verdict.tests if test.get("result") == "COMPLETED" and not test.get("failures")}
    rows = marks(checks, passed)
    failed = next((test for test in verdict.tests if test.get("failures")), {})
    return {"id": stage["id"], "name": stage["name"], "file": stage["file"],
            "state": verdict.state, "diagnosis": verdict.diagnosis, "output": verdict.output, "printed": verdict.printed[-4000:],
            "score": sum(row["score"] for row in rows), "points": sum(row["points"] for row in rows), "checks": rows,
            "picture": failed.get("picture", ""),
            "margins": {test["name"]: float(test["margin"]) for test in verdict.tests if "margin" in test},
            "seconds": round(seconds, 2)}


def missing_row(stage: dict, checks: dict) -> dict:
    return stage_row(stage, Verdict("missing", because("submission.file_missing", file=stage["file"])), checks, 0.0)


def grade(submission: Submission, toolchain: Toolchain, stages: list, rubric: dict, seed: int, cached) -> dict:
    """The record of a submission. `cached(file, content, make)` returns make() or what it was for the same content."""
    begin, record = time.monotonic(), {"status": "graded", "faults": submission.faults, "stages": []}
    cpu, peak, clock = 0.0, 0, Clock(SECONDS_A_SUBMISSION)
    try:
        for file in dict.fromkeys(stage["file"] for stage in stages):
            own = [stage for stage in stages if stage["file"] == file]
            if file not in submission.files:
                record["stages"] += [missing_row(stage, rubric[stage["id"]]) for stage in own]
                continue
            content = submission.files[file]
            result = cached(file, content, lambda: grade_file(toolchain, file, content, own, rubric, seed, clock))
            record["stages"] += result["stages"]
            cpu, peak = cpu + result["cpu_seconds"], max(peak, result["peak_mib"])
    except Exception as error:  # whatever fails here is ours, and never a mark
        record.update(status="infrastructure-error", error=f"{type(error).__name__}: {error}", stages=[])
    order = [stage["id"] for stage in stages]
    record["stages"].sort(key=lambda row: order.index(row["id"]))
    record.update(score=round(sum(row["score"] for row in record["stages"]), 6),
                  points=sum(sum(rubric[stage["id"]].values()) for stage in stages),
                  cpu_seconds=round(cpu, 2), peak_mib=peak, seconds=round(time.monotonic() - begin, 2))
    return record
