#!/usr/bin/env python3
"""Judges the reference and every fill of a file, stage by stage: run_fills.py [options] EXECUTABLE FILE…

FILE is a .fills file, or "blanks" for every single blank TODO. Exit code 0 if each verdict is the expected one and can be
told in Chinese, no right fill comes within ten times a tolerance, and NAMED of the wrong ones say what the mistake is, not
only where it shows.
EXECUTABLE is homework_fills, which judges as ./course check does; or, with --worker worker_fills, homework_judge.
"""

import argparse
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tests.homework.fills import Fill, blank_fills, read_fills
from ch5_backend.course.homework.regions import STAGES

from ch5_backend.course.homework import judge as course_judge
from tests.homework.untranslated import untranslated

NAMED = 0.95
UNNAMED = ("none of the typical mistakes", "Crash (", "The program ended by itself", "The tests were not all run")
TIME_LIMIT = 3.0  # for a fill that is expected not to end; the others have the student's limit
MARGIN = 0.1      # of a tolerance: what a right fill may use of it


def is_named(verdict) -> bool:
    """Whether a verdict on a wrong fill names its cause."""
    told = verdict.state != "wrong" or "\n  cause " in verdict.story
    return told and not any(words in verdict.hint for words in UNNAMED)


def judge(asked, one: Fill, stage: dict, seed) -> tuple:
    """Empty if the verdict is the expected one, otherwise a line about the difference; and whether it names its cause."""
    state, words = one.verdict(stage["id"])
    limit = TIME_LIMIT if state == "times-out" else course_judge.TIME_LIMIT
    options, worker, name = [f"--seed={seed}"] if seed else [], [], f"--submission={one.name}"
    if asked.worker:
        worker = [str(asked.worker.resolve()), name]
        options += [f"--time-limit={limit}"]
        limit *= 2
    else:
        options += [name]
    verdict = course_judge.judge(asked.executable.resolve(), stage, limit, options, worker)
    where = f"{one.name}, stage {stage['id']}, seed {seed}"
    if verdict.state != state or words not in verdict.hint:
        return f"{where}: expected {state} “{words}”, got {verdict.state} “{verdict.hint}”", False
    if left := untranslated(verdict):
        return f"{where}: not in Chinese: “{left}”; see ch5_backend/course/base/language/zh", False
    near = [f"{where}: {test['name']} uses {float(test['margin']):.2g} of its tolerance" for test in verdict.tests
            if state == "right" and float(test.get("margin", 0)) > MARGIN]
    return "\n".join(near), is_named(verdict)


def stages_of(one: Fill, own: bool) -> list:
    """The stages in which it is judged: all, or those whose verdict or code is its own."""
    places = {word.split()[1] for word in one.code}
    held = {stage["id"] for stage in STAGES if places.intersection([stage["id"], *stage["todos"]])}
    return [stage for stage in STAGES if not own or one.name == "linked" or stage["id"] in (one.expected or held)]


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("executable", type=Path)
    parser.add_argument("files", nargs="+")
    parser.add_argument("--worker", type=Path)
    parser.add_argument("--seed", type=int, action="append", help="may be repeated: right fills are judged with each")
    parser.add_argument("--own", action="store_true", help="only the stages whose verdict or code is the fill's")
    asked = parser.parse_args()
    fills = [Fill("linked")]
    for file in asked.files:
        fills += blank_fills() if file == "blanks" else read_fills(Path(file))
    seeds = asked.seed or [None]
    cases = [(one, stage, seed) for one in fills for stage in stages_of(one, asked.own)
             for seed in (seeds[:1] if one.expected else seeds)]
    with ThreadPoolExecutor(2) as pool:
        verdicts = list(pool.map(lambda case: judge(asked, *case), cases))
    differences = [difference for difference, _ in verdicts if difference]
    named = [told for (one, stage, _), (_, told) in zip(cases, verdicts) if stage["id"] in one.expected]
    print("\n".join(differences))
    right = sum(not one.expected for one in fills)
    print(f"{right} right and {len(fills) - right} wrong fills, {len(cases)} verdicts, {len(differences)} unexpected, "
          f"named {sum(named)} of {len(named)}")
    return 1 if differences or sum(named) < NAMED * len(named) else 0


if __name__ == "__main__":
    sys.exit(main())
