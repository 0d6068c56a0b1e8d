"""A wrong answer gets the name of the mistake that gives it, and no other one; ch5_homework/mistakes/answers.csv tells nobody more."""

import re
import unittest
from pathlib import Path
from unittest import mock

from tests.folder import FolderTest
from tests.project import ROOT
from ch5_backend.course.base.language import sentence, speaker
from ch5_backend.course.homework import answers, judge as judging
from ch5_backend.course.homework.diagnosis import Verdict
from ch5_backend.course.homework.samples import Sample, read_mistakes, read_samples

CHECK, SIGN, HALF = sentence("scene.H_of", what="a"), sentence("matrix.sign"), sentence("matrix.factor", k="0.5")
FINGERPRINT = [2, 3, 0.5, -4.0]
SEEN = sentence("matrix.nearly", difference="1e-5")  # by the judge alone
ELSEWHERE = {"id": "formula.starts_at", "i": "0"}


def row(name: str, cause: dict, fingerprint=FINGERPRINT, todo: str = "1.1a") -> answers.Row:
    return answers.Row(name, "code", todo, cause, SEEN, "1.1", CHECK, fingerprint)


def diagnosis(fingerprint=FINGERPRINT, **more) -> dict:
    return {"stage": "1.1", "check": CHECK, "cause": SEEN, "todo": "1.1b", "fingerprint": fingerprint, **more}


def with_table(*rows):
    return mock.patch.object(answers, "known", return_value=answers.by_check(rows))


class Names(unittest.TestCase):
    def test_an_answer_gets_the_name_of_its_mistake(self):
        with with_table(row("sign", SIGN), row("half", HALF, [2, 3, 0.5, -2.0])):
            found = answers.named(given := diagnosis([2, 3, 0.5 + 1e-6, -4.0]), given)
        self.assertEqual((found["cause"], found["todo"]), (SIGN, "1.1a"))

    def test_another_answer_keeps_what_the_judge_sees(self):
        for other in ([2, 3, 0.5, -4.001], [3, 2, 0.5, -4.0], [2, 3, -0.5, 4.0]):
            with with_table(row("sign", SIGN)):
                self.assertEqual(answers.named(given := diagnosis(other), given), given)
        for other in ({"check": sentence("scene.b_of", what="a")}, {"stage": "7"}, {"cause": HALF}):
            with with_table(row("sign", SIGN)):
                self.assertEqual(answers.named(given := diagnosis(**other), given), given)

    def test_of_two_causes_for_one_answer_none_is_told(self):
        rows = row("sign", SIGN), row("half", HALF)
        with with_table(*rows):
            self.assertEqual(answers.named(given := diagnosis(), given), given)
        self.assertEqual(answers.ambiguous(rows), [("half", "sign")])

    def test_two_mistakes_with_one_cause_are_told_without_a_place_unless_it_is_one(self):
        with with_table(row("a", SIGN), row("b", SIGN, todo="1.1c")):
            found = answers.named(given := diagnosis(), given)
        self.assertEqual((found["cause"], found["todo"]), (SIGN, "1.1b"))

    def test_what_is_not_finite_has_no_name(self):
        with with_table(row("none", SIGN, [])):
            self.assertEqual(answers.named({"stage": "1.1", "check": CHECK}, {"stage": "1.1", "check": CHECK}), {"stage": "1.1", "check": CHECK})

    def test_a_recorded_diagnosis_is_named_anew(self):
        usual, own = diagnosis(), diagnosis([2, 3, 7.0, 7.0], expected="of the seed")
        with with_table():
            unnamed = answers.named(own, usual)
        with with_table(row("sign", SIGN)):
            found = answers.named_anew(unnamed)
            self.assertEqual((found["cause"], found["expected"]), (SIGN, "of the seed"))
        with with_table(row("half", HALF)):
            self.assertEqual(answers.named_anew(found)["cause"], HALF)
        with with_table():
            self.assertEqual(answers.named_anew(found), unnamed)


class Seeds(unittest.TestCase):
    """With a seed the verdict is the seed's, and the name that of the usual random numbers."""

    def judged(self, own: Verdict, usual: Verdict) -> Verdict:
        runs = lambda executable, stage, time_limit, options, *rest: own if "--seed=3" in options else usual
        with mock.patch.object(judging, "run_tests", side_effect=runs), with_table(row("sign", SIGN)):
            return judging.judge(Path("judge"), {}, options=["--seed=3", "--time-limit=10"])

    def test_the_name_is_that_of_the_usual_random_numbers(self):
        tests = ({"name": "A", "failures": ["…"]},)
        of_seed = Verdict("wrong", diagnosis([2, 3, 7.0, 7.0], expected="of the seed"), tests=tests)
        told = self.judged(of_seed, Verdict("wrong", diagnosis(), tests=tests))
        self.assertEqual((told.diagnosis["cause"], told.diagnosis["expected"]), (SIGN, "of the seed"))
        elsewhere = self.judged(of_seed, Verdict("wrong", diagnosis(), tests=({"name": "B", "failures": ["…"]},)))
        self.assertEqual(elsewhere.diagnosis["cause"], SEEN)

    def test_it_never_changes_a_verdict(self):
        for own in (Verdict("right"), Verdict("crashes")):
            self.assertEqual(self.judged(own, Verdict("wrong", diagnosis())), own)
        own = Verdict("wrong", diagnosis([2, 3, 7.0, 7.0]), tests=({"name": "A", "failures": ["…"]},))
        self.assertEqual(self.judged(own, Verdict("right")), own)


