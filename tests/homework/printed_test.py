"""What a student's code prints: counted and shown test by test, so that a debug line never hides a verdict."""

import io
import json
import sys
import time
import unittest

from tests.folder import FolderTest
from ch5_backend.course.base.language import speaker
from ch5_backend.course.homework.block_map import block_map
from ch5_backend.course.homework.check import tell
from ch5_backend.course.homework.diagnosis import cause_of
from ch5_backend.course.homework.judge import FLOOD, every_test, in_bytes, judge, mended

STAGE = {"id": "1.1", "tests": "Stage11.*", "file": "problem.cc", "todos": ["1.1a"]}
# In place of a check: prints, and reports that its second test has failed, or runs on.
CHECK = """#!{python}
import json, sys, time
test = lambda name, **more: {{"name": name, "classname": "Stage11", "result": "COMPLETED", **more}}
def begins(name): print("\\x1eTEST " + name, flush=True)
begins("First"); print("small 1")
begins("Second"); print("small 2\\n" * 3)
{then}
report = next(word for word in sys.argv if word.startswith("--gtest_output=json:")).partition(":")[2]
failure = {failure}
with open(report, "w") as out:
    json.dump({{"testsuites": [{{"testsuite": [test("First"), test("Second", **failure), test("Third")]}}]}}, out)
"""
FAILURE = {"diagnosis": json.dumps({"stage": "1.1", "check": "H", "cause": "x"}), "failures": [{"failure": "f"}]}


class Printed(FolderTest):
    def verdict(self, then: str, limit: float = 20.0, failure=FAILURE, words_of=None):
        path = self.folder / "check_problem"
        path.write_text(CHECK.format(python=sys.executable, then=then, failure=failure), encoding="utf-8")
        path.chmod(0o755)
        return judge(path, STAGE, limit, words_of=words_of)

    def told(self, verdict) -> str:
        out = io.StringIO()
        tell(STAGE, verdict, out, speaker("en"))
        return out.getvalue()

    def test_the_failing_tests_lines_are_shown_though_a_later_one_prints_more(self):
        verdict = self.verdict('begins("Third"); print("large " * 30 + "\\n" * 1000)')
        self.assertEqual((verdict.state, verdict.printed.split()), ("wrong", ["small", "2"] * 3))
        self.assertIn("Your code printed:\n  │ small 2\n", self.told(verdict))

    def test_much_output_is_counted_and_its_beginning_shown(self):
        verdict = self.verdict('sys.stdout.write("".join(f"row {i}\\n" for i in range(300000)))')
        self.assertEqual(verdict.printed_bytes, sum(len(f"row {i}\n") for i in range(300000)) + len("small 2\n") * 3 + 1)
        self.assertIn(f"({in_bytes(verdict.printed_bytes)} in this check; its first 15 lines)", self.told(verdict))
        self.assertIn("│ row 0\n", self.told(verdict))
        self.assertLess(len(verdict.printed), 2 << 20)

    def test_an_exception_tells_the_line_that_threw_it(self):
        verdict = self.verdict('print("\\x1eTHROWN libstdc++.so.6(+0x1) check_problem(+0x10)\\nmore", flush=True)',
                               failure={"failures": [{"failure": 'C++ exception with description "boom" thrown in the test body.'}]},
                               words_of=lambda command: "/student/problem.cc:71\n" if command[-1] == "0xf" else "")
        self.assertEqual((verdict.state, verdict.diagnosis["place"]), ("crashes", "problem.cc:71"))
        self.assertIn("boom at problem.cc:71.", self.told(verdict))
        self.assertEqual(verdict.printed.split(), ["small", "2"] * 3 + ["more"])

    def test_a_flood_is_no_endless_loop(self):
        begin = time.monotonic()
        verdict = self.verdict('while True: sys.stdout.write("x" * 4095 + "\\n")', 2.0)
        self.assertLess(time.monotonic() - begin, 15.0)
        self.assertEqual((verdict.state, cause_of(verdict.diagnosis)), ("times-out", "judge.prints_too_much"))
        self.assertGreater(verdict.printed_bytes, FLOOD)
        silent = self.verdict("time.sleep(60)", 1.0)
        self.assertEqual((silent.state, cause_of(silent.diagnosis)), ("times-out", "judge.does_not_end"))

    def test_who_waits_for_a_core_is_in_time(self):
        verdict = self.verdict("""import os, subprocess
os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
others = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(5)]
while time.process_time() < 1.0: pass
for other in others: other.kill()""", 3.0)
        self.assertEqual(verdict.state, "wrong", "it needs a second, and takes six")

    def test_a_check_that_ends_the_program_hides_no_other_one(self):
        then = """import os
filter = next(word for word in sys.argv if word.startswith("--gtest_filter=")).rpartition(".")[2]
if filter in "*Second": os.abort()
test = lambda name, **more: {"name": filter, "result": "COMPLETED"}"""
        path = self.folder / "check_problem"
        path.write_text(CHECK.format(python=sys.executable, then=then, failure={}), encoding="utf-8")
        path.chmod(0o755)
        tests = every_test(path, {**STAGE, "checks": {"First": {}, "Second": {}, "Third": {}}})
        self.assertEqual([(test["name"], bool(test.get("failures"))) for test in tests], [("First", False), ("Second", True), ("Third", False)])

    def test_a_crash_behind_a_flood_is_told(self):
        verdict = self.verdict('sys.stdout.write("y\\n" * 2000000); print("\\nCRASH Null pointer in Second", flush=True); '
                               'import os; os._exit(139)')
        self.assertEqual((verdict.state, cause_of(verdict.diagnosis)), ("crashes", "judge.null_followed"))

    def test_an_assertion_tells_the_sizes_that_it_knows(self):
        for numbers, assertion, told in (
                ("6 6 12 12 12 9" + " -1" * 8, "startRow >= 0", "block(6, 6, 12, 12) of a 12×9 matrix"),
                ("3 0 6 1 5 1" + " -1" * 8, "startRow >= 0", "segment(3, 6) of a vector of 5"),
                ("-1 -1 -1 -1 -1 -1 12 12 3 4 -1 -1 -1 -1", "aLhs.rows() == aRhs.rows()", "different sizes: 12×12 and 3×4"),
                ("-1 -1 -1 -1 -1 -1 3 4 5 6 -1 -1 -1 -1", "lhs.cols() == rhs.rows()", "product do not fit: 3×4 and 5×6"),
                ("-1 -1 -1 -1 -1 -1 -1 -1 -1 -1 6 6 6 12", "dst.rows() == src.rows()", "different sizes: 6×6 and 6×12"),
                ("-1 -1 -1 -1 12 12" + " -1" * 8, "startRow >= 0", "outside its matrix, in the test")):
            verdict = self.verdict(f'print("\\nSIZES {numbers}\\nx: f: Assertion `{assertion}\' failed.\\n\\nCRASH Aborted in Second", flush=True); '
                                   'import os; os._exit(134)')
            self.assertIn(told, self.told(verdict))
            self.assertEqual(verdict.printed.split(), ["small", "2"] * 3)

    def test_sizes_in_words(self):
        self.assertEqual([in_bytes(n) for n in (0, 512, 4600, 342123456)], ["0 B", "512 B", "4.6 KB", "342 MB"])


