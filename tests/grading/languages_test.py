"""What ./course grade writes for students and instructors is in the language asked for, and that is no part of a grade."""

import html
import json
import re
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

from tests.folder import FolderTest
from tests.project import ROOT
from ch5_backend.course.grading import grade as grading, outputs, pages, summary
from ch5_backend.course.grading.sandbox import Unguarded
from ch5_backend.course.base.language import sentence, speaker
from ch5_backend.course.homework.diagnosis import because
from ch5_backend.course.homework.judge import not_started

from tests.homework.chinese import english_in

DIAGNOSIS = {"stage": "1.1", "check": sentence("scene.H_of", what=sentence("1.1.one_edge_between_two_poses")),
             "expected": "(0, 6) = 2.5", "got": sentence("matrix.worst_entry", entry="(0, 6) = 0", wrong="36", all="144"),
             "cause": sentence("assembly.mirror_missing"), "todo": "1.1b",
             "places": [[sentence("diagnosis.row", n="0"), sentence("scene.row_of", vertex="VertexPose 0", component="δp.x")]]}
CHINESE, ENGLISH = speaker("zh"), speaker("en")
STAGES = json.loads((ROOT / "ch5_homework" / "stages.json").read_text(encoding="utf-8"))["stages"]


def row(stage: dict, state: str, diagnosis: dict = {}, picture: str = "") -> dict:
    check = next(iter(stage["checks"]))
    checks = [{"name": check, "points": 2, "score": 2 * (state == "right"), "passed": state == "right"}]
    return {**{key: stage[key] for key in ("id", "name", "file")}, "state": state, "diagnosis": diagnosis, "output": "",
            "printed": "", "score": 2 * (state == "right"), "points": 2, "checks": checks, "picture": picture,
            "margins": {check: 0.5}, "seconds": 1.0}


def record(name: str = "s1") -> dict:
    """One of every state."""
    crash = {"signal": {"quoted": "Segmentation fault"}, "where": sentence("judge.at_place", place="gauge_freedom.cc:3")}
    verdicts = [("wrong", DIAGNOSIS, "ox/xo"), ("right",), ("not-started", not_started("2a", "TestMarginalize, moving the rows")),
                ("missing", because("submission.file_missing", file="gauge_prior.cc")), ("crashes", because("judge.crash", **crash)),
                ("times-out", because("judge.does_not_end", n="10", where=sentence("judge.in_test", test="Stage5.A"))),
                ("does-not-compile", because("compiler.utf16", file="vins_window.cc"))]
    return {"name": name, "key": "k", "content": "same", "seed": 7, "status": "graded", "score": 2, "points": 14,
            "faults": [sentence("submission.file_twice", file="problem.cc")], "seconds": 3.0,
            "cpu_seconds": 2.0, "peak_mib": 300, "fingerprint": {},
            "stages": [row(stage, *verdict) for stage, verdict in zip(STAGES, verdicts)]}


