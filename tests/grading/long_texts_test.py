"""A text that is made to be slow to read costs the grader no time: patterns take the square of a length, or more."""

import io
import time
import unittest
from pathlib import Path
from unittest import mock

from ch5_backend.course.grading.likeness import fingerprint
from ch5_backend.course.grading.provenance import foreign_code
from ch5_backend.course.grading.sandbox import Outcome
from ch5_backend.course.grading.toolchain import Toolchain
from ch5_backend.course.grading.unnamed import excerpt
from ch5_backend.course.homework import blanks, judge
from ch5_backend.course.homework.regions import STAGES, solution_text

N = 250_000  # letters of a file, as many as are taken


def compiler_says(words: str):
    return Toolchain._verdict(mock.Mock(include=Path("/include")), "problem.cc", Outcome(1, words, True, 1.0, 1.0), b"x",
                              Path("/given"))


def ended(words: str):
    printed = judge.Printed(io.BytesIO(words.encode()))
    printed.join()
    return judge.ended_early(Path("worker"), {"file": "problem.cc"}, printed, True, 1, 10.0, str)


TEXTS = {
    "the compiler's line": lambda: compiler_says("problem.cc:1:2: error: " + N * "a"),
    "the linker's line": lambda: compiler_says("ld.lld: error: undefined symbol: " + N * "a"),
    "assertions": lambda: ended(N // 5 * "Assertion `"),
    "TODOs": lambda: blanks.keeps_throw((N // 25 * "// TODO:: home work 1.1a.\n").encode(), "1.1a"),
    "names in a line": lambda: blanks.still_empty(N // 25 * "int x;\n" + ",".join(f"a{k}" for k in range(N // 12)), N // 25 + 1),
    "comments in a string": lambda: fingerprint({"problem.cc": b'"' + N // 3 * b"/* " + b'"'}),
    "comments without end": lambda: fingerprint({"problem.cc": N // 3 * b"/* "}),
    "quotes without end": lambda: fingerprint({"problem.cc": b'"' + N // 2 * b'\\"'}),
    "quotes without end, preprocessed": lambda: foreign_code(N // 2 * '"\\', False),
    "raw texts without end, preprocessed": lambda: foreign_code(N // 4 * 'uR"(', False),
    "a name in the intermediate code": lambda: foreign_code(f'@"{N // 3 * " = "}" = external global i32', True),
    "lines that no compiler sees": lambda: excerpt(STAGES[0], (solution_text(STAGES[0]["file"]) + "//" + N // 3 * "\u2028").encode(), "1.1a")}


class LongTexts(unittest.TestCase):
    def test_none_takes_long(self):
        for name, read in TEXTS.items():
            with self.subTest(name):
                begin = time.process_time()
                read()
                self.assertLess(time.process_time() - begin, 4.0)
