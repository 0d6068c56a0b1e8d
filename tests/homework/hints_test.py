"""Hints come out of the handout, and a cause is named only when a failure comes again."""

import contextlib
import io
import unittest
from pathlib import Path
from unittest import mock

from tests.folder import FolderTest
from ch5_backend.course.homework.regions import STAGES

from ch5_backend.course.homework import check, hint, hint_policy
from ch5_backend.course.base.errors import CourseError
from ch5_backend.course.base.language import sentence, speaker
from ch5_backend.course.homework.diagnosis import Verdict, because, in_short, describe

DIAGNOSIS = {"stage": "1.1", "check": sentence("scene.H_of", what=sentence("1.1.one_edge_between_two_poses")),
             "expected": "(0, 6) = 2", "got": "(0, 6) = 0", "cause": sentence("assembly.mirror_missing"), "todo": "1.1b"}
RIGHT, ENGLISH = Verdict("right"), speaker("en")


def said(name, number, language="en"):
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        hint.show(name, number, language)
    return out.getvalue()


class Pages(unittest.TestCase):
    def test_who_is_right_is_told_of_the_part_without_a_todo(self):
        for stage in STAGES:
            goes_on = "the part without a TODO" in hint.page(stage, "en").read_text(encoding="utf-8")
            self.assertEqual("handout" in ENGLISH.text(check.next_step(stage, RIGHT)), goes_on, stage["id"])


class Hints(unittest.TestCase):
    def test_every_section_has_three_in_both_languages(self):
        for language in hint.SUFFIX:
            text = "".join(hint.page(stage, language).read_text(encoding="utf-8") for stage in STAGES).replace("`", "")
            sections = hint.handout(language)
            self.assertEqual(list(sections), [name for stage in STAGES for name in stage.get("sections", [stage["id"]])])
            for section in sections:
                for number in "123":
                    body = said(section, number, language).split("\n\n")[1]
                    self.assertGreater(len(body), 40)
                    self.assertIn(body, text)
                    self.assertNotRegex(body, r"[$\\`]", "a terminal sets neither formulas nor code")

    def test_a_todo_leads_to_its_section(self):
        self.assertEqual(said("1.2b", "2"), said("1.2", "2"))
        self.assertEqual(said("6g", "1"), said("6B", "1"))

    def test_a_stage_means_all_its_sections(self):
        self.assertEqual(said("6", "1"), said("6A", "1") + said("6B", "1"))
        self.assertEqual(said("1", "2"), said("1.1", "2") + said("1.2", "2"))
        self.assertEqual(said("Problem.cc", "2"), said("1", "2") + said("2", "2"))

    def test_check_finds_a_stage_by_its_todo_and_its_file_too(self):
        for name, stages in (("1.2", ["1.2"]), ("6A", ["6"]), ("1.1a", ["1.1"]), ("2e", ["2"]), ("ch5_homework/problem.cc", ["1.1", "1.2", "2"]),
                             ("1", ["1.1", "1.2"]), ("stage 3", ["3"]), ("Stage_1.1.zh.md", ["1.1"]), ("stage_1.cc", ["1.1", "1.2"]),
                             ("阶段2", ["2"]), ("1.2B", ["1.2"]), ("6a", ["6"]), ("6B", ["6"]), ("../Block_Solver.CC", ["7"]),
                             ("problem", ["1.1", "1.2", "2"]), ("open_tasks.cpp", ["8"])):
            self.assertEqual([stage["id"] for stage in check.select([name])], stages, name)
        self.assertEqual(check.select(["stage", "3"]), check.select(["3"]))
        self.assertEqual(said("stage_6.md", "1"), said("6", "1"))
        for name in ("99", "1.3", "", "homework/", "stage_99.md", "1.1z"):
            with self.assertRaises(CourseError, msg=name):
                check.select([name])

    def test_what_is_not_there_is_named(self):
        for words in (("99", "1"), ("6", "4"), ("1.2", "4"), ("1.2", "0"), ("1.2", "one"), ("", "1")):
            with self.assertRaises(CourseError, msg=words):
                hint.show(*words, "en")


