"""What a class gets wrong alike is shown without a student's name; and once the mistake has a name, all that were graded are told."""

import csv
import json
import re
import unittest
from contextlib import redirect_stdout
from unittest import mock

from tests.folder import FolderTest
from tests.grading.class_test import Terminal
from tests.grading.one_stage import READY
from tests.grading.languages_test import CHINESE, ENGLISH, record, words_of
from tests.homework.answers_test import with_table
from tests.homework.chinese import english_in
from ch5_backend.course.__main__ import main
from ch5_backend.course.base.errors import CourseError
from ch5_backend.course.base.language import sentence
from ch5_backend.course.grading import rename, summary, unnamed
from ch5_backend.course.grading.toolchain import Toolchain
from ch5_backend.course.homework import answers, samples
from ch5_backend.course.homework.diagnosis import Verdict
from ch5_backend.course.homework.regions import STAGES
from ch5_backend.course.homework.samples import read_mistakes, source

FINGERPRINT, NONE = [12, 12, 0.5, -4.0, 1.0], sentence("matrix.none_typical")
SIGN = next(one for one in read_mistakes() if one.name == "schur_sign")


def graded(name: str, fingerprint=FINGERPRINT, cause=NONE, **more) -> dict:
    """A record whose stage 1.1 has this answer."""
    one = record(name)
    one["stages"][0]["diagnosis"] = {**one["stages"][0]["diagnosis"], "cause": cause, "fingerprint": fingerprint, **more}
    one["stages"][0]["lines"] = "H.block(i, j) += <hessian>;"
    return one


def groups(*records) -> list:
    return [group.names for group in unnamed.groups_of(list(records), ENGLISH)]


class Groups(FolderTest):
    def test_equal_answers_without_a_name_are_one_row(self):
        near = [12, 12, 0.5, -4.0, 1.0 + 1e-7]
        self.assertEqual(groups(graded("a"), graded("b", near), graded("c", [12, 12, 0.5, -4.0, 1.1]), graded("d")), [["a", "b", "d"]])

    def test_the_largest_is_first(self):
        other = [12, 12, 7.0, 0.0, 0.0]
        self.assertEqual(groups(graded("a"), graded("b"), *(graded(name, other) for name in "cde")), [["c", "d", "e"], ["a", "b"]])

    def test_what_has_a_name_or_no_answer_is_in_none(self):
        sign = sentence("formula.sign_added", term="H")
        self.assertEqual(groups(graded("a", cause=sign), graded("b", cause=sign)), [])
        self.assertEqual(groups(graded("a", usual={"stage": "1.1", "check": "c"}), graded("b", usual={"stage": "1.1", "check": "c"})), [])
        self.assertEqual(groups(record("a"), record("b")), [])

    def test_answers_are_compared_with_the_usual_random_numbers(self):
        usual = {key: graded("x")["stages"][0]["diagnosis"][key] for key in ("stage", "check", "expected", "got", "fingerprint")}
        self.assertEqual(groups(graded("a", [12, 12, 1.0, 1.0, 1.0], usual=usual), graded("b", [9, 9, 2.0, 2.0, 2.0], usual=usual)), [["a", "b"]])

    def test_the_table_and_the_page_show_the_numbers_and_no_student(self):
        points = {row["id"]: row["points"] for row in record()["stages"]}
        for say in (ENGLISH, CHINESE):
            summary.write(self.folder, [graded("jane"), graded("joe")], points, None, [], [], say)
            page = (self.folder / "summary.html").read_text(encoding="utf-8")
            part = page[page.index(say("grade.unnamed")):].partition("<h2>")[0]
            self.assertIn("(0, 6) = 2.5", part)
            self.assertIn("&lt;hessian&gt;", part)
            self.assertNotRegex(part, "jane|joe")
        self.assertEqual(english_in(words_of(self.folder / "summary.html").replace("H.block(i, j) += <hessian>;", "")), "")
        rows = list(csv.DictReader((self.folder / "unnamed.csv").read_text(encoding="utf-8").splitlines()))
        self.assertEqual([(row["students"], row["stage"], row["expected"], row["todo"], row["lines"]) for row in rows],
                         [("2", "1.1", "(0, 6) = 2.5", "1.1b", "H.block(i, j) += <hessian>;")])

    def test_an_excerpt_is_of_the_blank_and_without_comments(self):
        stage = next(stage for stage in STAGES if stage["id"] == "1.2")
        text = re.sub(r"(b_pp_schur_ = .*)", r"\1  // by Jane Doe\n/* Jane\nDoe */", source("problem.cc", SIGN.code))
        found = unnamed.excerpt(stage, text.encode(), "1.2b")
        self.assertIn(") + tempH", found)
        self.assertNotRegex(found, "Jane|Doe|delta_x_ll")
        self.assertIn("delta_x_ll", unnamed.excerpt(stage, text.encode(), ""))
        self.assertEqual(unnamed.excerpt(stage, b"\xff\x00" * 100, "1.2b"), "")


