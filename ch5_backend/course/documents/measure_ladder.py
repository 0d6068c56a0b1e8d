"""Measures the rungs of ./course ladder, tests/homework/samples/ladder.samples, and keeps what each made faster.

usage: python3 -m ch5_backend.course.documents.measure_ladder [--out DIR]        five minutes
"""

import argparse
import json
import os
import subprocess
import tempfile
from pathlib import Path

from ch5_backend.figures import tables

from ..base.cmake_build import ROOT
from ..homework.samples import read_samples, source

NAME = "ladder"


def times_of(code: dict) -> float:
    """How many times as fast as the solution ./course ladder finds a homework with this code."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "block_solver.cc").write_text(source("block_solver.cc", code), encoding="utf-8")
        done = subprocess.run([ROOT / "course", "ladder", "--json"], env={**os.environ, "CH5_HOMEWORK_DIR": folder}, stdout=subprocess.PIPE, check=True)
    return json.loads(done.stdout)["times"]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="measure_ladder.py", description=__doc__.split("\n\n")[0])
    parser.add_argument("--out", metavar="DIR", type=Path, default=ROOT / "ch5_backend" / "figures" / "kept", help="where the table goes")
    out = parser.parse_args().out
    samples = read_samples(ROOT / "tests" / "homework" / "samples" / f"{NAME}.samples")
    tables.write(out / f"{NAME}.csv", ("rung", "times"), [(k, f"{times_of(one.code):.3f}") for k, one in enumerate(samples, 1)])