class OtherNames(FolderTest):
    def said(self, state, **diagnosis):
        with mock.patch.object(check, "folder", lambda: self.folder):
            return in_short(check.with_namesake(Verdict(state, {"cause": "its cause", **diagnosis}), "problem.cc").diagnosis, ENGLISH)

    def test_check_names_the_file_that_may_hold_the_students_code(self):
        self.assertEqual(self.said("does-not-compile"), "its cause")
        for name in ("problem.cc.txt", "Problem.cc", "problem_final.cc"):
            (self.folder / name).write_text("")
            self.assertIn(f"but there is {name}", self.said("does-not-compile"))
            (self.folder / name).rename(self.folder / "vins_window.cc")
        (self.folder / "problem.cc.txt").write_text("")
        (self.folder / "problem.cc").write_text("")
        self.assertRegex(self.said("not-started"), "Only problem.cc is checked.* problem.cc.txt.* its cause")
        for verdict in (self.said("does-not-compile"), self.said("not-started", begun=True), self.said("wrong")):
            self.assertEqual(verdict, "its cause")


class Causes(FolderTest):
    def setUp(self):
        super().setUp()
        self.edits = 0
        patch = mock.patch.object(hint_policy, "BUILD", self.folder)
        patch.start()
        self.addCleanup(patch.stop)

    def shown(self, verdict, threshold=2, counts=True, content=None):
        """Whether the cause is there, in ./course check and in the line of ./course status; each time in another file."""
        self.edits += 1
        content = content or f"// edit {self.edits}".encode()
        diagnosis = hint_policy.hold_back(STAGES[0], verdict, threshold, content, counts).diagnosis
        named = ["mirrored" in words for words in (describe(diagnosis, ENGLISH), in_short(diagnosis, ENGLISH))]
        self.assertEqual(len(set(named)), 1, diagnosis)
        self.assertIn("TODO 1.1b", describe(diagnosis, ENGLISH))
        return named[0]

    def wrong(self, **changes):
        return Verdict("wrong", {**DIAGNOSIS, **changes})

    def test_the_second_failure_names_it(self):
        self.assertEqual([self.shown(self.wrong()) for _ in range(3)], [False, True, True])
        self.assertIn("./course hint 1.1 1", describe(hint_policy.hold_back(STAGES[0], self.wrong(), 9, b"").diagnosis, ENGLISH))

    def test_an_unchanged_file_is_the_same_failure(self):
        self.assertEqual([self.shown(self.wrong(), content=b"same") for _ in range(3)], [False, False, False])
        self.assertEqual([self.shown(self.wrong(), content=b"changed") for _ in range(2)], [True, True])

    def test_another_mistake_in_the_same_check_is_not_named_at_once(self):
        other = self.wrong(cause=sentence("assembly.only_one_triangle"))
        self.assertFalse(self.shown(self.wrong()))
        self.assertNotIn("cause", hint_policy.hold_back(STAGES[0], other, 2, b"other").diagnosis)

    def test_a_setting_names_it_at_once_or_later(self):
        self.assertTrue(self.shown(self.wrong(), threshold=1))
        self.assertEqual([self.shown(self.wrong(), threshold=4) for _ in range(3)], [False, False, True])

    def test_another_failure_and_a_right_stage_begin_anew(self):
        other = self.wrong(check=sentence("scene.H_of", what=sentence("1.1.cauchy_loss")))
        self.assertEqual([self.shown(each) for each in (self.wrong(), other, self.wrong())], [False, False, False])
        hint_policy.hold_back(STAGES[0], RIGHT, 2, b"")
        self.assertFalse(self.shown(self.wrong()))

    def test_looking_does_not_count(self):
        self.shown(self.wrong())
        self.assertEqual([self.shown(self.wrong(), counts=False) for _ in range(3)], [False, False, False])
        self.assertTrue(self.shown(self.wrong()))
        self.assertTrue(self.shown(self.wrong(), counts=False))

    def test_what_gives_nothing_away_is_told_at_once(self):
        for verdict in (RIGHT, Verdict("crashes", because("judge.crash", signal="", where="")),
                        self.wrong(cause=sentence("matrix.none_typical")), self.wrong(cause=sentence("matrix.still_empty", variable="H"))):
            self.assertEqual(hint_policy.hold_back(STAGES[0], verdict, 2, b""), verdict)

    def test_without_a_place_to_count_causes_are_named(self):
        with mock.patch.object(hint_policy, "BUILD", Path("/dev/null/nowhere")):
            self.assertTrue(self.shown(self.wrong()))

    def test_a_stage_of_two_sections_names_the_right_one(self):
        for todo, section in (("6a", "6A"), ("6j", "6B"), ("6k", "6B"), ("", "6A"), ("none", "6A")):
            self.assertEqual(hint.section_of("6", todo, hint.handout("en")), section)
