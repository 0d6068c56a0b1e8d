"""Right and wrong submissions, made of tests/homework/samples, get their verdicts from the grader with three seeds: of
each stage a right one and a wrong one; with CH5_LONG=1 two and five, with CH5_LONG=all every one.
"""

import os
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tests.grading.one_stage import READY, Grader
from ch5_backend.course.base.build import CORES

HOMEWORK = Path(__file__).resolve().parents[1] / "homework"
from tests.homework.samples import Sample, read_samples, sections
from ch5_backend.course.homework.regions import FILES, STAGES, fill, regions, solution_text, stage_of
from tests.homework.run_samples import MARGIN, said_in

RIGHT, WRONG = {"": (1, 1), "all": (999, 999)}.get(os.environ.get("CH5_LONG", ""), (2, 5))


def stages_of(one: Sample) -> list:
    """The stages of whose code it changes something."""
    places = {key.split()[1] for key in one.code}
    return [stage for stage in STAGES if places & {stage["id"], *stage["todos"], *stage.get("deep", [])}]


def file_of(one: Sample) -> tuple:
    """The homework's file that it belongs to, filled in as it says."""
    def filled(section: str) -> str:
        whole = one.code.get(f"STAGE {stage_of(regions(section)[0].todo)['id']}")
        return "".join(whole) if whole else fill(
            section, lambda region: "".join(one.code.get(f"REGION {region.todo}", region.solution)))
    name = stages_of(one)[0]["file"]
    text = solution_text(name)
    for section in sections(text):
        text = text.replace(section, filled(section))
    return name, text.encode()


def chosen() -> list:
    """[(sample, stage)]"""
    corpus = sorted((HOMEWORK / "samples").glob("*.samples"), key=lambda path: (path.stem == "deep", path))
    samples = [one for path in corpus for one in read_samples(path)]
    cases = []
    for stage in STAGES:
        own = [(one, stage) for one in samples if stage in stages_of(one)]
        cases += [case for case in own if not case[0].expected][:RIGHT]
        cases += [case for case in own if stage["id"] in case[0].expected][:WRONG]
    return cases


@unittest.skipUnless(READY, "no Clang: without ./course grade")
class Fairness(unittest.TestCase):
    def test_every_submission_gets_what_it_deserves_with_every_seed(self):
        grader, cases = Grader(), chosen()
        self.assertEqual({stage["file"] for _, stage in cases}, set(FILES))
        with ThreadPoolExecutor(CORES) as pool:
            found = list(pool.map(lambda case: grader.verdicts(*file_of(case[0]), case[1]), cases))
        for (one, stage), verdicts in zip(cases, found):
            state, wanted = one.verdict(stage["id"])
            for verdict in verdicts:
                with self.subTest(sample=one.name, stage=stage["id"]):
                    self.assertEqual(verdict.state, state, verdict.diagnosis)
                    if "of_an_expression_that_has_gone" not in one.name:  # what it then holds is the compiler's choice
                        self.assertLessEqual(set(wanted.split()), said_in(verdict.diagnosis.get("cause", "")))
                    near = [test["name"] for test in verdict.tests if float(test.get("margin", 0)) > MARGIN]
                    self.assertEqual(near if state == "right" else [], [], "near a tolerance")
        right = sum(stage["id"] not in one.expected for one, stage in cases)
        print(f"{right} right and {len(cases) - right} wrong submissions, {sum(map(len, found))} verdicts")
