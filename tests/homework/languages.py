"""The check speaks Chinese: everything that it can say has an entry, and what varies gets through untouched."""

import ast
import io
import json
import os
import re
import unittest
from collections import Counter
from pathlib import Path
from unittest import mock

from ch5_backend.course.homework.regions import ROOT, STAGES
from tests.homework.untranslated import CHINESE, SENTENCE, english_in, language, untranslated
from ch5_backend.course.homework import blanks, check, compiler, hint_policy, judge
from ch5_backend.course.base.errors import CourseError
from ch5_backend.course.homework.judge import Verdict

COURSE = ROOT / "ch5_backend" / "course"
CHECKS = sorted([*(ROOT / "ch5_homework" / "judge").glob("mistakes/*.h"), *(ROOT / "ch5_homework" / "judge").glob("stage_*.[ch]*"),
                 ROOT / "ch5_homework" / "judge" / "narrate.cc",
                 # What the library answers to wrong calls and to systems that nobody can solve:
                 *(ROOT / "ch5_backend" / name for name in ("dense/plain_block_solver.cc", "marginalize/edge_prior.cc",
                   "marginalize/marginalization_error_core.cc", "marginalize/marginalization_info_core.cc",
                   "solve/minimizer.cc"))])
SPEAKERS = [COURSE / name for name in ("homework/judge.py", "homework/deep.py", "homework/blanks.py", "homework/hint_policy.py",
                                       "homework/check.py", "homework/compiler.py", "grading/job.py",
                                       "grading/pages.py", "grading/outputs.py", "grading/toolchain.py",
                                       "grading/submission.py")]
PLAIN_WORD = re.compile(r"[a-z]{3,}")
NO_WORDS = {"margin", "picture", "false"}  # properties of a test, and code
PATTERN = re.compile(r"[\\|<]|\.[*+]|TODO::|^ninja|`main'")  # of a regular expression, code, or a tool's words


def catalogues() -> list:
    """[(English, Chinese)] of all files, in which one may stand twice."""
    return [pair for path in sorted((COURSE / "base" / "language" / "zh").glob("*.json"))
            for pair in json.loads(path.read_text(encoding="utf-8"), object_pairs_hook=list)]


