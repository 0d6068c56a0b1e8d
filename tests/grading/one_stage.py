"""One stage of one file, judged as ./course grade does: its sandbox, its first compiler, its worker and judge."""

import os
import tempfile
from pathlib import Path

if os.environ.get("CH5_BUILD"):  # CTest's word for the build folder
    os.environ.setdefault("CH5_BUILD_DIR", os.environ["CH5_BUILD"])

from ch5_backend.course.base.cmake_build import BUILD
from ch5_backend.course.homework.blanks import explain
from ch5_backend.course.grading import job
from ch5_backend.course.grading.engines import choose
from ch5_backend.course.grading.toolchain import Clock, Toolchain

SEEDS = (1, 2, 3)
READY = (BUILD / "grader" / "toolchain.json").exists()


class Grader:
    """A stage stops at its first failure, and a check after 3 s: the reference needs a tenth of one."""

    def __init__(self):
        self.toolchain = Toolchain(choose())
        self.toolchain.prepare()
        del self.toolchain.compilers[1:]  # what the first refuses, the second does too
        job.RUNNING = job.RUNNING._replace(seconds=3)

    def verdicts(self, file: str, content: bytes, stage: dict, seeds=SEEDS) -> list:
        """The verdict of each seed; only one of a file that does not compile, or that does not end."""
        with tempfile.TemporaryDirectory(prefix="course-grade.") as folder:
            built = self.toolchain.compile(file, content, Path(folder))
            found = [built.verdict] if built.verdict else []
            for seed in seeds if built.worker else ():
                verdict = job.run_stage(self.toolchain, built.worker, stage, seed, Clock(), fail_fast=True)
                found.append(explain(verdict, stage, content))
                if found[-1].state == "times-out":
                    break
        return found
