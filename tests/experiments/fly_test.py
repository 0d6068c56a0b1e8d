"""./course run --mine and ./course fly on a folder of homework of their own: whose lines run, and where they differ."""

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from unittest import mock

from ch5_backend.course.base.cmake_build import build_or_fail
from ch5_backend.course.base.errors import CourseError
from ch5_backend.course.experiments import fly
from ch5_backend.course.homework.own_functions import symbols, unfinished, weaken
from ch5_backend.course.homework.make_skeleton import skeleton
from ch5_backend.course.homework.regions import FILES, STAGES, solution_text
from ch5_backend.figures.numbers.mine import EXPERIMENTS, Mine
from tests.folder import FolderTest
from tests.homework.hand_in import SKELETONS, hand_in
from tests.project import BUILD, run

FOLDER = Path(os.environ["CH5_CHECK_FOLDER"])
OWN = os.environ["CH5_CHECK_PREFIX"] + "ch5_homework_mine"
EXPERIMENT_OF = {stage["file"]: [name for name, ids in EXPERIMENTS.items() if any(row["id"] in ids for row in STAGES if row["file"] == stage["file"])]
                 for stage in STAGES}
# Each as a student makes it: the file, what stands in the solution, what is written in its place, the experiment that shows it.
MISTAKES = (
    ("problem.cc", "H.block(index_j, index_i, dim_j, dim_i).noalias() += hessian.transpose()", "(void)hessian", "hessian"),
    ("gauge_prior.cc", "i < 2", "i < 1", "weights"),
    ("gauge_freedom.cc", "-Hat(p)", "Hat(p)", "gauge"),
    ("marginalization_error.cc", "e0_ = -J_pinv_T", "e0_ = J_pinv_T", "okvis"),
    ("vins_window.cc", "rr.V.transpose() * kept.b", "rr.V.transpose() * -kept.b", "vins"),
    ("block_solver.cc", "S_(i, j) -=", "S_(i, j) +=", "blocks"))


class Fly(FolderTest):
    def course(self, *words) -> str:
        done = run(sys.executable, "-m", "ch5_backend.course", *words, "--out", self.folder)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_the_solution_is_its_own_equal(self):
        hand_in(FOLDER)
        told = self.course("run", "--mine")
        mine = Mine(self.folder)
        self.assertEqual({name: mine.finding(name).key for name in EXPERIMENTS}, {name: "same" for name in EXPERIMENTS}, told)
        page = (self.folder / "mine.html").read_text(encoding="utf-8")
        self.assertEqual(page.count("<details>"), 3)  # the questions at the end
        self.assertEqual(page.count("data:image/webp"), len(EXPERIMENTS))

    def test_an_empty_homework_is_told_before_a_build(self):
        hand_in(FOLDER, **SKELETONS)
        with mock.patch.object(fly, "build_or_fail") as build:
            for chosen in (fly.FLIGHTS, tuple(EXPERIMENTS)):
                self.assertRaisesRegex(CourseError, "none of your functions would run yet: in .*vins_window.cc", fly.require_own, chosen)
        build.assert_not_called()

    def test_a_stage_that_is_half_done_is_theirs(self):
        """After 6A the priors are the student's, with 6B still empty."""
        head = "void SlideWindow(MarginalizationFlag flag, Window* window) {\n"
        half = solution_text("vins_window.cc").replace(head, head + '  throw HomeworkMissing("6i SlideWindow, x");\n')
        hand_in(FOLDER, **{**SKELETONS, "vins_window": half})
        told = self.course("fly")
        self.assertIn("✓ 6 ", told)
        self.assertIn("– 5 ", told)
        self.assertIn("6i still empty", told)

    def test_what_is_empty_is_the_solutions(self):
        half = solution_text("problem.cc").replace("H.block(index_i", 'throw HomeworkMissing("1.1a MakeHessian, x");\nH.block(index_i')
        hand_in(FOLDER, **{**SKELETONS, "problem": half})
        told = self.course("run", "--mine")
        mine = Mine(self.folder)
        self.assertEqual({name: mine.finding(name).key for name in EXPERIMENTS}, {name: "same" for name in EXPERIMENTS}, told)
        self.assertEqual(mine.empty_todos("problem.cc"), {"1.1a": "MakeHessian"})
        for stage in STAGES:
            if stage["file"] != "problem.cc":
                self.assertEqual(sorted(mine.empty_todos(stage["file"])), sorted(stage["todos"]))
        self.assertIn("– 3 ", told)
        self.assertIn("1.1a still empty", told)

    def test_each_mistake_shows_where_it_is(self):
        wrong = {Path(name).stem: solution_text(name).replace(right, mistake) for name, right, mistake, _ in MISTAKES}
        for name, text in wrong.items():
            self.assertNotEqual(text, solution_text(f"{name}.cc"))
        hand_in(FOLDER, **wrong)
        told = self.course("run", "--mine")
        mine = Mine(self.folder)
        for _, _, _, experiment in MISTAKES:
            self.assertFalse(mine.finding(experiment).same, f"{experiment}\n{told}")
        self.assertIn("✗", told)

    def test_a_file_that_does_not_compile_is_the_solutions(self):
        hand_in(FOLDER, marginalization_error=solution_text("marginalization_error.cc").replace("const MatXX M = W", "const MatXX M = Q"))
        told = self.course("fly")
        mine = Mine(self.folder)
        self.assertTrue(mine.finding("okvis").same)
        self.assertIn("marginalization_error.cc does not compile", told)
        self.assertEqual(list(mine.failures), ["okvis", "vins"])

    def test_each_graded_function_is_at_work(self):
        """The program is linked once for each function, which then throws: its experiment must fail or change."""
        hand_in(FOLDER, **SKELETONS)
        build_or_fail([OWN])
        commands = run("ninja", "-C", BUILD, "-t", "commands", OWN, check=True).stdout.splitlines()
        link = shlex.split(commands[-1])  # ": && COMPILER … && :"
        link = link[link.index("&&") + 1:len(link) - 1 - link[::-1].index("&&")]
        idle = []
        for file in FILES:
            functions = unfinished(skeleton(file))
            made = next(word for word in link if word.endswith(f"{file}.o") and f"/{OWN}_" in f"/{word}")
            whole = self.whole_object(file, commands)
            for function in functions:
                one = self.folder / f"{file}.{function}.o"
                shutil.copy(whole, one)
                weaken(one, [other for other in functions if other != function])
                self.assertTrue(symbols(one, [function]), function)
                program = self.folder / "program"
                exchanged = {made: one, f"bin/{OWN}": program}
                subprocess.run([exchanged.get(word, word) for word in link], check=True, cwd=BUILD, capture_output=True)
                if not any(self.changes(program, experiment) for experiment in EXPERIMENT_OF[file]):
                    idle.append(f"{file}: {function}")
        self.assertEqual(idle, [])

    def whole_object(self, file, commands) -> Path:
        """The skeleton's object with all its functions, as the compiler, or its cache, hands it to own_functions.py."""
        every, made = map(shlex.split, commands), self.folder / f"{file}.o"
        command = next(words for words in every if words[-2:] == ["-c", str(FOLDER / file)] and any(f"/{OWN}." in word for word in words))
        words = command[next(i for i, word in enumerate(command) if word.endswith(".json")) + 1:]
        words[words.index("-o") + 1] = str(made)
        subprocess.run(words, check=True, cwd=BUILD)
        return made

    def changes(self, program, experiment) -> bool:
        done = run(program, experiment, "--out", self.folder / "table")
        return done.returncode != 0
