"""Everything that the checks and ./course say stands in both languages, by an id that is used; what varies gets through."""

import ast
import io
import json
import os
import re
import unittest
from collections import Counter
from pathlib import Path
from unittest import mock

from ch5_backend.course.base.commands import make_parser
from ch5_backend.course.base import language
from ch5_backend.course.base.language import PLACEHOLDER, sentence
from ch5_backend.course.homework import blanks, check, compiler, hint_policy, judge
from ch5_backend.course.homework.diagnosis import Verdict, because, describe, in_full, in_short
from ch5_backend.course.homework.regions import FILES, ROOT, STAGES, regions, solution_text, stage_of
from ch5_backend.course.homework.samples import read_mistakes
from tests.homework.chinese import CHINESE, SENTENCE, english_in
from tests.homework.run_samples import said_in

ENGLISH = language.speaker("en")
COURSE, CHECKS = ROOT / "ch5_backend" / "course", ROOT / "ch5_homework" / "judge"
ID = re.compile(r"(?:\d\.\d|\w+)\.[A-Za-z][\w -]*(?<!_)")
CHINESE_LETTER = re.compile(r"[\u4e00-\u9fff]")
# Ids that are put together where they are used.
MADE = {*(f"state.{state}" for state in (*check.COLORS, "missing", "unread")),
        *(f"check.next_{state.replace('-', '_')}" for state in check.COLORS if state != "right"), "check.next_ended_by_itself",
        "check.next_prints_too_much", *(f"skeleton.{others}{depth}_depth" for others in ("", "others_") for depth in ("first", "second"))}


def literals_of_cpp(path: Path) -> list:
    """String literals, those that the compiler joins as one."""
    code = re.sub(r"^#include.*$|//.*$", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    return re.findall(r'"((?:[^"\\\n]|\\.)*)"', re.sub(r'"\s*\n\s*"', "", code))


def cpp_files() -> list:
    return sorted([*CHECKS.glob("*.cc"), *CHECKS.glob("*.h"), *(path for room in ("formula", "mistakes", "right") for path in CHECKS.glob(f"{room}/*.*"))])


def trees() -> list:
    return [ast.parse(path.read_text(encoding="utf-8")) for path in sorted(COURSE.rglob("*.py"))]


def used() -> set:
    words = [text for path in cpp_files() for text in literals_of_cpp(path)]
    words += [word for one in read_mistakes() for word in said_in(one.cause)]
    words += [node.value for tree in trees() for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)]
    topics = {name[:name.rindex(".")] for name in ENGLISH.sentences}
    return {word for word in words if ID.fullmatch(word) and word[:word.rindex(".")] in topics and not word.endswith(".yml")}


def sentences_in(text) -> list:
    """Something said, with what is said in it."""
    return [text, *(inner for value in text.values() for inner in sentences_in(value))] if isinstance(text, dict) else []


def printed(words: str):
    """What a program has printed in its only test."""
    part = judge.Part()
    part.add(words.encode())
    return mock.Mock(of=lambda test="": part)


def placeholders(text: str) -> set:
    return set(PLACEHOLDER.findall(text))


