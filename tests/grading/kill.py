#!/usr/bin/env python3
"""Judges mutants (mutants.py) as ./course grade judges a submission: python3 -m tests.grading.kill [PATTERN…], of ids: regular expressions.

It judges them in an order shuffled by seed SHUFFLE, so that the part of a run that was stopped is a sample of all stages, and
resumes: what has been killed before is not judged again. A mutant is killed if no seed lets it pass. The last line is for
MUTANTS.md. Exit code 0 if that explains all that survive.
"""

import json
import random
import re
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from tests.grading.mutants import Mutant, all_mutants
from tests.grading.one_stage import SEEDS, Grader
from tests.homework.run_samples import is_named
from ch5_backend.course.base.cmake_build import BUILD, CORES
from ch5_backend.course.base.language import speaker
from ch5_backend.course.homework.diagnosis import in_short
from ch5_backend.course.base.progress import Progress, duration
from ch5_backend.figures.atomic_write import write_whole

KNOWN = BUILD / "mutants.json"
PAGE = Path(__file__).with_name("MUTANTS.md")
SHUFFLE = 54
EQUIVALENT = re.compile(r"^\| (\S+:\d+:\w+:\d+) \| `(.*)` \| (.*) \|$", re.MULTILINE)
KILLED = ("wrong", "crashes", "times-out")


def read_equivalents() -> dict:
    """{id: {"line": as it stands in the mutant, "reason"}}"""
    rows = EQUIVALENT.findall(PAGE.read_text(encoding="utf-8").replace(r"\|", "|"))
    return {name: {"line": line, "reason": reason} for name, line, reason in rows}


def judge(grader: Grader, mutant: Mutant, seeds=SEEDS) -> dict:
    """{"line", "state": of a seed that lets it pass, or of the first, "named": whether its cause is told, "hint"}"""
    verdicts = grader.verdicts(mutant.file, mutant.source(), mutant.stage, seeds)
    told = next((verdict for verdict in verdicts if verdict.state == "right"), verdicts[0])
    return {"line": mutant.text.strip(), "state": told.state, "named": all(is_named(verdict.diagnosis) for verdict in verdicts), "hint": in_short(told.diagnosis, speaker("en"))}


def judge_all(mutants: list, known: dict) -> None:
    """Adds what is found to `known`, and keeps it from one run to the next, whole also if it is killed while it writes."""
    grader, begin = Grader(), None
    with Progress("mutants") as progress, ThreadPoolExecutor(CORES) as pool:
        futures = {pool.submit(judge, grader, mutant): mutant for mutant in mutants}
        for done, future in enumerate(as_completed(futures), 1):
            known[futures[future].id] = future.result()
            write_whole(KNOWN, json.dumps(known, ensure_ascii=False, indent=0))
            begin = begin or progress.clock()
            left = (progress.clock() - begin) / done * (len(mutants) - done)
            progress.step(f"{done} of {len(mutants)}, about {duration(left)} left", in_pipes=True)


def verdict_on(mutant: Mutant, known: dict, equivalents: dict) -> str:
    """"killed", "equivalent", "no C++", "survives" or "not judged"."""
    found = known.get(mutant.id)
    if not found or found["line"] != mutant.text.strip():
        return "not judged"
    if found["state"] in KILLED:
        return "killed"
    if found["state"] == "does-not-compile":
        return "no C++"
    return "equivalent" if mutant.id in equivalents else "survives"


def totals(mutants: list, known: dict, equivalents: dict) -> str:
    verdicts = Counter(verdict_on(mutant, known, equivalents) for mutant in mutants)
    killed = [known[mutant.id] for mutant in mutants if verdict_on(mutant, known, equivalents) == "killed"]
    ways = Counter(found["state"] for found in killed)
    return (f"{len(mutants)} mutants: {verdicts['killed']} killed ({ways['wrong']} wrong, {ways['crashes']} crash, "
            f"{ways['times-out']} do not end), {verdicts['equivalent']} equivalent, {verdicts['no C++']} are no C++, "
            f"{verdicts['survives']} survive, {verdicts['not judged']} not judged. Of {ways['wrong']} wrong ones "
            f"{sum(found['named'] for found in killed if found['state'] == 'wrong')} are told their cause.")


def main() -> int:
    mutants, equivalents, patterns = all_mutants(), read_equivalents(), sys.argv[1:]
    random.Random(SHUFFLE).shuffle(mutants)
    known = json.loads(KNOWN.read_text(encoding="utf-8")) if KNOWN.exists() else {}
    chosen = [one for one in mutants if not patterns or any(re.search(pattern, one.id) for pattern in patterns)]
    judge_all([one for one in chosen if verdict_on(one, known, equivalents) in ("survives", "not judged")], known)
    survivors = [one for one in chosen if verdict_on(one, known, equivalents) == "survives"]
    for one in survivors:
        print(f"{one.id}: survives: {one.text.strip()}")
    print(totals(mutants, known, equivalents))
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
