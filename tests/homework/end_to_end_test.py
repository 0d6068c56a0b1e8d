#!/usr/bin/env python3
"""Runs ./course check and status as a student does, on a folder of homework of its own: end_to_end.py FOLDER."""

import json
import os
import re
import subprocess
import sys
import unittest
from pathlib import Path

from ch5_backend.course.base.cmake_build import BUILD
from ch5_backend.course.homework.regions import fill, solution_text
from tests.homework.chinese import english_in
from tests.homework.hand_in import SKELETONS, hand_in
from tests.project import run

FOLDER = Path(os.environ["CH5_CHECK_FOLDER"])


def course(*words: str) -> subprocess.CompletedProcess:
    return run(sys.executable, "-m", "ch5_backend.course", *words)


def states(done: subprocess.CompletedProcess) -> dict:
    """Stage → state; standard output must hold one JSON object and nothing else."""
    return {stage["id"]: stage["state"] for stage in json.loads(done.stdout)["stages"]}


def hints(done: subprocess.CompletedProcess) -> dict:
    return {stage["id"]: stage["hint"] for stage in json.loads(done.stdout)["stages"]}


class EndToEnd(unittest.TestCase):
    def test_the_skeleton_is_not_started(self):
        hand_in(FOLDER, **SKELETONS)
        done = course("check", "--json")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertEqual(set(states(done).values()), {"not-started"})
        self.assertIn("TODO 1.2a", hints(done)["1.2"])
        status = course("status", "--json")
        self.assertEqual((status.returncode, status.stdout), (0, done.stdout))

    def test_the_solution_is_right(self):
        """Also with the names that files had in earlier terms."""
        names = {"problem": ("dense/problem.h", "solve/problem.h"), "gauge_prior": ("simulate/mono_ba.h", "world/simulate/mono_ba.h"),
                 "block_solver": ("dense/blocks/plain_block_solver.h", "dense/plain_block_solver.h")}
        earlier = {name: solution_text(f"{name}.cc").replace(*change) for name, change in names.items()}
        for name, text in earlier.items():
            self.assertNotEqual(text, solution_text(f"{name}.cc"))
        hand_in(FOLDER, **earlier)
        done = course("check", "--json")
        self.assertEqual((done.returncode, set(states(done).values())), (0, {"right"}), done.stdout + done.stderr)
        words = course("check", "3")
        self.assertEqual(words.returncode, 0)
        self.assertIn("Well done", words.stdout)

    def test_a_file_that_does_not_compile_hides_no_other(self):
        broken = solution_text("problem.cc").replace("b_pp_schur_ = bpp", "b_pp_schur_ = bqq")
        line = broken[:broken.index("bqq")].count("\n") + 1
        hand_in(FOLDER, problem=broken)
        done = course("check", "--json")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(states(done), {"1.1": "does-not-compile", "1.2": "does-not-compile",
                                        "2": "does-not-compile", "3": "right", "4": "right", "5": "right",
                                        "6": "right", "7": "right", "8": "right"})
        self.assertIn(f"problem.cc:{line}", hints(done)["1.1"])

    def test_a_crash_names_the_line_and_hides_no_other_stage(self):
        crashing = solution_text("problem.cc").replace("H.block(index_i, index_j, dim_i, dim_j)",
                                                       "H.block(index_i, index_j + 99, dim_i, dim_j)")
        begin = "  const int reserve_size = static_cast<int>(H_marg.rows());\n"
        crashing = crashing.replace(begin, begin + "  if (dim >= 0) return TestMarginalize(H_marg, b_marg, idx, dim);\n")
        line = crashing[:crashing.index("+ 99")].count("\n") + 1
        with_main = solution_text("gauge_prior.cc") + "int main() {}\n"
        hand_in(FOLDER, problem=crashing, gauge_prior=with_main)
        done = course("check", "--json")
        self.assertEqual(states(done), {"1.1": "crashes", "1.2": "right", "2": "crashes", "3": "does-not-compile",
                                        "4": "right", "5": "right", "6": "right", "7": "right", "8": "right"},
                         done.stdout)
        self.assertRegex(hints(done)["1.1"], rf"reaches outside its matrix: block\(0, 99, 6, 6\) of a 12×12 matrix; .* at problem\.cc:{line}\b")
        self.assertRegex(hints(done)["2"], r"stack is full at problem\.cc:\d+")
        self.assertIn("main of its own", hints(done)["3"])

    def test_what_is_empty_or_missing_is_named(self):
        empty = fill(solution_text("problem.cc"), lambda region: region.hints if region.todo == "1.2a" else region.solution)
        exchanged = solution_text("gauge_prior.cc").replace("scene.frames[i].q, scene.frames[i].p",
                                                            "scene.frames[i].p, scene.frames[i].q")
        line = exchanged[:exchanged.index("[i].p, ")].count("\n") + 1
        deleted = re.sub(r"^VecX MarginalizationError::Residual.*?^}\n", "", solution_text("marginalization_error.cc"),
                         flags=re.MULTILINE | re.DOTALL)
        hand_in(FOLDER, problem=empty, gauge_prior=exchanged, marginalization_error=deleted)
        told = hints(course("check", "1.2", "3", "5", "--json"))
        self.assertIn("Hmm is still empty: nothing was assigned to it in TODO 1.2a", told["1.2"])
        self.assertRegex(told["3"], rf"gauge_prior.cc:{line}:\d+: no matching (function for call to|constructor) .*EdgeSE3Prior")
        self.assertIn("the function MarginalizationError::Residual is missing in marginalization_error.cc", told["5"])

    def test_a_student_reads_chinese(self):
        """All that is said of the samples is looked at by run_samples.py."""
        wrong = {"problem": ("H.block(index_j, index_i, dim_j, dim_i).noalias() += hessian.transpose()", "(void)hessian"),
                 "gauge_prior": ("i < 2", "i < 1")}
        files = {name: self.replaced(f"{name}.cc", *change) for name, change in wrong.items()}
        hand_in(FOLDER, **files)
        (BUILD / "failures.json").unlink(missing_ok=True)  # of an earlier run of this test
        causes = {"1.1": "缺少镜像块", "3": "只有第 0 帧有先验"}
        for _ in range(2):  # looking again at the same files names no cause
            self.assertNotIn("缺少镜像块", course("check", "1.1", "--language", "zh").stdout)
        course("check", *causes, "--language", "zh")
        built = {path: path.stat().st_mtime_ns for path in (FOLDER / f"{name}.cc" for name in files)}
        hand_in(FOLDER, **{name: text + "// looked at again\n" for name, text in files.items()})
        for path, time in built.items():  # a comment more: nothing to build
            os.utime(path, ns=(time, time))
        told = course("check", *causes, "--language", "zh").stdout
        self.assertEqual(english_in(told), "", told)
        for stage, words in causes.items():
            self.assertRegex(told, rf"(?s)✗ {stage} 错误((?!\n[✗✓·] ).)*原因 +((?!\n[✗✓·] ).)*{words}", told)
        status = course("status", "--language", "zh").stdout
        self.assertEqual(english_in(status), "", status)
        for words in (*causes.values(), "1.2  ✓ 正确"):
            self.assertIn(words, status)

    def replaced(self, name: str, old: str, new: str) -> str:
        text = solution_text(name)
        self.assertIn(old, text, name)
        return text.replace(old, new, 1)

    def test_a_missing_file_and_an_unknown_stage_are_named(self):
        hand_in(FOLDER)
        (FOLDER / "gauge_prior.cc").unlink()
        done = course("check", "3", "--json")
        self.assertEqual(states(done), {"3": "does-not-compile"})
        self.assertIn("gauge_prior.cc is missing; ./course reset gauge_prior.cc", hints(done)["3"])
        unknown = course("check", "99")
        self.assertEqual(unknown.returncode, 2)
        self.assertIn("unknown stage '99'", unknown.stderr)
