#!/usr/bin/env python3
"""Judges the reference and every fill of a file, stage by stage, as ./course check does: run_fills.py EXECUTABLE FILE…

FILE is a .fills file, or "blanks" for every single blank TODO. Exit code 0 if each verdict is the expected one.
"""

import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from fills import Fill, blank_fills, read_fills
from regions import ROOT, STAGES

sys.path.insert(0, str(ROOT / "ch5_backend" / "apps"))
from course import judge as course_judge  # noqa: E402  (the folder must be known first)

TIME_LIMIT = 3.0  # for a fill that is expected not to end; the others have the student's limit


def judge(executable: Path, one: Fill, stage: dict) -> str:
    """Empty if the verdict is the expected one, otherwise a line about the difference."""
    state, words = one.verdict(stage["id"])
    limit = TIME_LIMIT if state == "times-out" else course_judge.TIME_LIMIT
    verdict = course_judge.judge(executable, stage, limit, [f"--submission={one.name}"])
    if verdict.state == state and words in verdict.hint:
        return ""
    return f"{one.name}, stage {stage['id']}: expected {state} “{words}”, got {verdict.state} “{verdict.hint}”"


def main(executable: str, files: list) -> int:
    fills = [Fill("linked")]
    for file in files:
        fills += blank_fills() if file == "blanks" else read_fills(Path(file))
    pairs = [(one, stage) for one in fills for stage in STAGES]
    with ThreadPoolExecutor(2) as pool:
        differences = list(filter(None, pool.map(lambda pair: judge(Path(executable).resolve(), *pair), pairs)))
    print("\n".join(differences))
    right = sum(not one.expected for one in fills)
    print(f"{right} right and {len(fills) - right} wrong fills, {len(pairs)} verdicts, {len(differences)} unexpected")
    return 1 if differences else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
