"""Measures which first damping λ₀ and which variables, points that add or points on rays, serve bundle adjustment.

usage: python3 -m ch5_backend.course.documents.measure_start [--unseen] [--rounds N] [--out DIR]

Prints for each pair the processor's time to within 0.1 % of the least cost that any pair finds, relative to the problem's
best pair, as geometric mean, least and most over the set; keeps every time in slides/measured/speed_start.csv. What does not
arrive counts as twice its whole time. BuildBal's choice (files/bal.h) is that of SEEN; UNSEEN is measured, with --unseen, once
it is made. The row "unasked" is what the library does by itself.
"""

import argparse
import statistics
import sys
from pathlib import Path

from ch5_backend.figures import tables
from ch5_backend.figures.numbers.peers import pairs_of

from ..base.cmake_build import ROOT, build_or_fail, data_folder
from ..base.progress import Progress
from ..experiments.bench import UNASKED, Case, run_side, seconds_to

SEEN = ("problem-49-7776-pre.txt", "problem-16-22106-pre.txt", *(f"first:{n}:problem-49-7776-pre.txt" for n in (10, 20, 25, 40)),
        *(f"first:{n}:problem-16-22106-pre.txt" for n in (4, 8, 12)), *(f"first:{n}:maplab-969-22767.txt" for n in (40, 100, 300)),
        "city:30", "city:100", "city:300")
UNSEEN = ("first:33:problem-49-7776-pre.txt", "first:10:problem-16-22106-pre.txt", "first:250:maplab-969-22767.txt", "city:120:9")
RADII = "1e3", "1e4", "3.3e4", "1e5", "3.3e5", "1e6"
PAIRS = (UNASKED, *(f"lm,{points},radius={radius}" for points in ("xyz", "ray") for radius in RADII),
         "lm,ray,radius=3.3e5,whole")  # as unasked, but without steps of the landmarks where a step has raised the cost

HEAD = ("problem", "pair", "ms", "trials", "final_cost", "arrives")


def source(problem):
    """What measure_ours reads: a file's name follows the last colon."""
    head, colon, file = problem.rpartition(":")
    return f"{head}{colon}{data_folder() / 'bal' / file}" if file.endswith(".txt") else problem


def measure(problems, rounds):
    """{problem: {pair: runs}}, the rounds outermost, so that the machine's moods fall on all alike."""
    runs = {problem: {pair: [] for pair in PAIRS} for problem in problems}
    with Progress("measure") as progress:
        for turn in range(rounds):
            for problem in problems:
                progress.step(f"round {turn + 1} of {rounds}: {problem}")
                for pair in PAIRS:
                    runs[problem][pair] += run_side("ours", Case("bal/49-7776", source(problem), 1), pair)
    return runs


def rows_of(runs):
    """A row for each pair of each problem; trials and cost are those of the whole."""
    rows = []
    for problem, pairs in runs.items():
        least = min(run["final_cost"] for turns in pairs.values() for run in turns)
        for pair, turns in pairs.items():
            times = [seconds_to(run, 1.001 * least) for run in turns]
            arrives = None not in times
            ms = 1e3 * statistics.median(times if arrives else [2.0 * run["seconds"] for run in turns])
            rows.append(dict(zip(HEAD, (problem, pair or "unasked", ms, turns[0]["trials"], turns[0]["final_cost"], int(arrives)))))
    return rows


def main():
    parser = argparse.ArgumentParser(prog="measure_start.py", description=__doc__.split("\n\n")[0])
    parser.add_argument("--unseen", action="store_true", help="the problems that the choice was not made on")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--out", metavar="DIR", type=Path, default=ROOT / "slides" / "measured")
    given = parser.parse_args()
    build_or_fail(["measure_ours"])
    problems = UNSEEN if given.unseen else SEEN
    rows = rows_of(measure(problems, given.rounds))
    name = "speed_start_unseen" if given.unseen else "speed_start"
    tables.write(given.out / f"{name}.csv", HEAD, [[row[key] for key in HEAD] for row in rows])
    print(f"{'pair':<22} {'mean':>6} {'least':>6} {'most':>6} arrives, of {len(problems)} problems", file=sys.stdout)
    for pair, mean, least, most, arrivals in pairs_of(rows):
        print(f"{pair:<22} {mean:6.2f} {least:6.2f} {most:6.2f} {arrivals}")


if __name__ == "__main__":
    main()