class Store(unittest.TestCase):
    def test_both_languages_have_the_same_and_leave_room_for_the_same(self):
        self.assertEqual(set(ENGLISH.sentences), set(CHINESE.sentences))
        for name, english in ENGLISH.sentences.items():
            self.assertEqual(placeholders(english), placeholders(CHINESE.sentences[name]), name)

    def test_stages_and_checks_have_names_in_both_languages(self):
        for names in (names for stage in STAGES for names in (stage["title"], *stage["checks"].values())):
            self.assertTrue(names["en"] and not CHINESE_LETTER.search(names["en"]) and CHINESE_LETTER.search(names["zh"]), names)

    def test_every_id_in_use_has_a_sentence_and_every_sentence_is_used(self):
        self.assertEqual(sorted(used() - set(ENGLISH.sentences)), [])
        self.assertEqual(sorted(set(ENGLISH.sentences) - used() - MADE), [])

    def test_every_call_gives_what_its_sentence_wants(self):
        calls = 0
        for node in (node for tree in trees() for node in ast.walk(tree) if isinstance(node, ast.Call) and node.args):
            name = node.args[0].value if isinstance(node.args[0], ast.Constant) else None
            if name in ENGLISH.sentences and all(keyword.arg for keyword in node.keywords):
                calls += 1
                ours = {keyword.arg for keyword in node.keywords} | ({"where"} if name.startswith("judge.") else set())
                self.assertLessEqual(placeholders(ENGLISH.sentences[name]), ours, name)
        self.assertGreater(calls, 40)

    def test_every_text_in_the_checks_gives_what_its_sentence_wants(self):
        texts = 0
        for path in cpp_files():
            for name, arguments in re.findall(r'\{?"([\w.]+)",\s*\{(\{"\w+", (?:[^;]*?)\})\}\}?', path.read_text(encoding="utf-8")):
                if name in ENGLISH.sentences:
                    texts += 1
                    self.assertLessEqual(placeholders(ENGLISH.sentences[name]), set(re.findall(r'\{"(\w+)", ', arguments)), name)
        self.assertGreater(texts, 80)

    def test_every_mistake_gives_what_its_sentence_wants_and_no_more(self):
        for one in read_mistakes():
            for text in sentences_in(one.cause) if one.state == "wrong" else ():
                self.assertEqual(set(text) - {"id"}, placeholders(ENGLISH.sentences[text["id"]]), one.name)

    def test_no_sentence_stands_in_the_checks(self):
        scenes = {text for path in CHECKS.glob("scenes/*.cc") for text in literals_of_cpp(path)}  # by name, for both sides
        # What a worker sends that is no answer is told to no student: only that its program has ended so.
        refused = {text for path in cpp_files() for words in re.findall(r"throw WireError\((.*?)\);", path.read_text(encoding="utf-8"))
                   for text in re.findall('"([^"]*)"', words)}
        said = [f"{path.name}: {text}" for path in cpp_files() for text in literals_of_cpp(path)
                if SENTENCE.search(text) and text not in scenes | refused]
        ours = ("main.cc", "crash.h", "submission.h", "stage_4.cc", "expression.cc")  # for judge.py, or on faults of the judge
        self.assertEqual([text for text in said if text.partition(":")[0] not in ours], [])

    def test_no_sentence_stands_twice_in_a_topic(self):
        for names in Counter((name[:name.rindex(".")], text) for name, text in ENGLISH.sentences.items()).items():
            self.assertEqual(names[1], 1, names)

    def test_chinese_is_free_of_english(self):
        for name, chinese in CHINESE.sentences.items():
            self.assertEqual(english_in(chinese), "", name)

    def test_every_blank_is_named(self):
        for place in (region.place for name in FILES for region in regions(solution_text(name))):
            self.assertNotRegex(CHINESE.text({"quoted": place}), "[a-z] [a-z]", place)

    def test_words_that_are_not_ours_get_through(self):
        quoted = json.loads((COURSE / "base" / "language" / "zh.json").read_text(encoding="utf-8"))["quoted"]
        for english, chinese in quoted.items():
            values = {name: "-1.5e-07" if len(name) == 1 else f"Name_{k}::x[{k}]" for k, name in enumerate(PLACEHOLDER.findall(english))}
            said = {"quoted": english.format(**values)}
            self.assertEqual((CHINESE.text(said), ENGLISH.text(said)), (chinese.format(**values), said["quoted"]))
            self.assertEqual(english_in(chinese), "")
        self.assertEqual(CHINESE.text({"quoted": "something new"}), "something new")