def words_of(path: Path) -> str:
    text = re.sub(r"<(style|script)>.*?</\1>", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    return html.unescape(re.sub(r"<[^>]*>", "\n", text))


class Pages(FolderTest):
    def test_a_students_page_is_chinese(self):
        pages.write_feedback(self.folder, record(), CHINESE)
        text, words = (self.folder / "feedback.html").read_text(encoding="utf-8"), words_of(self.folder / "feedback.html")
        self.assertIn('<html lang="zh">', text)
        self.assertEqual(english_in(words), "")
        for part in ("2 分（满分 14 分）", "(0, 6) = 2.5", "缺少镜像块", "橙色的元素不对", "提示 3：只差一步", "段错误", "./course check --seed 7",
                     "problem.cc 不止一个；以最靠外的那个为准。"):
            self.assertIn(part, words)

    def test_hints_are_set(self):
        pages.write_feedback(self.folder, record(), ENGLISH)
        hints = re.findall(r"<p>(.*)</p></details>", (self.folder / "feedback.html").read_text(encoding="utf-8"))
        self.assertIn("<code>J_iᵀ W J_j</code>", hints[0])
        self.assertIn("<em>both</em>", "".join(hints))
        self.assertFalse(re.search("[`*]", re.sub("<code>.*?</code>", "", "".join(hints))))

    def test_a_class_reads_chinese(self):
        summary.write(self.folder, [record("s1"), record("s2"), {**record("s3"), "status": "infrastructure-error"}],
                      {row["id"]: row["points"] for row in record()["stages"]}, None, [], [], CHINESE)
        words = words_of(self.folder / "summary.html")
        self.assertEqual(english_in(words), "")
        for part in ("已评 2 份提交", "1.1：缺少镜像块", "2 错误", "s1、s2", "s3"):
            self.assertIn(part, words)

    def test_an_empty_blank_is_no_failed_check(self):
        half = record()
        for one in half["stages"]:
            one.update(state="not-started", diagnosis={"begun": True}, margins={})
        summary.write(self.folder, [half], {row["id"]: row["points"] for row in half["stages"]}, None, [], [], ENGLISH)
        self.assertNotIn("one edge between two poses", words_of(self.folder / "summary.html"))

    def test_other_platforms_are_told_in_chinese(self):
        outputs.write_one(self.folder, record(), CHINESE)
        results = json.loads((self.folder / "results.json").read_text(encoding="utf-8"))
        told = "\n".join([results["output"], *(test["output"] for test in results["tests"])])
        self.assertEqual(english_in(told), "")
        self.assertIn("缺少镜像块", told)
        self.assertIn("缺少镜像块", (self.folder / "junit.xml").read_text(encoding="utf-8"))
        broken = {**record(), "status": "infrastructure-error"}
        self.assertEqual(english_in(outputs.gradescope(broken, CHINESE)["output"]), "")

    def test_words_of_another_version_of_the_course_are_not_told(self):
        gone, wants_more = sentence("1.1.gone"), sentence("scene.H_of")
        for place in ("check", "expected", "got", "cause", "places"):
            for text in (gone, wants_more):
                old = record()
                old["faults"].append(text)
                old["stages"][0]["diagnosis"] = {**DIAGNOSIS, place: [[text, "δp.x"]] if place == "places" else text}
                self.folder.joinpath("record.json").write_text(json.dumps(old), encoding="utf-8")
                for say in (ENGLISH, CHINESE):
                    read = grading.read_record(self.folder, say)
                    self.assertEqual((read["faults"], read["stages"][1:]), (record()["faults"], record()["stages"][1:]))
                    pages.write_feedback(self.folder, read, say)
                    self.assertIn(say("grade.of_another_version"), words_of(self.folder / "feedback.html"))

    def test_another_language_regrades_nothing(self):
        file = self.folder / "gauge_prior.cc"
        file.write_text("// mine\n")
        session = lambda say: grading.Session(self.folder, SimpleNamespace(digest="d", box=Unguarded), STAGES[:1], {"1.1": {}}, 7, say)
        graded = {key: value for key, value in record().items() if key not in ("name", "key")}
        with mock.patch.object(grading, "grade", return_value=graded):
            self.assertTrue(session(ENGLISH).grade_one("s1", [file]))
        before = (self.folder / "s1" / "record.json").read_bytes()
        self.assertIn("the mirrored block is missing", (self.folder / "s1" / "feedback.html").read_text(encoding="utf-8"))
        with mock.patch.object(grading, "grade", side_effect=AssertionError("graded again")):
            self.assertFalse(session(CHINESE).grade_one("s1", [file]))
            read = grading.read_records(self.folder, STAGES[:1], {"1.1": {}}, CHINESE)
            grading.write_tables(self.folder, read, {"1.1": 0}, None, [], [], CHINESE)
        self.assertEqual((self.folder / "s1" / "record.json").read_bytes(), before)
        self.assertEqual(english_in(words_of(self.folder / "s1" / "feedback.html")), "")
