"""What a student is told whose file does not compile, or whose blank was left empty in a way that ends the program."""

import shutil
import subprocess
import tempfile
import time
import unittest
from pathlib import Path
from unittest import mock

from ch5_backend.course.homework.regions import ROOT, STAGES, fill, solution_text

from ch5_backend.course.homework import blanks, compiler, judge
from ch5_backend.course.base.language import speaker
from ch5_backend.course.homework.diagnosis import Verdict, because, in_short
from tests.project import run

ENGLISH = speaker("en")

# Enough for a parser; what is included needs no Eigen.
TINY = """struct Qd {};
struct Vec3 {};
#include <memory>
struct Edge { Edge(const Qd& q, const Vec3& p); };
struct Problem { void MakeHessian(); void Solve(); };
void Problem::MakeHessian() {
  if (sizeof(int) > 2) {
    auto edge = std::make_shared<Edge>(Qd(), Vec3());
  }
}
void Problem::Solve() {}
"""


def left_empty(name: str, todo: str) -> str:
    """The solution, with this blank's hints alone: neither code nor a throw."""
    return fill(solution_text(name), lambda region: region.hints if region.todo == todo else region.solution)


def line_of(text: str, words: str) -> int:
    return text[:text.index(words)].count("\n") + 1


@unittest.skipUnless(shutil.which("g++"), "the words are g++'s")
class WordsOfTheCompiler(unittest.TestCase):
    def hint(self, content, link: str = "", compiler_name: str = "g++") -> str:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "problem.cc"
            path.write_bytes(content if isinstance(content, bytes) else content.encode())
            main = Path(folder) / "main.cc"
            main.write_text(link or "int main() {}")
            done = subprocess.run([compiler_name, "-std=c++17", path, main, "-o", Path(folder) / "check"], capture_output=True,
                                  text=True, errors="replace", check=False)
            with mock.patch.object(compiler, "HOMEWORK", Path(folder)):
                verdict = compiler.does_not_compile("problem.cc", done.stdout + done.stderr, path.read_bytes())
        return in_short(verdict.diagnosis, ENGLISH)

    def test_what_a_file_lacks_or_has_too_much(self):
        declared = TINY.replace("void Problem::MakeHessian() {\n", "void Helper(int n);\nvoid Problem::MakeHessian() {\n  Helper(1);\n")
        for content, words in (
                (TINY.replace("  }\n}\nvoid", "}\nvoid"), "problem.cc:10: a closing brace is missing"),
                (TINY.replace(" > 2) {", " > 2) int a = 1;").replace("  }\n}", "    a = 2;\n  }\n}"),
                 "problem.cc:9: one closing brace too many above line 9, or an opening one is missing"),
                (TINY.replace("  }\n}\nvoid", "  }\n}\n}\nvoid"), "problem.cc:11: one closing brace too many"),
                (declared, "Helper is used in problem.cc, but nothing defines it"), ("\n", "problem.cc is empty"),
                (TINY.encode("utf-16"), "saved as UTF-16"), (TINY.encode("utf-16-le"), "saved as UTF-16")):
            self.assertIn(words, self.hint(content))

    def test_a_function_that_the_library_has_too(self):
        library = "int Hat(double x) { return x; }\nint main() {}"
        told = "Hat is defined in problem.cc and in the library too"
        self.assertIn(told, self.hint("int Hat(double x) { return 2 * x; }\n" + TINY, library))
        self.assertIn("a main of its own", self.hint("int main() {}\n" + TINY))
        lld = "ld.lld: error: duplicate symbol: ch5::Hat(double)\n>>> defined at problem.cc\n"
        self.assertIn(told, in_short(compiler.does_not_compile("problem.cc", lld, b"x").diagnosis, ENGLISH))

    def test_typical_slips(self):
        line = "if (sizeof(int) > 2) {"
        for slip, words in (("int a = 1；", "problem.cc:7: this line has a full-width ；, which C.. does not know; write \";\""),
                            ("int a = sizeof（int);", "this line has a full-width （.*; write \"[(]\""),
                            ("int a = 2 − 1;", "problem.cc:7: this line has −, as in a printed formula; in C.. write -"),
                            ("\u200bint a = 1;", "problem.cc:7: this line has an invisible character, U.200B"),
                            ("int a = ?;", "problem.cc:7: a . of the skeleton is still there"),
                            ("cout << 1;", "problem.cc:7: to print, write std::cerr"), ("std::cout << 1;", "problem.cc:7: to print, write"),
                            ("int a = 1 + Solve;", "problem.cc:7: the . . of a function call are missing"),
                            ("const std::map<int, int> shift; int a = shift[3];", "problem.cc:7: this changes something that is const")):
            text = TINY.replace(line, f"{slip} {line}").replace("#include <memory>", "#include <map>\n#include <memory>").replace(
                "struct Qd {};\n", "struct Qd {}; ")
            for name in ("g++", "clang++"):
                with self.subTest(slip=slip, compiler=name):
                    if shutil.which(name):
                        self.assertRegex(self.hint(text, compiler_name=name), words)

    @unittest.skipUnless(Path("/usr/include/eigen3").exists(), "needs Eigen")
    def test_slips_with_eigen_are_told_in_a_sentence(self):
        slips = {"m = -v.cwiseSqrt().asDiagonal() * m;": "minus sign", "m.block(0, 0, 2, 2) =+ m;": "where \\+= is meant",
                 "d = std::max(1 / 3, d);": "same type", "m = v.array().sqrt() * m;": "do not mix", "v = v.sqrt();": "whole matrix",
                 "m = m / m;": "does not divide", "m.block(0, 0, 2, 2) = 0;": "cannot be assigned", "m = m + 1e-6;": "cannot be added",
                 "m += 1e-6;": "cannot be added", "m = m.block(0, 0);": "four numbers", "d = seen.contains(1);": "C\\+\\+17",
                 "for (int i : std::views::iota(0, 3)) d = i;": "C\\+\\+17", "d = d^3;": "std::pow", "<<<<<<< HEAD": "git's",
                 "```cpp": "between the marks"}
        code = "#include <Eigen/Dense>\n#include <map>\nvoid f(Eigen::MatrixXd& m, Eigen::VectorXd& v, double& d, std::map<int, int>& seen) {\n" \
            + "\n".join(slips) + "\n}\n"
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "problem.cc"
            path.write_text(code)
            said = run("g++", "-std=c++17", "-fsyntax-only", "-I/usr/include/eigen3", path).stderr.splitlines()
        for number, (line, words) in enumerate(slips.items(), 4):
            error = next(one for one in said if f"problem.cc:{number}:" in one and "error: " in one)
            self.assertRegex(ENGLISH.text(compiler.explain_slip(error, error, code.encode())), words, line)

    def test_names_and_numbers_may_be_of_any_length(self):
        name, digits = "a" * 50_000, "9" * 5000
        begin = time.process_time()
        for error in (f"ld.lld: error: undefined symbol: {name}()", f"problem.cc:{digits}:1: error: expected {name}"):
            self.assertIn(name, in_short(compiler.does_not_compile("problem.cc", error, b"int x;\n").diagnosis, ENGLISH))
        self.assertIsNone(blanks.still_empty(f"MatXX {'a, ' * 50_000}\nb = a;\n", 2))
        self.assertLess(time.process_time() - begin, 1.0)  # and not a minute
        with mock.patch.object(judge, "output_of", return_value=f"/problem.cc:{digits}:1"):
            self.assertEqual(judge.locate(Path("worker"), "problem.cc", "worker(+0x1)", judge.output_of), "")

    def test_exchanged_arguments_show_the_students_line(self):
        for name, words in (("g++", r"function .*Edge::Edge\(Vec3, Qd\)"), ("clang++", "constructor .*Edge")):
            if shutil.which(name):
                hint = self.hint(TINY.replace("Qd(), Vec3()", "Vec3(), Qd()"), compiler_name=name)
                self.assertRegex(hint, rf"problem.cc:8:\d+: no matching {words}")

    def test_a_missing_function(self):
        call = TINY.replace("{\n  if", ";//").split("void Problem::")[0] + "int main() { Problem().MakeHessian(); }"
        without = TINY.split("void Problem::")[0] + "void Problem::Solve() {}\n"
        self.assertIn("the function Problem::MakeHessian is missing in problem.cc; it was there in the skeleton",
                      self.hint(without, call))

    def test_a_header_that_is_not_the_students(self):
        words = f"{ROOT}/ch5_backend/dense/problem.h:30:5: error: expected ';' before '}}' token"
        told = in_short(compiler.does_not_compile("problem.cc", words, b"int x;").diagnosis, ENGLISH)
        self.assertIn("ch5_backend/dense/problem.h:30 does not compile, and that file is not part of the homework", told)
        self.assertIn("git checkout ch5_backend/dense/problem.h", told)

    def test_a_place_names_the_folder_that_is_judged(self):
        with mock.patch.object(compiler, "HOMEWORK", Path("/somewhere/else")):
            self.assertEqual(compiler.shorten("/somewhere/else/problem.cc:1"), "/somewhere/else/problem.cc:1")
        for folder in (ROOT, Path("/home/student")):  # inside of the project; where the student stands
            with mock.patch.object(compiler, "HOMEWORK", folder / "mine"), \
                 mock.patch.object(Path, "cwd", return_value=Path("/home/student")):
                self.assertEqual(compiler.shorten(f"{folder}/mine/problem.cc:1"), "mine/problem.cc:1")


