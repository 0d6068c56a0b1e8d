"""./course test: what it says of CTest's words, and the names by which tests are called."""

import fcntl
import json
import re
import unittest
from types import SimpleNamespace
from unittest import mock

from ch5_backend.course import test as command
from ch5_backend.course.test import skipped, targets_of, worth_reading
from tests.project import BUILD, run

JUNIT = """<testsuite>
<testcase name="A" status="run"><system-out>[       OK ] A</system-out></testcase>
<testcase name="B" status="notrun"><skipped message=""/><system-out>/p/b.cc:9: Skipped\nwithout the data\n</system-out></testcase>
<testcase name="C" status="notrun"><skipped message=""/><system-out>test_c (t.C) ... skipped "it's no clone"\n\nOK (skipped=1)</system-out></testcase>
<testcase name="D" status="notrun"><skipped message=""/><system-out>/p/d.cc:7: Skipped\nwithout the data\n</system-out></testcase>
<testcase name="F" status="run"><system-out>test_a ... ok
test_b ... skipped 'no font'
OK (skipped=1)</system-out></testcase>
<testcase name="E" status="notrun"><skipped message=""/><system-out>looking\ncourse: Node.js is missing\n</system-out></testcase>
</testsuite>"""


class Words(unittest.TestCase):
    def test_a_failure_begins_with_the_command_that_repeats_it(self):
        lines = worth_reading(["Test project /p", "    Start 1: A.B", "1/3 Test #1: A.B ......   Passed    0.01 sec",
                      "2/3 Test #2: S/T.X/0<std::vector> ...***Failed    0.02 sec", "expected 1, got 2",
                      "3/3 Test #3: C.d ....***Skipped   0.01 sec", "", "67% tests passed, 1 tests failed out of 3",
                      "The following tests did not run:", "\t  3 - C.d (Skipped)"])
        self.assertEqual(lines, ["✗ S/T.X/0<std::vector> failed; once more: ./course test '^S/T.X/0<std::vector>$'",
                                 "2/3 Test #2: S/T.X/0<std::vector> ...***Failed    0.02 sec", "expected 1, got 2", "",
                                 "67% tests passed, 1 tests failed out of 3"])

    def test_what_is_skipped_is_a_line_with_the_reasons(self):
        self.assertEqual(skipped(JUNIT), "Skipped: 5 of 6 tests: 2 without the data; 1 it's no clone; 1 no font; 1 Node.js is missing\n")
        self.assertEqual(skipped("<testsuite><testcase name='A'/></testsuite>"), "")


class Lock(unittest.TestCase):
    def test_nobody_configures_until_ctest_has_read_its_files(self):
        free = []

        def ctest(_words, _log, step):
            for line in ("Test project /p", "      Start  1: A.B", "1/1 Test #1: A.B ...   Passed"):
                step(line)
                with open(BUILD / ".lock", "w", encoding="utf-8") as file:
                    try:
                        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                        free.append(True)
                    except BlockingIOError:
                        free.append(False)
            return SimpleNamespace(stdout="", returncode=0)
        with mock.patch.multiple(command, run_logged=ctest, build_or_fail=mock.Mock()):
            self.assertEqual(command.test([], False, False, []), 0)
        self.assertEqual(free, [False, True, True])


class Names(unittest.TestCase):
    def test_only_what_tests_of_one_beginning_need_is_built(self):
        for names, targets in ((["^Loss"], ["test_graph"]), (["^Loss.Derivatives", "^Marginalize"], ["test_graph", "test_marginalize"]),
                               (["Loss"], []), (["^Loss|Graph"], []), (["^Loss", "^Homework"], []), (["^Scenes/"], []), (["^["], []), ([], [])):
            self.assertEqual(targets_of(names), targets, names)

    def test_every_test_has_a_name_of_its_own_that_can_be_typed(self):
        """No address, no value of a parameter, and so the same in each run."""
        done = run("ctest", "--test-dir", BUILD, "--show-only=json-v1", check=True)
        names = [test["name"] for test in json.loads(done.stdout)["tests"]]
        self.assertGreater(len(names), 1000)
        self.assertEqual([name for name in names if not re.fullmatch(r"[\w./<>:,-]+", name)], [])
        self.assertEqual(sorted(set(names)), sorted(names))
