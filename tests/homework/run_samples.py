#!/usr/bin/env python3
"""Judges every sample submission of a file, stage by stage: run_samples.py [options] EXECUTABLE FILE…

FILE is a .mistakes or .samples file, or "blanks" for the reference and every single blank TODO. Exit code 0 if each verdict is
the expected one and can be told in every language, no right sample comes within ten times a tolerance, answers.csv has the
answers of the wrong ones as they are, exercised.csv what blanks the checks end in, and NAMED of these say what the mistake is, not only where it shows.
EXECUTABLE is homework_samples, which judges as ./course check does; or, with --worker worker_samples, homework_judge. These two
have the samples of the day; all_homework_samples and all_worker_samples have all.
"""

import argparse
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tests.homework.chinese import english_in
from tests.homework.samples import blank_samples, by_day
from ch5_backend.course.base.cmake_build import BUILD
from ch5_backend.course.base.language import LANGUAGES, speaker
from ch5_backend.course.homework import answers, judge as course_judge, ticks
from ch5_backend.course.homework.diagnosis import SYMPTOMS, cause_of, in_full, in_short
from ch5_backend.course.homework.regions import STAGES
from ch5_backend.course.homework.samples import Sample, read_samples

NAMED = 0.95
UNNAMED = (*SYMPTOMS, "judge.crash", "judge.outside_memory", "judge.ended_by_itself", "judge.not_all_run", "judge.test_failed", "")
TIME_LIMIT = 3.0  # for a sample that is expected not to end; the others have the student's limit
KNOWN = {row.mistake: row for row in answers.read_table()}
MARGIN = 0.01     # of a tolerance: what a right sample may use of it, as GRADING.md says


def is_named(diagnosis: dict) -> bool:
    """Whether a diagnosis of what is wrong names its cause."""
    return cause_of(diagnosis) not in UNNAMED


def said_in(text) -> set:
    """The ids and the values in something said."""
    parts = text.values() if isinstance(text, dict) else text if isinstance(text, list) else []
    return {str(text)} if not parts else set().union(*map(said_in, parts))


def judge(asked, one: Sample, stage: dict, seed) -> tuple:
    """Empty if the verdict is the expected one, otherwise a line about the difference; and the diagnosis."""
    state, wanted = one.verdict(stage)
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
    told = [in_short(verdict.diagnosis, speaker(language)) + in_full(verdict.diagnosis, verdict.output, speaker(language))
            for language in LANGUAGES]  # a sentence that lacks a value is a KeyError here
    if verdict.state != state or not (asked.write or is_said(wanted, state, verdict.diagnosis.get("cause", ""))):
        return f"{where}: expected {state} “{wanted}”, got {verdict.state} “{told[0]}” {verdict.diagnosis}", verdict.diagnosis
    if wanted and state == "wrong" and not (seed or asked.write) and (stale := is_stale(one, verdict.diagnosis)):
        return f"{where}: {stale}; cmake --build {BUILD} --target answers makes answers.csv anew", verdict.diagnosis
    if english := english_in(told[LANGUAGES.index("zh")]):
        return f"{where}: in Chinese it says “{english}”", verdict.diagnosis
    near = [f"{where}: {test['name']} uses {float(test['margin']):.2g} of its tolerance" for test in verdict.tests
            if state == "right" and float(test.get("margin", 0)) > MARGIN]
    return "\n".join(near), verdict.diagnosis


def is_said(wanted: dict, state: str, cause) -> bool:
    """Of a wrong answer the cause is the mistake's, if it names one; of what ends otherwise it holds at least these words."""
    return not wanted or (cause == wanted if state == "wrong" else said_in(wanted) <= said_in(cause))


def is_stale(one: Sample, diagnosis: dict) -> str:
    """Why the row of a mistake is not as it would be made now, or ""."""
    row, now = KNOWN.get(one.name), answers.row_of(one, diagnosis)
    if not row:
        return "it has no row"
    if not answers.near(now.fingerprint, row.fingerprint):
        return f"its row has another fingerprint than {now.fingerprint}"
    return next((f"its row has another {key}, not {value}" for key, value in now._asdict().items()
                 if key != "fingerprint" and value != getattr(row, key)), "")


def ends_in_blanks(executable: Path) -> dict:
    """{(stage, check): the TODOs that it ends in where they are the only blank}"""
    found = {}
    for one in blank_samples():
        for stage in one.stages:
            for test in course_judge.every_test(executable.resolve(), stage, [f"--submission={one.name}"]):
                if test.get("failures") and ticks.ends_in_a_blank(test):
                    found.setdefault((stage["id"], test["name"]), set()).add(one.todo)
    return found


def stages_of(one: Sample, own: bool) -> list:
    """The stages in which it is judged: those of its files, or only those whose verdict or code is its own."""
    files = {stage["file"] for stage in one.stages}
    return [stage for stage in STAGES if one.name == "linked" or
            (stage in one.stages if own else stage["file"] in files)]


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("executable", type=Path)
    parser.add_argument("files", nargs="+")
    parser.add_argument("--worker", type=Path)
    parser.add_argument("--seed", type=int, action="append", help="may be repeated: right samples are judged with each")
    parser.add_argument("--own", action="store_true", help="only the stages whose verdict or code is the sample's")
    parser.add_argument("--by-day", action="store_true", help="only the samples of the day")
    parser.add_argument("--write", action="store_true", help="write answers.csv anew, of the mistakes in these files; exercised.csv of blanks")
    asked = parser.parse_args()
    if asked.write and asked.files == ["blanks"]:
        ticks.write_table(ends_in_blanks(asked.executable))
        return 0
    samples, chosen = [], by_day if asked.by_day else list
    for file in asked.files:
        samples += [Sample("linked"), *blank_samples()] if file == "blanks" else chosen(read_samples(Path(file)))
    seeds = asked.seed or [None]
    cases = [(one, stage, seed) for one in samples for stage in stages_of(one, asked.own or asked.write)
             for seed in (seeds if one.state == "right" else seeds[:1])]
    with ThreadPoolExecutor(2) as pool:
        verdicts = list(pool.map(lambda case: judge(asked, *case), cases))
    differences = [difference for difference, _ in verdicts if difference]
    wrong = [(one, diagnosis) for (one, stage, _), (_, diagnosis) in zip(cases, verdicts) if one.cause and one.verdict(stage)[0] == "wrong"]
    if "blanks" in asked.files and not asked.worker and ends_in_blanks(asked.executable) != ticks.exercised():
        differences.append(f"exercised.csv is stale; cmake --build {BUILD} --target answers makes it anew")
    if asked.write:
        rows = [answers.row_of(one, diagnosis) for one, diagnosis in wrong]
        answers.write_table(rows)
        print(*(f"{one} and {other} have one answer and two causes" for one, other in answers.ambiguous(rows)), sep="\n")
    named = [is_named(diagnosis) for _, diagnosis in wrong]
    alone = sum(is_named({**diagnosis, **diagnosis.get("judged", {})}) for _, diagnosis in wrong)
    print("\n".join(differences))
    print(f"{sum(one.state == 'right' for one in samples)} right samples and {len(wrong)} wrong ones, {len(cases)} verdicts, "
          f"{len(differences)} unexpected, named {sum(named)}, {alone} of them also without answers.csv")
    return 1 if differences or sum(named) < NAMED * len(named) else 0


if __name__ == "__main__":
    sys.exit(main())