class Renamed(FolderTest):
    CAUSE = sentence("formula.sign_added", term="H")

    def records(self, *ones) -> None:
        for one in ones:
            (self.folder / one["name"]).mkdir()
            (self.folder / one["name"] / "record.json").write_text(json.dumps(one), encoding="utf-8")

    def cause(self, name: str) -> tuple:
        diagnosis = json.loads((self.folder / name / "record.json").read_text(encoding="utf-8"))["stages"][0]["diagnosis"]
        return diagnosis["cause"], diagnosis["todo"]

    def row(self, todo: str) -> answers.Row:
        diagnosis = graded("x")["stages"][0]["diagnosis"]
        return answers.Row("new", "code", todo, self.CAUSE, {}, "1.1", diagnosis["check"], FINGERPRINT)

    def test_records_get_the_name_and_lose_it_with_the_mistake(self):
        self.records(graded("a"), graded("b", [12, 12, 9.0, 9.0, 9.0]))
        with with_table(self.row("1.1c 1.1a")):
            self.assertEqual(rename.rename_all(self.folder), ["a"])
            self.assertEqual(rename.rename_all(self.folder), [])
        self.assertEqual((self.cause("a"), self.cause("b")), ((self.CAUSE, "1.1a"), (NONE, "1.1b")))
        with with_table():
            rename.rename_all(self.folder)
        self.assertEqual(self.cause("a"), (NONE, "1.1b"))

    def learned(self, verdict: Verdict, missing=("schur_sign",)) -> tuple:
        """What is run where these mistakes are missing in the table, and the table then."""
        rows, ran = answers.read_table(), []
        run = lambda toolchain, worker, stage, seed, clock, fail_fast: ran.append((stage["id"], seed)) or verdict
        with mock.patch.object(answers, "TABLE", self.folder / "answers.csv"), mock.patch.object(rename, "run_stage", side_effect=run):
            answers.write_table([row for row in rows if row.mistake not in missing])
            learned = rename.learn(mock.Mock(compile=lambda *_: mock.Mock(verdict=None)))
            return learned, ran, answers.read_table(), rows

    def test_only_what_is_new_is_run(self):
        old = next(row for row in answers.read_table() if row.mistake == "schur_sign")
        verdict = Verdict("wrong", {"stage": "1.2", "check": old.check, "cause": old.judged, "todo": "1.2b",
                                    "fingerprint": old.fingerprint})
        learned, ran, now, before = self.learned(verdict)
        self.assertEqual((learned, ran, now), (["schur_sign"], [("1.2", None)], before))

    def test_a_mistake_that_is_none_is_refused(self):
        with self.assertRaisesRegex(CourseError, "schur_sign should be wrong, but its state is right"):
            self.learned(Verdict("right"))

    def test_two_names_for_one_answer_are_said(self):
        other = next(row for row in answers.read_table() if row.mistake == "b_sign")
        verdict = Verdict("wrong", {"stage": "1.2", "check": other.check, "cause": other.judged, "todo": "1.2b",
                                    "fingerprint": other.fingerprint})
        with mock.patch.object(rename, "warn") as warn:
            self.learned(verdict)
        self.assertIn("one answer", " ".join(call.args[0] for call in warn.call_args_list).replace("the same answer", "one answer"))


@unittest.skipUnless(READY, "no Clang: without ./course grade")
class FromTheTableToThePage(FolderTest):
    """As GRADING.md tells it, with a mistake that has no name."""
    ENTRY = "// MISTAKE corner 2.b_before_move\n// CHANGE 2d H_prior = Arr => Arr(0, 0) += 0.123; H_prior = Arr\n"

    def grade(self, *words) -> str:
        with redirect_stdout(Terminal()) as said:
            self.assertEqual(main(["grade", "--out", str(self.folder / "out"), "--language", "en", *map(str, words)]), 0)
        return said.getvalue()

    def pages(self) -> list:
        return [words_of(self.folder / "out" / name / "feedback.html") for name in ("jane", "joe")]

    def test_a_shared_answer_gets_its_name(self):
        (self.folder / "stage_2.mistakes").write_text(self.ENTRY, encoding="utf-8")
        self.addCleanup(answers.known.cache_clear)
        with mock.patch.object(samples, "MISTAKES", self.folder), mock.patch.object(answers, "TABLE", self.folder / "answers.csv"):
            answers.known.cache_clear()
            corner, = read_mistakes()
            for name in ("jane", "joe"):
                (self.folder / name).mkdir()
                (self.folder / name / "problem.cc").write_text(f"{source('problem.cc', corner.code)}// {name}\n", encoding="utf-8")
            self.grade(self.folder / "jane", self.folder / "joe", "--stages", "2")
            row, = csv.DictReader((self.folder / "out" / "unnamed.csv").read_text(encoding="utf-8").splitlines())
            self.assertEqual((row["students"], row["stage"]), ("2", "2"))
            self.assertIn("Arr(0, 0) += 0.123;", row["lines"])
            self.assertNotIn("made from the b before", "".join(self.pages()))
            grades = (self.folder / "out" / "grades.csv").read_bytes()
            with mock.patch.object(Toolchain, "compile", autospec=True, side_effect=Toolchain.compile) as compiled:
                self.assertIn("answers.csv: corner.", self.grade("--rename", "--out", self.folder / "empty"))  # nothing graded there
                self.grade("--rename")
            self.assertEqual(compiled.call_count, 1, "the entry alone")
            for page in self.pages():
                self.assertIn("b_prior is made from the b before the move", page)
            self.assertEqual((self.folder / "out" / "grades.csv").read_bytes(), grades)
            self.assertEqual(len((self.folder / "out" / "unnamed.csv").read_text(encoding="utf-8").splitlines()), 1)
