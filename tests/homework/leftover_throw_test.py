"""A student who has filled a blank and left its throw is told so: "not started" alone would be a riddle."""

import unittest

from ch5_backend.course.homework.make_skeleton import skeleton
from ch5_backend.course.homework.regions import FILES, STAGES, fill, solution_text

from ch5_backend.course.base.language import speaker
from ch5_backend.course.homework import blanks, check, judge
from ch5_backend.course.homework.diagnosis import Verdict, cause_of


class ThrowLeft(unittest.TestCase):
    def keeps_throw(self, text: str, todo: str) -> bool:
        return blanks.keeps_throw(text.encode(), todo)

    def test_lines_above_the_throw_are_seen(self):
        for name in FILES:
            left = fill(solution_text(name), lambda region: region.solution + region.blank())
            for stage, todo in ((stage, todo) for stage in STAGES if stage["file"] == name for todo in stage["todos"]):
                self.assertTrue(self.keeps_throw(left, todo), todo)
                self.assertFalse(self.keeps_throw(skeleton(name), todo), todo)
                self.assertFalse(self.keeps_throw(solution_text(name), todo), todo)
                verdict = blanks.explain(Verdict("not-started", judge.not_started(todo, "")), stage, left.encode())
                self.assertEqual(cause_of(verdict.diagnosis), "judge.leftover_throw")

    def test_a_mistake_belongs_to_a_blank_that_the_file_has(self):
        verdict = Verdict("wrong", {**judge.because("formula.sign_of_b"), "todo": "1.1d 1.1b"})
        for depth, todo in ((1, "1.1b"), (2, "1.1d"), (3, "1.1d")):
            told = blanks.explain(verdict, STAGES[0], skeleton("problem.cc", depth=depth).encode())
            self.assertEqual(told.diagnosis["todo"], todo)

    def test_a_stage_of_which_one_blank_is_filled_is_half_done(self):
        stage = STAGES[0]
        self.assertFalse(blanks.some_filled(stage, skeleton("problem.cc").encode()))
        one = fill(solution_text("problem.cc"), lambda region: region.solution if region.todo == "1.1a" else region.blank())
        self.assertTrue(blanks.some_filled(stage, one.encode()))
        deep = skeleton("problem.cc", depth=2)
        self.assertFalse(blanks.some_filled(stage, deep.encode()))
        self.assertTrue(blanks.some_filled(stage, deep.replace('throw HomeworkMissing("1.1c', 'hessian = ("').encode()))
        half = blanks.explain(Verdict("not-started", judge.not_started("1.1b", "")), stage, one.encode())
        self.assertEqual(check.state_of(half, speaker("en")), "half-done")
