"""./course predict: what is asked is the handout's, what is kept is told when the stage is right, and nothing kept is lost."""

import os
import re
import subprocess

from ch5_backend.course.base.language import speaker
from ch5_backend.course.homework.predict import NAME, QUESTIONS, asked_in, compared, numbers_in
from ch5_backend.course.homework.regions import STAGES
from tests.folder import FolderTest
from tests.homework.chinese import english_in
from tests.project import ROOT, run


class Predict(FolderTest):
    def predict(self, lines: str, *words) -> subprocess.CompletedProcess:
        return run(ROOT / "course", "predict", *words, input=lines, env={**os.environ, "LC_ALL": "C.UTF-8", "CH5_CHECK_FOLDER": str(self.folder)})

    def kept(self) -> str:
        return (self.folder / NAME).read_text(encoding="utf-8")

    def told(self, stage: str, state: str) -> list:
        return compared(next(row for row in STAGES if row["id"] == stage), state, self.folder, speaker("en"))

    def test_every_stage_asks_and_its_numbers_are_the_handouts(self):
        """Which worked_numbers_test.py compares with the solvers'."""
        self.assertEqual(list(QUESTIONS), [stage["id"] for stage in STAGES])
        for stage in STAGES:
            for language, page in (("en", f"stage_{stage['id']}.md"), ("zh", f"stage_{stage['id']}.zh.md")):
                text = (ROOT / "ch5_homework/handout" / page).read_text(encoding="utf-8")
                self.assertNotRegex(asked_in(stage, language), r"[$\\]", "a terminal sets no formulas")
                answer = text.partition(asked_in(stage, language))[2].partition("</details>")[0]
                for right in QUESTIONS[stage["id"]].values():
                    written = [float(word) for word in re.findall(r"-?[\d.]*\d", answer.replace("−", "-"))]
                    for number in right:
                        self.assertTrue(any(abs(number - found) <= 2e-3 * max(1, abs(number)) for found in written), (page, number))

    def test_what_is_kept_is_compared_once_the_stage_is_right(self):
        self.assertEqual(self.told("1.1", "not-started"), ["Before you begin, say what you expect: ./course predict 1.1"])
        done = self.predict("36\n2\n", "1.1")
        self.assertEqual((done.returncode, done.stderr, self.kept()), (0, "", "rows_of_H,36\nzero_blocks_of_H,2\n"))
        for state in ("not-started", "wrong"):
            self.assertEqual(self.told("1.1", state), [])
        wrong, right = self.told("1.1", "right")
        self.assertEqual(wrong, "✗ Rows of H: 36 was predicted; it is 38. The handout says why.")
        self.assertRegex(right, "^✓ .* 2, as predicted$")

    def test_the_first_prediction_stays(self):
        self.predict("36\n2\n", "1.1")
        again = self.predict("38\n2\n", "1.1")
        self.assertEqual((again.returncode, self.kept()), (0, "rows_of_H,36\nzero_blocks_of_H,2\n"))
        self.assertIn("  36\n", again.stdout)

    def test_it_goes_on_where_it_was_left(self):
        done = self.predict("1/0\nmany\n38\n", "stage 1.1")
        self.assertEqual((done.returncode, self.kept(), done.stdout.count("numbers needed: 1")), (1, "rows_of_H,38\n", 2))
        self.assertEqual(self.predict("2\n").returncode, 0)
        self.assertEqual(self.kept(), "rows_of_H,38\nzero_blocks_of_H,2\n")
        self.assertIn("1.2 · ", self.predict("").stdout)
        self.assertEqual(self.predict("\n", "1.2").returncode, 1, "an empty line is no prediction")

    def test_where_nothing_is_predicted_nothing_is_kept(self):
        done = self.predict("\n", "1.1")
        self.assertEqual((done.returncode, NAME in done.stdout, (self.folder / NAME).exists()), (1, False, False))

    def test_fractions_and_other_minus_signs_are_numbers(self):
        self.assertEqual(numbers_in("−1/4, 2"), [-0.25, 2])
        self.assertIsNone(numbers_in("1/0"))

    def test_a_line_that_cannot_be_read_is_named_and_stays(self):
        (self.folder / NAME).write_text("rows_of_H,38\nnonsense\nzero_blocks_of_H,two\n", encoding="utf-8")
        done = self.predict("2\n", "1.1")
        self.assertEqual(done.returncode, 0)
        self.assertIn(f"{NAME}:2: not a prediction, left out: nonsense", done.stderr)
        self.assertIn(f"{NAME}:3: not a prediction, left out: zero_blocks_of_H,two", done.stderr)
        self.assertEqual(self.kept(), "rows_of_H,38\nnonsense\nzero_blocks_of_H,two\nzero_blocks_of_H,2\n")
        self.assertEqual(self.predict("", "12").returncode, 2)

    def test_it_is_asked_in_chinese(self):
        for stage in STAGES:
            done = self.predict("", stage["id"], "--language", "zh")
            self.assertEqual(english_in(done.stdout.replace(NAME, "")), "", done.stdout)