def literals_of_cpp(path: Path) -> list:
    """String literals, those that the compiler joins as one."""
    code = re.sub(r"^#include.*$|//.*$", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    joined = re.sub(r'"\s*\n\s*"', "", code)
    return re.findall(r'"((?:[^"\\\n]|\\.)*)"', joined)


def literals_of_python(path: Path) -> list:
    """String constants, and the constant parts of f-strings; without docstrings, regular expressions and errors for who
    types the command."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    skipped = set()
    for node in ast.walk(tree):
        documented = isinstance(node, (ast.Module, ast.FunctionDef, ast.ClassDef)) and ast.get_docstring(node) is not None
        inside = node.body[:1] if documented else [node] if isinstance(node, ast.Raise) else []
        skipped.update(id(one) for top in inside for one in ast.walk(top))
    return [node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str) and
            id(node) not in skipped and not PATTERN.search(node.value)]


def has_entry(text: str) -> bool:
    """Whether it is translated, or a part of what is."""
    told = CHINESE(text)
    return told != text and not english_in(told) or any(text.strip() in english for english in CHINESE.entries)


class Catalogue(unittest.TestCase):
    def test_both_languages_leave_room_for_the_same(self):
        for english, chinese in catalogues():
            rooms = [Counter(language.PLACEHOLDER.findall(text)) for text in (english, chinese)]
            self.assertEqual(set(rooms[0]), set(rooms[1]), english)
            self.assertEqual(max(rooms[0].values(), default=1), 1, english)

    def test_what_varies_gets_through_and_no_template_hides_another(self):
        for english, chinese in catalogues():
            values = {name: "-1.5e-07" if len(name) == 1 else f"Name_{k}::x[{k}]"
                      for k, name in enumerate(language.PLACEHOLDER.findall(english))}
            self.assertEqual(CHINESE(english.format(**values)), chinese.format(**values))

    def test_no_sentence_stands_in_two_places(self):
        self.assertEqual([english for english, times in Counter(english for english, _ in catalogues()).items() if times > 1], [])

    def test_chinese_is_free_of_english(self):
        for english, chinese in catalogues():
            self.assertEqual(english_in(chinese), "", english)

    def test_every_sentence_of_the_checks_has_an_entry(self):
        lacking = [f"{path.name}: {text}" for path in CHECKS for text in literals_of_cpp(path)
                   if (SENTENCE.search(text) or PLAIN_WORD.fullmatch(text) and text not in NO_WORDS) and not has_entry(text)]
        self.assertEqual(lacking, [])
        self.assertGreater(sum(len(literals_of_cpp(path)) for path in CHECKS), 600)

    def test_every_sentence_of_the_course_has_an_entry(self):
        lacking = [f"{path.name}: {text}" for path in SPEAKERS for text in literals_of_python(path)
                   if SENTENCE.search(text) and not has_entry(text)]
        self.assertEqual(lacking, [])

    def test_states_and_titles_have_entries(self):
        for text in [*check.COLOURS, *(stage["title"] for stage in STAGES)]:
            self.assertIn(text, CHINESE.entries)

    def test_every_gap_is_named(self):
        for path in [*(ROOT / "solutions").glob("*.cc"), *(ROOT / "ch5_homework").glob("*.cc")]:
            for todo in re.findall(r'HomeworkMissing\("(.*?)"\)', path.read_text(encoding="utf-8")):
                told = CHINESE(f"TODO {todo} is not started.")
                self.assertEqual(english_in(told), "", told)
                self.assertIn(todo.split(",")[0], told)


class Stories(unittest.TestCase):
    STORY = """Stage 7: H of 5 points and 5 poses in a row, one of them fixed
  expected  (30, 4) = -1.5e-07
  got       (30, 4) = -nan   the worst of 12 wrong entries, 1681 in all
  row 30    landmark 2, component 1
  column 4  pose 0, δθ.y
  cause     the diagonal blocks of H_pp: = stands where += is meant
  read      ch5_homework/README.md, Stage 7, TODO 7c"""

    def test_numbers_and_names_get_through(self):
        self.assertEqual(CHINESE.story(self.STORY), """阶段 7：H，排成一列的 5 个位姿和 5 个点，固定其中一个
  应为      (30, 4) = -1.5e-07
  实际      (30, 4) = -nan   共 1681 个元素，12 个不对，这个偏差最大
  第 30 行  路标点 2，第 1 个分量
  第 4 列   位姿 0，δθ.y
  原因      H_pp 的对角块：把 += 写成了 =
  参阅      ch5_homework/README.zh.md，Stage 7，TODO 7c""")
        matrix = "Stage 1.1: H of one edge between two poses\n  expected  [ 1  -2 ]\n            [ 3e-9  4 ]"
        self.assertEqual(CHINESE.story(matrix).splitlines()[1:], ["  应为      [ 1  -2 ]", "            [ 3e-9  4 ]"])

    def test_english_stays_as_it_is(self):
        english = language.speaker("en")
        hint = judge.cause(self.STORY)
        self.assertEqual((english.story(self.STORY), english.hint(hint, self.STORY)), (self.STORY, hint))

    def test_a_cause_is_named_and_held_back(self):
        verdict = Verdict("wrong", judge.cause(self.STORY), self.STORY)
        self.assertEqual(CHINESE.hint(verdict.hint, verdict.story),
                         "阶段 7：H，排成一列的 5 个位姿和 5 个点，固定其中一个：H_pp 的对角块：把 += 写成了 =。")
        with mock.patch.object(hint_policy, "remember", return_value=1):
            for threshold in (2, 3):
                held = hint_policy.hold_back(STAGES[-1], verdict, threshold)
                self.assertEqual(untranslated(held), "")
                self.assertIn("./course hint 7 1", CHINESE.story(held.story))
                self.assertNotIn("对角块", CHINESE.story(held.story))

    def test_what_ends_a_program_is_told(self):
        for where in ("", " at problem.cc:71", ", in the test Stage11.A", " at problem.cc:71, in the test Stage11.A"):
            for sentence in (*(f"An assertion stopped the program: {plain}{where}." for _, plain in judge.ASSERTIONS),
                             f"Still running after 20 s{where}: a loop does not end.",
                             f"Crash (Segmentation fault){where}, before the tests were through.",
                             f"The program ended by itself (exit code -9){where}, before the tests were through."):
                told = CHINESE(sentence)
                self.assertEqual(english_in(told), "")
                self.assertEqual("problem.cc:71" in told, "problem.cc" in where)
        text = b"  MatXX Hmm;\n  // TODO:: home work 1.2a. Hmm = ?\n  use(Hmm);\n"
        crash = blanks.explain(Verdict("crashes", "Crash (Aborted) at problem.cc:3, before the tests were through."), "problem.cc", text)
        self.assertIn("Hmm 还是空的：TODO 1.2a", CHINESE(crash.hint))
        self.assertEqual(untranslated(crash), "")

    def test_what_a_compiler_says_is_explained_above_its_own_words(self):
        output = "problem.cc:7:3: error: a function-definition is not allowed here before '{' token\n    7 | void f() {"
        verdict = compiler.does_not_compile("problem.cc", output, b"{")
        told = judge.in_full(verdict.hint, verdict.story, CHINESE).splitlines()
        self.assertEqual(told[0], "problem.cc:7：第 7 行上面少了一个右花括号：从那里开始的内容落在了前一段里面。")
        self.assertEqual(told[2:], output.splitlines())


class Printed(unittest.TestCase):
    def told(self, tell, verdict: Verdict) -> str:
        out = io.StringIO()
        tell(STAGES[0], verdict, out, CHINESE)
        return out.getvalue()

    def test_every_verdict_is_told(self):
        for state in check.COLOURS:
            hint = "TODO 1.1a MakeHessian, the block (v_i, v_j) is not started." if state == "not-started" else ""
            for tell in (check.tell, check.tell_line):
                words = self.told(tell, Verdict(state, hint, "", "the student's own words\n"))
                self.assertIn(CHINESE(state), words)
                self.assertEqual(english_in(words.replace("the student's own words", "")), "")

    def test_columns_stand_below_each_other(self):
        width = len("1.1  ✓ ") + check.STATE_WIDTH
        for state in check.COLOURS:
            line = self.told(check.tell_line, Verdict(state, ""))
            before = line[:line.index("  Problem")]
            self.assertEqual(len(language.pad(before, 0)) + sum(letter > "⺀" for letter in before), width, line)

    def test_the_terminals_language_is_spoken(self):
        for locale, spoken in (({"LC_ALL": "zh_CN.UTF-8", "LANG": "C"}, "zh"), ({"LC_MESSAGES": "zh_TW"}, "zh"),
                               ({"LANG": "zh_CN.UTF-8"}, "zh"), ({"LC_ALL": "C", "LANG": "zh_CN"}, "en"),
                               ({"LC_ALL": "", "LC_MESSAGES": "de_DE", "LANG": "zh_CN"}, "en"), ({}, "en")):
            with mock.patch.dict(os.environ, locale, clear=True):
                self.assertEqual(language.chosen(""), spoken, locale)
                self.assertEqual([language.chosen(word) for word in language.LANGUAGES], list(language.LANGUAGES))
        with self.assertRaisesRegex(CourseError, "fr"):
            language.chosen("fr")
