"""homework_judge and its workers: what does not speak is told, and no answer is linked."""

import json
import re
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from ch5_backend.course.base.cmake_build import build_or_fail
from ch5_backend.course.homework.regions import STAGES
from tests.project import BUILD, ROOT, run

BIN = BUILD / "bin"


def judge(worker: list, tests: str, *options) -> dict:
    """{test: words of its first failure, or ""}"""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.json"
        done = run(BIN / "homework_judge", "--quiet", f"--gtest_filter={tests}", f"--gtest_output=json:{report}", *options, "--", *worker,
                   cwd=folder, timeout=250)
        suites = json.loads(report.read_text(encoding="utf-8"))["testsuites"]
    failures = {test["classname"] + "." + test["name"]: test.get("failures", [{"failure": ""}])[0]["failure"]
                for suite in suites for test in suite["testsuite"]}
    assert done.returncode == any(failures.values()), (done.returncode, failures, done.stdout)
    return failures


def names() -> list:
    return sorted({Path(stage["file"]).stem for stage in STAGES})


class Verdicts(unittest.TestCase):
    def test_a_worker_that_does_not_speak_is_told(self):
        for worker, words in (["/bin/true"], "START: EXIT 0"), (["/nowhere"], "START: EXIT 127"), \
                (["/bin/cat"], "START: TIMEOUT"), (["/bin/echo", "hello"], "GARBAGE"), (["/bin/sleep", "9"], "TIMEOUT"):
            failures = judge(worker, "Stage2.TheSlides*", "--time-limit=0.5")
            self.assertIn(words, failures["Stage2.TheSlidesExample"])

    def test_who_does_not_end_once_has_less_time_afterwards(self):
        for worker, seconds in ((["/bin/cat"], 6.0), (["/bin/sleep", "99"], 6.0)):
            begin = time.monotonic()
            failures = judge(worker, "Stage6.*", "--time-limit=4")
            self.assertGreater(len(failures), 15)
            self.assertTrue(all("TIMEOUT" in words for words in failures.values()), failures)
            self.assertLess(time.monotonic() - begin, seconds)

    def test_the_solutions_are_right_with_seeds_that_were_unlucky(self):
        for seed, test in ((327, "Stage3.Drift*"), (575, "Stage6.EqualsADense*")):
            failures = judge([str(BIN / "worker_samples"), "--submission=linked"], test, f"--seed={seed}")
            self.assertEqual([*failures.values()], [""], test)

    def test_wrong_calls_are_refused(self):
        for words in ([], ["--"], ["--seed=-1", "--", "true"], ["--seed=x", "--", "true"], ["--time-limit=0", "--", "true"],
                      ["--other", "--", "true"]):
            done = subprocess.run([BIN / "homework_judge", *words], capture_output=True, check=False)
            self.assertEqual(done.returncode, 2, words)


# What computes an answer, elsewhere than in the student's file: nowhere in what a worker is linked with.
ANSWERS = re.compile(r"""ch5::(
    (Problem::(MakeHessian|SolveLinearSystem|TestMarginalize)
    |AddMonoBaEdges|BuildMonoBa|AddMinimalGaugePrior
    |Gauge(NullSpace|Projection|MotionJacobian)|TransformCovariance
    |MarginalizationError::(InsertBlock|SchurComplement|UpdateErrorComputation|Residual)
    |MarginalizationInfo::(PreMarginalize|ConstructA|SchurComplement|Factor|GetParameterBlocks)
    |DropSetOf\w+|SlideWindow|DetectFailure
    |PlainBlockSolver::(BuildStructure|BuildSystem|Solve)
    |UpdateDamping|LinearizeProjection|IntegrateImu|LinearizeRange
    |FactorNormalEquations|EliminateVertices|Marginalize\w*|ReplacePrior
    |homework::(StackedNormalEquations|RandomSystem|Numeric\w+|FreeCovariance|FixedCovariance|Story|Right\w+))\(
    |(Sparse(Solver|Optimizer)|Estimator|OkvisPolicy|VinsPolicy|ImplicitS\w+)::)""", re.VERBOSE)


JUDGE = ROOT / "ch5_homework" / "judge"
# What a worker may be made of beside the library's layers: what asks, and what it asks about.
OF_A_WORKER = re.compile(r"ch5_homework/judge/(checks|scenes)/\w+\.h|ch5_homework/judge/(values|submission|seed)\.h")


class TheWall(unittest.TestCase):
    """Between what asks (checks/, scenes/), which stands beside the student's file, and all that knows what is right."""

    def test_what_asks_includes_nothing_that_knows(self):
        files = [path for folder in ("checks", "scenes") for path in sorted((JUDGE / folder).iterdir())]
        self.assertGreater(len(files), 10)
        for path in files:
            included = re.findall(r'^#include "(ch5_homework/[^"]+)"', path.read_text(encoding="utf-8"), re.MULTILINE)
            self.assertEqual([name for name in included if not OF_A_WORKER.fullmatch(name)], [], path.name)

    def test_a_worker_is_made_of_nothing_else(self):
        others = {"worker", "unset_memory", "wire", "values", "submission", "seed", "check"}
        scenes = {path.stem for path in (JUDGE / "scenes").glob("*.cc")}
        for name in names():
            members = run("ar", "t", BIN.parent / "lib" / f"libworker_{name}.a", check=True).stdout.split()
            stems = {member.partition(".")[0] for member in members}
            self.assertIn(name, stems)
            self.assertEqual(stems - others - scenes - {name}, set(), name)


class UsualExpressions(unittest.TestCase):
    """ch5_homework/judge/remote/usual_expressions.h"""

    def test_a_submission_compiles_none_of_them_again(self):
        build_or_fail(["homework_grader"])
        compiler = json.loads((BUILD / "grader" / "toolchain.json").read_text(encoding="utf-8"))["compile"][0]
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "step.cc"
            file.write_text("""namespace ch5 {
void Step(const Edge& edge, const MatXX& B, MatXX* A, VecX* x) {
  *A = B.block(0, 0, 2, 2) - *A * B;
  *x -= edge.Jacobian(0).transpose() * *x;
}
}""", encoding="utf-8")
            made = run(*compiler, "-S", "-emit-llvm", file, "-o", "-", check=True).stdout
        defined = re.findall(r"^define (?!internal )[^@\n]*@(\w+)", made, re.MULTILINE)
        self.assertEqual([name for name in defined if not name.startswith("_ZN3ch54Step")], [])
        self.assertEqual(len(defined), 1)


class Archives(unittest.TestCase):
    def test_no_answer_can_be_called(self):
        for name in names():
            for archive in (f"libworker_{name}.a", f"libworker_layers_{name}.a"):
                symbols = run("nm", "--demangle", "--defined-only", BIN.parent / "lib" / archive, check=True).stdout.splitlines()
                defined = [line.split(maxsplit=2)[2] for line in symbols if re.match(r"[0-9a-f]{16} [A-Za-z] ", line)]
                self.assertGreater(len(defined), 50)
                self.assertEqual([symbol for symbol in defined if ANSWERS.match(symbol)], [], archive)

    def test_the_search_finds_answers(self):
        symbols = run("nm", "--demangle", "--defined-only", BIN / "homework_judge", check=True).stdout
        for name in ("FactorNormalEquations", "EliminateVertices", "homework::StackedNormalEquations"):
            self.assertTrue(any(name in line and ANSWERS.match(line.split(maxsplit=2)[2]) for line in symbols.splitlines()
                                if len(line.split(maxsplit=2)) == 3), name)