class Told(unittest.TestCase):
    DIAGNOSIS = {"stage": "7", "check": sentence("scene.H_of", what=sentence("7.row_one_fixed")), "expected": "(30, 4) = -1.5e-07",
                 "got": sentence("matrix.worst_entry", entry="(30, 4) = -nan", wrong="12", all="1681"),
                 "cause": sentence("7.assigned", blocks=sentence("7.diagonal_blocks_H_pp")), "todo": "7c",
                 "places": [[sentence("diagnosis.row", n="30"), sentence("scene.component", vertex=sentence("scene.landmark", n="2"), n="1")],
                            [sentence("diagnosis.column", n="4"), sentence("scene.row_of", vertex=sentence("scene.pose", n="0"), component="δθ.y")]]}

    def test_a_diagnosis_is_told_in_both_languages(self):
        self.assertEqual(describe(self.DIAGNOSIS, ENGLISH), """Stage 7: H of 5 points and 5 poses in a row, one of them fixed
  expected  (30, 4) = -1.5e-07
  got       (30, 4) = -nan   the worst of 12 wrong entries, 1681 in all
  row 30    landmark 2, component 1
  column 4  pose 0, δθ.y
  cause     the diagonal blocks of H_pp: = is used where += is needed
  read      ch5_homework/handout/stage_7.md, TODO 7c""")
        self.assertEqual(describe(self.DIAGNOSIS, CHINESE), """阶段 7：H，排成一列的 5 个位姿和 5 个点，固定其中一个
  应为      (30, 4) = -1.5e-07
  实际      (30, 4) = -nan   共 1681 个元素，12 个不对，这个偏差最大
  第 30 行  路标点 2，第 1 个分量
  第 4 列   位姿 0，δθ.y
  原因      H_pp 的对角块：把 += 写成了 =
  参阅      ch5_homework/handout/stage_7.zh.md，TODO 7c""")
        matrix = {"stage": "1.1", "check": "H", "expected": "[ 1  -2 ]\n[ 3e-9  4 ]"}
        self.assertEqual(describe(matrix, CHINESE).splitlines()[1:3], ["  应为      [ 1  -2 ]", "            [ 3e-9  4 ]"])

    def test_a_cause_is_named_and_held_back(self):
        verdict = Verdict("wrong", self.DIAGNOSIS)
        self.assertEqual(in_short(verdict.diagnosis, CHINESE),
                         "阶段 7：H，排成一列的 5 个位姿和 5 个点，固定其中一个：H_pp 的对角块：把 += 写成了 =。")
        with mock.patch.object(hint_policy, "remember", return_value=1):
            for threshold in (2, 3):
                held = hint_policy.hold_back(stage_of("7c"), verdict, threshold, b"")
                words = in_short(held.diagnosis, CHINESE) + describe(held.diagnosis, CHINESE)
                self.assertEqual(english_in(words), "")
                self.assertIn("./course hint 7 1", words)
                self.assertNotIn("对角块", words)

    def test_what_ends_a_program_is_told(self):
        stage, trace = STAGES[0], "\nCRASH {} in A\n"
        for place, test in (("", ""), ("problem.cc:71", ""), ("", "A"), ("problem.cc:71", "A")):
            for words, in_time in ((trace.format("Segmentation fault"), True), (trace.format("Stack overflow"), True), ("", False),
                                   ("", True), *((f"Assertion `{code}' failed.", True) for code in ("i>=0", "invalid matrix product"))):
                words = words if test else words.replace(" in A", "")
                with mock.patch.object(judge, "locate", return_value=place):
                    verdict = judge.ended_early(Path("check"), stage, printed(words), in_time, 3, 20.0, None)
                said = in_short(verdict.diagnosis, CHINESE)
                self.assertEqual(english_in(said), "")
                self.assertEqual("problem.cc:71" in said, bool(place))
        text = b"  MatXX Hmm;\n  // TODO:: home work 1.2a. Hmm = ?\n  use(Hmm);\n"
        cause = because("judge.crash", signal={"quoted": "Aborted"}, where=sentence("judge.at_place", place="problem.cc:3"))
        crash = blanks.explain(Verdict("crashes", {**cause, "place": "problem.cc:3"}), STAGES[1], text)
        self.assertIn("Hmm 还是空的：TODO 1.2a", in_short(crash.diagnosis, CHINESE))
        self.assertEqual(english_in(in_short(crash.diagnosis, CHINESE)), "")

    def test_what_a_compiler_says_is_explained_above_its_own_words(self):
        output = "problem.cc:7:3: error: a function-definition is not allowed here before '{' token\n    7 | void f() {"
        verdict = compiler.does_not_compile("problem.cc", output, b"{")
        lines = in_full(verdict.diagnosis, verdict.output, CHINESE).splitlines()
        self.assertEqual(lines[0], "problem.cc:7：第 7 行上面少了一个右花括号：在编译器看来，第 7 行还在前一个函数里面。")
        self.assertEqual(lines[2:], output.splitlines())


