"""Records get the names that the mistakes have now, and ./course grade --rename runs mistakes that were added since: of what was
graded nothing is compiled or run again."""

import json
import tempfile
from pathlib import Path

from ch5_backend.figures.atomic_write import write_whole

from ..base.errors import CourseError, warn
from ..base.progress import Progress
from ..base.scratch import scratch
from ..homework import answers
from ..homework.blanks import own_todo
from ..homework.samples import read_mistakes, source
from .job import run_stage
from .toolchain import Clock, Toolchain


def learn(toolchain: Toolchain) -> list:
    """Runs the mistakes that answers.csv does not have, or not as they are now, and brings it up to date; returns their names."""
    known, new, rows = {row.mistake: row for row in answers.read_table()}, [], []
    with Progress("mistakes") as progress:
        for one in (one for one in read_mistakes() if one.state == "wrong"):
            row = known.get(one.name)
            if not row or row.code != answers.hash_of(one.code):
                progress.step(one.name)
                row = run(toolchain, one)
                new.append(one.name)
            rows.append(row._replace(cause=one.cause))
    for name, other in answers.ambiguous(rows):
        if name in new or other in new:
            warn(f"{name} gives the same answer as {other}, with another cause: neither is named for such an answer")
    answers.write_table(rows)
    answers.known.cache_clear()
    return new


def run(toolchain: Toolchain, one) -> answers.Row:
    """The row of a mistake that was never run. Raises CourseError where it is none."""
    stage = one.stages[0]
    with tempfile.TemporaryDirectory(dir=scratch(), ignore_cleanup_errors=True) as folder:
        built = toolchain.compile(stage["file"], source(stage["file"], one.code).encode(), Path(folder))
        verdict = built.verdict or run_stage(toolchain, built.worker, stage, None, Clock(60.0), fail_fast=True)
    if verdict.state != "wrong":
        raise CourseError(f"ch5_homework/mistakes: {one.name} should be wrong, but its state is {verdict.state}. {verdict.output}".strip())
    if "fingerprint" not in verdict.diagnosis:
        warn(f"{one.name} gives no finite numbers to compare: the judge's own diagnosis is shown for such an answer")
    return answers.row_of(one, verdict.diagnosis)


def renamed(record: dict) -> dict:
    """A record with the names that answers.csv has now."""
    return {**record, "stages": [{**row, "diagnosis": renamed_diagnosis(row["diagnosis"])} for row in record["stages"]]}


def renamed_diagnosis(diagnosis: dict) -> dict:
    now = answers.named_anew(diagnosis)
    if " " in now.get("todo", ""):  # of the two depths' TODOs the one that this file has, as far as it is known
        before = diagnosis.get("todo", "")
        now["todo"] = before if before in now["todo"].split() else own_todo(now["todo"], b"")
    return now


def rename_all(out: Path) -> list:
    """Renames the records of a folder; returns the names of the submissions whose records have changed."""
    changed = []
    for path in sorted(out.glob("*/record.json")):
        record = json.loads(path.read_text(encoding="utf-8"))
        if (now := renamed(record)) != record:
            write_whole(path, json.dumps(now, ensure_ascii=False, indent=1), "backslashreplace")
            changed.append(path.parent.name)
    return changed
