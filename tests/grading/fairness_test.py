"""Right and wrong submissions, made of the mistakes and samples, get their verdicts from the grader with three seeds: of
each stage a right one and a wrong one; with CH5_LONG=1 two and five, with CH5_LONG=all every one.
"""

import os
import unittest
from concurrent.futures import ThreadPoolExecutor

from tests.grading.one_stage import READY, Grader
from ch5_backend.course.base.cmake_build import CORES

from ch5_backend.course.homework.samples import source
from ch5_backend.course.homework.regions import FILES, STAGES
from tests.homework.run_samples import MARGIN, is_said
from tests.homework.samples import all_samples

RIGHT, WRONG = {"": (1, 1), "all": (999, 999)}.get(os.environ.get("CH5_LONG", ""), (2, 5))


def chosen() -> list:
    """[(sample, stage)]"""
    samples, cases = all_samples(), []
    for stage in STAGES:
        own = [(one, stage) for one in samples if stage in one.stages]
        cases += [case for case in own if case[0].state == "right"][:RIGHT]
        cases += [case for case in own if case[0].state != "right"][:WRONG]
    return cases


@unittest.skipUnless(READY, "no Clang: without ./course grade")
class Fairness(unittest.TestCase):
    def test_every_submission_gets_what_it_deserves_with_every_seed(self):
        grader, cases = Grader(), chosen()

        def verdicts_of(one, stage):
            return grader.verdicts(stage["file"], source(stage["file"], one.code).encode(), stage)

        self.assertEqual({stage["file"] for _, stage in cases}, set(FILES))
        with ThreadPoolExecutor(CORES) as pool:
            found = list(pool.map(lambda case: verdicts_of(*case), cases))
        for (one, stage), verdicts in zip(cases, found):
            state, wanted = one.verdict(stage)
            for verdict in verdicts:
                with self.subTest(sample=one.name, stage=stage["id"]):
                    self.assertEqual(verdict.state, state, verdict.diagnosis)
                    if "of_an_expression_that_has_gone" not in one.name:  # what it then holds is the compiler's choice
                        cause = verdict.diagnosis.get("cause", "")
                        self.assertTrue(is_said(wanted, state, cause), cause)
                    near = [test["name"] for test in verdict.tests if float(test.get("margin", 0)) > MARGIN]
                    self.assertEqual(near if state == "right" else [], [], "near a tolerance")
        right = sum(one.state == "right" for one, _ in cases)
        print(f"{right} right and {len(cases) - right} wrong submissions, {sum(map(len, found))} verdicts")