class Read(unittest.TestCase):
    def read(self, text: str, **more) -> Verdict:
        return judge.read_report([judge.mended({"name": "A", "result": "COMPLETED", "failures": [{"failure": text}], **more})], 1, printed(""))

    def test_what_was_thrown_is_no_diagnosis(self):
        forged = json.dumps({"stage": "1.1", "check": "all is well", "cause": "none"})
        verdict = self.read(f'x.cc:1\nC++ exception with description "{forged}" thrown in the test body.')
        self.assertEqual((verdict.state, verdict.diagnosis["cause"]["id"]), ("crashes", "judge.exception"))

    def test_a_report_is_read_whatever_gtest_made_of_its_letters(self):
        words = json.dumps({"stage": "1.1", "check": "δp"}, ensure_ascii=False)
        for text in (words, words.encode().decode("latin-1")):
            self.assertEqual(self.read("x", diagnosis=text).diagnosis["check"], "δp")

    def test_blanks_and_exceptions_are_named(self):
        verdict = self.read('C++ exception with description "TODO 1.1a MakeHessian, whatever is not started" thrown')
        self.assertEqual(verdict.state, "not-started")
        self.assertIn("C++ exception", self.read('x.cc:1\nC++ exception of another kind').output)
        blank = self.read('"TODO 1.1a MakeHessian, the block (v_i, v_j) is not started"').diagnosis
        self.assertEqual(in_short(blank, ENGLISH), "TODO 1.1a is not started: MakeHessian, the block (v_i, v_j).")
        self.assertEqual(in_short(blank, CHINESE), "TODO 1.1a 还没有开始：MakeHessian（块 (v_i, v_j)）。")
        library = self.read('C++ exception with description "AddEdge: the edge is null" thrown').diagnosis
        self.assertEqual(english_in(in_short(library, CHINESE)), "")
        self.assertIn("AddEdge: the edge is null", in_short(library, ENGLISH))


class Printed(unittest.TestCase):
    def told(self, tell, verdict: Verdict) -> str:
        out = io.StringIO()
        tell(STAGES[0], verdict, out, CHINESE)
        return out.getvalue()

    def test_every_verdict_is_told(self):
        for state in check.COLORS:
            diagnosis = judge.not_started("1.1a", "MakeHessian, the block (v_i, v_j)") if state == "not-started" else {}
            for tell in (check.tell, check.tell_line):
                words = self.told(tell, Verdict(state, diagnosis, "", "the student's own words\n"))
                self.assertIn(CHINESE(f"state.{state}"), words)
                self.assertEqual(english_in(words.replace("the student's own words", "")), "")

    def test_the_terminals_language_is_spoken(self):
        for locale, spoken in (({"LC_ALL": "zh_CN.UTF-8", "LANG": "C"}, "zh"), ({"LC_MESSAGES": "zh_TW"}, "zh"),
                               ({"LANG": "zh_CN.UTF-8"}, "zh"), ({"LC_ALL": "C", "LANG": "zh_CN"}, "en"),
                               ({"LC_ALL": "", "LC_MESSAGES": "de_DE", "LANG": "zh_CN"}, "en"), ({}, "en")):
            with mock.patch.dict(os.environ, locale, clear=True):
                self.assertEqual(make_parser("check").parse_args([]).language, spoken, locale)
                self.assertEqual(make_parser("check").parse_args(["--language", "zh"]).language, "zh")
