#!/usr/bin/env python3
"""Judges the reference and every fill of a file, stage by stage: run_fills.py [options] EXECUTABLE FILE…

FILE is a .fills file, or "blanks" for every single blank TODO. Exit code 0 if each verdict is the expected one.
EXECUTABLE is homework_fills, which judges as ./course check does; or, with --worker worker_fills, homework_judge.
"""

import argparse
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from fills import Fill, blank_fills, read_fills
from regions import ROOT, STAGES

sys.path.insert(0, str(ROOT / "ch5_backend" / "apps"))
from course import judge as course_judge  # noqa: E402  (the folder must be known first)

TIME_LIMIT = 3.0  # for a fill that is expected not to end; the others have the student's limit


def judge(asked, one: Fill, stage: dict) -> str:
    """Empty if the verdict is the expected one, otherwise a line about the difference."""
    state, words = one.verdict(stage["id"])
    limit = TIME_LIMIT if state == "times-out" else course_judge.TIME_LIMIT
    options, worker, name = [f"--seed={asked.seed}"] if asked.seed else [], [], f"--submission={one.name}"
    if asked.worker:
        worker = [str(asked.worker.resolve()), name]
        options += [f"--time-limit={limit}"]
        limit *= 2
    else:
        options += [name]
    verdict = course_judge.judge(asked.executable.resolve(), stage, limit, options, worker)
    if verdict.state == state and words in verdict.hint:
        return ""
    return f"{one.name}, stage {stage['id']}: expected {state} “{words}”, got {verdict.state} “{verdict.hint}”"


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("executable", type=Path)
    parser.add_argument("files", nargs="+")
    parser.add_argument("--worker", type=Path)
    parser.add_argument("--seed", type=int)
    parser.add_argument("--own", action="store_true", help="only the stages whose verdict is not “right”, and the reference")
    asked = parser.parse_args()
    fills = [Fill("linked")]
    for file in asked.files:
        fills += blank_fills() if file == "blanks" else read_fills(Path(file))
    pairs = [(one, stage) for one in fills for stage in STAGES
             if not asked.own or one.name == "linked" or stage["id"] in one.expected]
    with ThreadPoolExecutor(2) as pool:
        differences = list(filter(None, pool.map(lambda pair: judge(asked, *pair), pairs)))
    print("\n".join(differences))
    right = sum(not one.expected for one in fills)
    print(f"{right} right and {len(fills) - right} wrong fills, {len(pairs)} verdicts, {len(differences)} unexpected")
    return 1 if differences else 0


if __name__ == "__main__":
    sys.exit(main())
