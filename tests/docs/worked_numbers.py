"""What the handouts work out by hand is what the course's solvers compute."""

import os
import re
import subprocess
import unittest
from pathlib import Path

from tests.docs.markdown import HANDOUTS, ROOT, read

PROGRAM = Path(os.environ.get("CH5_HANDOUT_NUMBERS", ROOT / "build/release/tests/docs/handout_numbers"))

# How a number, or a row of numbers, stands in the text; of others each row stands in brackets, [ 1  2 ].
SENTENCES = {
    "paper.before": "cost = {} before,",
    "paper.after": "before, {} after",
    "paper.delta_x": "Δx = ({})",
    "paper.delta_x_without_x0": "Δx = ({}) as before",
    "paper.H_x1": "H = {},",
    "paper.b_x1": "b = {},",
    "paper.J": "J = √0.75 = {}",
    "paper.r0": "r₀ = {}",
    "chain.before": "solution ({})",
    "chain.after": "solution ({})",
    "scene.rows": "3 · 6 + 20 = {} rows",
    "scene.zeros_in_H": "zero blocks of H_pp: {}",
    "scene.zeros_in_S": "zero blocks of S: {}",
    "zeros.0": "no prior {}",
    "zeros.1": "one {}",
    "zeros.2": "two {}",
    "line.free": "free: {}",
    "line.held": "x1 held: {}",
    "rank_one.e0": "e₀ = −(0.25 · 6 + 0.5 · 3) = {}",
    "rank_one.e": "e = −3 + 2 = {}",
    "rank_one.e_null": "e = −3 + 2 · 1 + 1 · (−2) = {}",
    "cut.before": "rows of J: {},",
    "cut.after": "then {}",
    "drive.blocks": "= {} blocks",
}


def decimal(text):
    """Six digits; what is only a rounding error beside 1 is 0."""
    value = float(text)
    return f"{value if abs(value) > 1e-9 else 0.0:.6g}".replace("-", "−")


def plain(text):
    return re.sub(r"\s+", " ", text)


class WorkedNumbers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if not PROGRAM.exists():
            raise unittest.SkipTest(f"{PROGRAM} is not built")
        lines = subprocess.run([PROGRAM], capture_output=True, text=True, check=True).stdout.splitlines()
        cls.rows = [(name, [decimal(number) for number in numbers]) for name, *numbers in map(str.split, lines)]

    def test_every_number_is_the_solvers(self):
        self.assertGreater(len(self.rows), 40)
        for path in HANDOUTS:
            text = plain(read(path))
            for name, numbers in self.rows:
                wanted = SENTENCES.get(name, "[ {} ]").format((", " if name in SENTENCES else " ").join(numbers))
                self.assertTrue(wanted in text, f"{path}: {name}: there is no '{wanted}'")

    def test_every_sentence_has_its_number(self):
        self.assertLessEqual(set(SENTENCES), {name for name, _ in self.rows})