class BlanksLeftEmpty(unittest.TestCase):
    def test_the_variable_and_its_todo_are_named(self):
        for todo, words, variable in (("1.2a", "Hmm.block(idx", "Hmm"), ("1.2a", "tempH = Hpm", "Hpm"),
                                      ("1.2a", "H_pp_schur_ = H.block", "Hmp"), ("1.2a", "b_pp_schur_ = bpp", "bpp"),
                                      ("2c", "tempB = Arm", "Arm")):
            text = left_empty("problem.cc", todo)
            self.assertEqual(blanks.still_empty(text, line_of(text, words)), (variable, todo), words)

    def test_nothing_is_said_of_what_is_assigned(self):
        text = solution_text("problem.cc")
        for number in range(len(text.splitlines()) + 2):
            self.assertIsNone(blanks.still_empty(text, number), number)

    def test_a_crash_says_it_first(self):
        text = left_empty("problem.cc", "1.2a")
        content, place = text.encode(), line_of(text, "Hmm.block(idx")
        crash = Verdict("crashes", {**because("judge.crash", signal="", where=""), "place": f"problem.cc:{place}"})
        told = in_short(blanks.explain(crash, STAGES[1], content).diagnosis, ENGLISH)
        self.assertIn("Hmm is still empty: nothing was assigned to it in TODO 1.2a", told)
        for other in (crash._replace(state="wrong"), Verdict("crashes", because("judge.crash")), Verdict("right")):
            self.assertEqual(blanks.explain(other, STAGES[1], content), other)

    def test_warnings_are_of_the_students_own_lines(self):
        path = Path("/a b/作业/problem.cc")
        output = f"""[1/2] Building CXX object check_problem_student.dir/problem.cc.o
{path}: In member function ‘virtual void ch5::Problem::MakeHessian()’:
{path}:41:15: warning: suggest parentheses around assignment used as truth value [-Wparentheses]
   41 |         if (i = j) {{}}
{path}:41:15: warning: suggest parentheses around assignment used as truth value [-Wparentheses]
/usr/include/eigen3/Eigen/Core:7:1: warning: not the student's [-Wextra]
{path}:9:1: warning: multi-line comment [-Wcomment]
"""
        self.assertEqual(compiler.warnings(path, output), [[41, "suggest parentheses around assignment used as truth value"], [9, "multi-line comment"]])
