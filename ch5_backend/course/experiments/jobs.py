"""Many runs of programs, a few at a time. One that is a trial leaves a CSV file of its own, so that it is never repeated.

A trial's file appears whole or not at all, at OUT/jobs/SET/STUDY-KEY/K.csv. KEY is drawn from all that its rows depend
on: the contents of the program, and of every file among its words, the words, and CH5_SIMD. After a change of any of
them the results lie elsewhere, and old ones are never taken for new.
"""

import csv
import hashlib
import os
import shutil
import sys
import tempfile
import time
from collections import deque
from dataclasses import dataclass
from pathlib import Path

from ..base import processes
from ..base.errors import CourseError
from ..base.progress import Progress
from .run import check_exit

SECONDS_TOLD = 1.0  # between two looks at the time left


@dataclass(frozen=True)
class Job:
    """One run of a program; with `result`, the words --out FILE are added."""
    command: tuple
    seconds: float  # about how long
    name: str
    result: Path = None

    def study(self) -> str:
        return self.result.parent.name.rpartition("-")[0]


def trial_jobs(command: tuple, name: str, studies: dict, folder: Path, seconds: float) -> list:
    """The jobs of a set of trials, study by study; `studies` is {study: number of trials}, `folder` OUT/jobs/SET."""
    jobs = []
    for study, trials in studies.items():
        words = (*command, study)
        place = folder / f"{study}-{key_of(words)}"
        jobs += [Job((*words, "--trial", str(k)), seconds / sum(studies.values()), f"{name}, {study} {k + 1} of {trials}",
                     place / f"{k}.csv") for k in range(trials)]
    return jobs


def key_of(words: tuple) -> str:
    digest = hashlib.sha256(os.environ.get("CH5_SIMD", "").encode())
    for word in words:
        digest.update(b"\0" + word.encode("utf-8", "surrogateescape"))
        if Path(word).is_file():
            digest.update(b"\0" + Path(word).read_bytes())
    return digest.hexdigest()[:16]


def run_jobs(jobs: list, width: int, progress: Progress) -> None:
    """Runs all, `width` at a time.

    Raises CourseError if one fails. Then, and after Ctrl-C, the running ones are ended, and the done ones stay.
    """
    waiting, active, told = deque(jobs), [], 0.0
    try:
        while waiting or active:
            while waiting and len(active) < width:
                active.append(_Run(waiting.popleft()))
                told = 0.0
            if time.monotonic() - told > SECONDS_TOLD:
                told = time.monotonic()
                progress.expected_step(active[-1].job.name)
            time.sleep(0.01)
            for run in [run for run in active if run.process.poll() is not None]:
                active.remove(run)
                run.finish()
                progress.finished(run.job.seconds)
    finally:
        for run in active:
            run.abandon()


class _Run:
    """A job's process and what it says."""

    def __init__(self, job: Job):
        self.job, self.partial, words = job, None, ()
        if job.result:
            job.result.parent.mkdir(parents=True, exist_ok=True)
            self.partial = job.result.with_name(f".{os.uname().nodename}-{os.getpid()}-{job.result.name}")
            words = "--out", str(self.partial)
        self.said = tempfile.TemporaryFile()
        self.process = processes.start(
            [*job.command, *words], stdin=processes.subprocess.DEVNULL, stdout=self.said, stderr=self.said,
            env={**os.environ, "MPLBACKEND": "Agg", "PYTHONUTF8": "1"})

    def finish(self) -> None:
        """Keeps the result of a process that has ended, or raises CourseError with its last words."""
        processes.forget(self.process)
        self.said.seek(0)
        lines = self.said.read().decode("utf-8", "replace").strip().splitlines()
        self.said.close()
        try:
            if self.process.returncode:
                print("\n".join(lines), file=sys.stderr)
            check_exit(self.job.command, self.process.returncode, f"that was {self.job.name}; its message is above")
            if self.partial:
                self.partial.replace(self.job.result)
        except FileNotFoundError as error:
            raise CourseError(f"{self.job.name}: {Path(self.job.command[0]).name} has written nothing", 1) from error
        finally:
            if self.partial:
                self.partial.unlink(missing_ok=True)

    def abandon(self) -> None:
        processes.end(self.process)
        if self.partial:
            self.partial.unlink(missing_ok=True)


def merge(jobs: list, table: Path) -> None:
    """One table of the results of all jobs, in their order: it does not depend on who ran which, and when."""
    header, rows = None, []
    for job in jobs:
        with open(job.result, newline="", encoding="utf-8") as file:
            first, *more = list(csv.reader(file)) or [None]
        if not first or (header and first != header):
            raise CourseError(f"{job.result}, line 1: expected the header {header or 'of a table'}, got {first}", 1)
        header = first
        for line, row in enumerate(more, start=2):
            if len(row) != len(header):
                raise CourseError(f"{job.result}, line {line}: {len(row)} cells under a header of {len(header)}", 1)
        rows += more
    table.parent.mkdir(parents=True, exist_ok=True)
    partial = table.with_name(f".{os.getpid()}-{table.name}")
    with open(partial, "w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([header, *rows])
    partial.replace(table)


def clear(folder: Path) -> None:
    """Removes the trials' files of a set, which its tables now hold."""
    shutil.rmtree(folder, ignore_errors=True)
    if folder.parent.is_dir() and not any(folder.parent.iterdir()):
        folder.parent.rmdir()
