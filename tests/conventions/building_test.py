"""How ./course builds: in which folder, with which compiler, how much of it, and what it says while it does."""

import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from tests.project import BUILD, CXX, ROOT, run

from ch5_backend.course.base import cmake_build, progress
from ch5_backend.course.base.errors import CourseError


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


class BuildProgress(unittest.TestCase):
    def watch(self, out, known: int = 0) -> list:
        """200 files, one every two seconds but for the first `known`, which take no time; the lines that were printed."""
        clock = Clock()
        phase = progress.Progress("build", out, clock)
        for number in range(1, 201):
            clock.now += 2.0 if number > known else 0.0
            phase.ninja_step(f"[{number}/200] Building CXX object a/CMakeFiles/ch5_layer_math.dir/math/so3.cc.o")
        return out.getvalue().splitlines()

    def test_a_log_file_gets_a_line_every_ten_seconds_at_most(self):
        lines = self.watch(io.StringIO())
        self.assertEqual(len(lines), 40)
        self.assertEqual(lines[0], "build: 5 of 200, about 6 min left: ch5_layer_math.dir/math/so3.cc")
        self.assertEqual(lines[-2], "build: 195 of 200, about 10 s left: ch5_layer_math.dir/math/so3.cc")

    def test_files_that_take_no_time_do_not_promise_that_the_rest_will(self):
        self.assertIn("build: 165 of 200, about 70 s left: ch5_layer_math.dir/math/so3.cc", self.watch(io.StringIO(), known=150))

    def test_a_terminal_shows_each_file(self):
        self.assertEqual("".join(self.watch(Terminal())).count("\033[K"), 200)

    def test_no_words_of_the_build_tool_are_shown(self):
        out = Terminal()
        phase = progress.Progress("build", out, Clock())
        for line in ("ninja: Entering directory `build'", "[0/2] Re-checking globbed directories...", "[1/2] Building CXX object a.cc.o"):
            phase.ninja_step(line)
        self.assertNotRegex(out.getvalue(), "ninja|Re-checking")

    def test_expected_work_goes_on_at_its_pace(self):
        out, clock = Terminal(), Clock()
        phase = progress.Progress("plots", out, clock, expected=200.0)
        phase.expected_step("first")
        clock.now += 20.0
        phase.finished(50.0)
        clock.now += 10.0
        phase.expected_step("second")
        self.assertTrue(out.getvalue().endswith("plots: about 50 s left: second"), "0.4 · 200 s − 30 s")
        self.assertIn("plots: about 3 min left: first", out.getvalue())


class BuildFolder(unittest.TestCase):
    def folder(self, **variables) -> str:
        kept = {name: value for name, value in os.environ.items() if name not in ("CXX", "CH5_BUILD_DIR")}
        done = run(sys.executable, "-c", "from ch5_backend.course.base.cmake_build import BUILD; print(BUILD)", env={**kept, **variables})
        return str(Path(done.stdout.strip()).relative_to(ROOT)) if done.returncode == 0 else done.stderr

    def test_each_compiler_has_a_folder_of_its_own(self):
        self.assertEqual(self.folder(), "build/release")
        self.assertEqual(self.folder(CXX="g++-11"), "build/release-g++-11")
        self.assertEqual(self.folder(CXX="/usr/bin/clang++ --gcc-toolchain=/opt"), "build/release-clang++-opt")

    def test_a_full_disk_is_not_told_as_an_error_of_the_code(self):
        done = subprocess.CompletedProcess([], 1, "[1/2] …\nproblem.cc:9:1: fatal error: cannot write PCH file: No space left on device\n")
        with mock.patch.object(cmake_build, "configure"), mock.patch.object(cmake_build, "run_logged", return_value=done), \
                self.assertRaises(CourseError) as caught:
            cmake_build.build()
        self.assertIn("the disk is full: problem.cc:9:1", str(caught.exception))

    def test_a_place_that_cannot_be_written_is_told_with_a_way_out(self):
        with tempfile.NamedTemporaryFile() as file, mock.patch.object(cmake_build, "BUILD", Path(file.name, "release")), \
                self.assertRaisesRegex(CourseError, f"{re.escape(file.name)}.*CH5_BUILD_DIR=FOLDER"), cmake_build.build_lock():
            pass

    def test_a_folder_of_another_compiler_or_project_is_made_anew(self):
        here = {"CMAKE_HOME_DIRECTORY": str(ROOT), "CMAKE_CXX_COMPILER": shutil.which("sh")}
        for words, cached, foreign in (([], here, False), (["sh"], here, False), (["cat"], here, True), (["cat"], {}, False),
                                       ([], {**here, "CMAKE_HOME_DIRECTORY": "/elsewhere"}, True)):
            with self.subTest(words=words, cached=cached), mock.patch.object(cmake_build, "CXX", words):
                self.assertEqual(cmake_build._is_foreign(cached), foreign)

    def test_the_named_folder_of_another_checkout_stays(self):
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(cmake_build, "BUILD", Path(folder)), \
                mock.patch.dict(os.environ, CH5_BUILD_DIR=folder):
            cache = Path(folder, "CMakeCache.txt")
            cache.write_text("CMAKE_HOME_DIRECTORY:INTERNAL=/elsewhere\n", encoding="utf-8")
            with self.assertRaisesRegex(CourseError, f"{re.escape(folder)}.* made by /elsewhere"):
                cmake_build.configure()
            self.assertTrue(cache.exists())


class Targets(unittest.TestCase):
    def commands(self, folder, target: str) -> str:
        done = run("ninja", "-C", folder, "-t", "commands", target)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_the_first_check_compiles_no_layer_but_what_checks_have_of_them(self):
        commands = self.commands(BUILD, "first_check_problem")
        self.assertIn("check_quick.cc", commands)
        for layer in ("math", "linear", "solve", "sparse", "marginalize", "window", "files", "experiments"):
            self.assertNotIn(f"/ch5_backend/{layer}/", commands)
        for file in ("edge_reprojection_batch", "slips"):
            self.assertNotIn(file, commands)
        self.assertIn("slips", self.commands(BUILD, "check_problem"))

    def test_without_googletest_there_are_the_library_and_the_programs(self):
        with tempfile.TemporaryDirectory() as folder:
            done = run("cmake", "--preset", "release", "-B", folder, f"-DCMAKE_CXX_COMPILER={CXX}", "-DCMAKE_DISABLE_FIND_PACKAGE_GTest=ON", cwd=ROOT)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertIn("No GoogleTest", done.stdout)
            everything = self.commands(folder, "all")
            self.assertIn("bin/ch5_chapter", everything)
            self.assertNotIn("/tests/", everything)