class BlockMap(unittest.TestCase):
    def test_names_of_any_letters_survive_the_report(self):
        rows = json.dumps(["δv.x", "δθ.y"], ensure_ascii=False)
        test = {"rows": rows.encode().decode("latin-1"), "picture": "xo/oo", "line": 3}  # as GoogleTest up to 1.12 has them
        self.assertEqual(json.loads(json.dumps({"testsuites": [test]}), object_hook=mended), {"testsuites": [{**test, "rows": rows}]})

    def test_a_mark_tells_of_all_entries_of_two_vertices(self):
        names = [{"id": "scene.row_of", "vertex": vertex, "component": k} for vertex in ("pose 0", "pose 1") for k in "ab"] + ["landmark 2"]
        test = {"picture": "oo..o/oo..o/..ox./..oo./oo..o", "rows": json.dumps(names), "columns": "[]"}
        self.assertEqual(block_map(test, speaker("en")), ["pose 0      ■ · ■", "pose 1      · ✗ ·", "landmark 2  ■ · ■"])
        vector = {**test, "picture": "o/o/x/./.", "columns": '["b"]'}
        self.assertEqual(block_map(vector, speaker("en")), ["pose 0      ■", "pose 1      ✗", "landmark 2  ·"])

    def test_what_it_cannot_draw_it_leaves_out(self):
        names = json.dumps(["a", "b"])
        for test in ({}, {"picture": "xx/xx", "rows": names, "columns": "[]"}, {"picture": "xo/oo", "rows": "[]", "columns": "[]"},
                     {"picture": "xo", "rows": names, "columns": "[]"}, {"picture": "xoo/ooo", "rows": names, "columns": "[]"},
                     {"picture": "/".join(["x" + "." * 24] * 25), "rows": json.dumps(list("abcdefghijklmnopqrstuvwxy")), "columns": "[]"}):
            self.assertEqual(block_map(test, speaker("en")), [], test)
