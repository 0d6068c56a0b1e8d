"""A student who has filled a blank and left its throw is told so: "not started" alone would be a riddle."""

import tempfile
import unittest
from pathlib import Path

from ch5_backend.course.homework.make_skeleton import skeleton
from ch5_backend.course.homework.regions import FILES, STAGES, fill, solution_text

from ch5_backend.course.base.language import speaker
from ch5_backend.course.homework import blanks, check, judge
from ch5_backend.course.homework.diagnosis import Verdict


class ThrowLeft(unittest.TestCase):
    def keeps_throw(self, text: str, todo: str) -> bool:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "file.cc"
            path.write_text(text, encoding="utf-8")
            return blanks.keeps_throw(path, todo)

    def test_lines_above_the_throw_are_seen(self):
        for name in FILES:
            left = fill(solution_text(name), lambda region: region.solution + region.blank())
            for todo in (todo for stage in STAGES if stage["file"] == name for todo in stage["todos"]):
                self.assertTrue(self.keeps_throw(left, todo), todo)
                self.assertFalse(self.keeps_throw(skeleton(name), todo), todo)
                self.assertFalse(self.keeps_throw(solution_text(name), todo), todo)

    def test_the_next_step_says_delete_it(self):
        say, stage, verdict = speaker("en"), STAGES[0], Verdict("not-started", judge.not_started("1.1a", ""))
        self.assertIn("Search problem.cc", say.text(check.next_step(stage, verdict)))
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "problem.cc").write_text(fill(solution_text("problem.cc"), lambda r: r.solution + r.blank()),
                                                  encoding="utf-8")
            self.addCleanup(setattr, check, "HOMEWORK", check.HOMEWORK)
            check.HOMEWORK = Path(folder)
            self.assertIn("throw below them: delete it", say.text(check.next_step(stage, verdict)))