class OtherCalls(unittest.TestCase):
    """A slip that explains the first wrong answer is the cause unless another answer refutes it."""

    def judged(self, tests: list, **more) -> tuple:
        found = Verdict("wrong", {**diagnosis(formula="A − B", symptom=HALF, **more), "cause": more.get("cause", ELSEWHERE)})
        return judging.with_a_cause_of_all_calls(found, lambda option: self.asked.append(option) or tests).diagnosis["cause"]

    def test_it_is_withdrawn_where_another_answer_refutes_it(self):
        self.asked = []
        self.assertEqual(self.judged([{"name": "A"}, {"name": "B"}]), ELSEWHERE)
        self.assertEqual(self.judged([{"name": "A"}, {"name": "B", "refuted": "true"}]), HALF)
        self.assertEqual(self.asked, ['--explains=A − B={"id": "formula.starts_at", "i": "0"}'] * 2)

    def test_of_a_named_mistake_of_other_slips_and_of_none_nothing_is_asked(self):
        self.asked = []
        self.assertEqual(self.judged([{"refuted": "true"}], judged={}), ELSEWHERE)
        self.assertEqual(self.judged([{"refuted": "true"}], cause=SIGN), SIGN)  # a slip of few
        own = Verdict("wrong", diagnosis())
        self.assertEqual(judging.with_a_cause_of_all_calls(own, self.asked.append), own)
        self.assertEqual(self.asked, [])


class Table(FolderTest):
    def test_it_is_read_as_it_was_written(self):
        rows = [row("sign", SIGN, [2.0, 3.0, 0.5, -4.0]), row("none", HALF, [])]
        with mock.patch.object(answers, "TABLE", self.folder / "answers.csv"):
            self.assertEqual(answers.read_table(), [])
            answers.write_table(rows)
            self.assertEqual(answers.read_table(), rows)

    def test_each_mistake_has_a_row_and_each_row_its_mistake(self):
        mistakes = {one.name: one for one in read_mistakes() if one.state == "wrong"}
        self.assertEqual([row.mistake for row in answers.read_table()], list(mistakes))
        for one in answers.read_table():
            self.assertEqual((one.code, one.cause), (answers.hash_of(mistakes[one.mistake].code), mistakes[one.mistake].cause), one.mistake)

    def test_no_two_mistakes_have_one_name(self):
        names = [one.name for one in read_mistakes()]
        self.assertEqual(len(names), len(set(names)))


class Entries(FolderTest):
    def read(self, text: str) -> list:
        (self.folder / "a.mistakes").write_text(text, encoding="utf-8")
        return read_samples(self.folder / "a.mistakes")

    def test_an_entry_says_its_cause_and_its_change(self):
        one, = self.read("// MISTAKE sign formula.sign_added\n//   term: H_pm x\n// CHANGE 1.2b ) - tempH => ) + tempH\n")
        self.assertEqual((one.name, one.state, one.todo), ("sign", "wrong", "1.2b"))
        self.assertEqual(one.cause, sentence("formula.sign_added", term="H_pm x"))
        self.assertIn(") + tempH", one.code["REGION 1.2b"])

    def test_a_sentence_within_a_sentence(self):
        one, = self.read("// MISTAKE zero 7.number_0_left_out\n//   it: scene.pose\n//   it.n: 0\n// REGION 7d\nreturn;\n")
        self.assertEqual(one.cause, sentence("7.number_0_left_out", it=sentence("scene.pose", n="0")))

    def test_what_ends_otherwise_and_what_is_right(self):
        crash, right = self.read("// MISTAKE out crashes eigen.block_outside\n// CHANGE 1.2b ) - tempH => )\n// SAMPLE fine\n// REGION 1.2b\n")
        self.assertEqual((crash.state, crash.cause), ("crashes", sentence("eigen.block_outside")))
        self.assertEqual(right, Sample("fine", code={"REGION 1.2b": ""}, todo="1.2b"))

    def test_the_page_shows_an_entry_as_it_is(self):
        entries = (ROOT / "ch5_homework" / "mistakes" / "stage_2.mistakes").read_text(encoding="utf-8")
        for page, language in (("GRADING.md", "en"), ("GRADING.zh.md", "zh")):
            text = (ROOT / "ch5_homework" / page).read_text(encoding="utf-8")
            entry = re.search(r"// MISTAKE (\w+) (\S+)\n(?: *// CHANGE .*\n)+", text)
            self.assertIn(re.sub(r"^ +", "", entry[0], flags=re.MULTILINE), entries)
            self.assertIn(f'"{speaker(language)(entry[2])}"', text)
            self.assertIn(speaker(language)(entry[2]) + "\n", text)

    def test_a_slip_in_an_entry_is_told_with_its_line(self):
        for text, told in (("// MISTAKE sign formula.no_such_sentence\n", "a.mistakes:1: there is no such sentence: formula.no_such_sentence"),
                           ("// MISTAKE a matrix.sign\n// CHANGE 1.2b no_such_text => x\n", "a.mistakes:2: the solution of 1.2b has this 0 times, not once: no_such_text"),
                           ("// MISTAKE a matrix.sign\n// CHANGE 1.2z a => b\n", "a.mistakes:2: no such region: 1.2z"),
                           ("lost\n", "a.mistakes:1: code outside of a region: lost")):
            with self.assertRaisesRegex(ValueError, told):
                self.read(text)
