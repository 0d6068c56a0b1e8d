"""What the handouts work out by hand is what the course's solvers compute."""

import os
import unittest
from pathlib import Path

from tests.docs.markdown import ROOT, handouts, plain
from tests.project import run

PROGRAM = Path(os.environ.get("CH5_HANDOUT_NUMBERS", ROOT / "build/release/tests/docs/handout_numbers"))

# How a number, or a row of numbers, is written in the text: in both languages, or in English and in Chinese. Of others
# each row is in brackets, [ 1  2 ].
SENTENCES = {
    "paper.before": ("cost: {} →", "代价：{} →"),
    "paper.after": "→ {}",
    "paper.delta_x": "Δx = ({})",
    "paper.delta_x_without_x0": ("Δx = ({}) as before", "Δx = ({}) 与之前相同"),
    "paper.H_x1": "H = {},",
    "paper.b_x1": "b = {},",
    "paper.J": r"J = \sqrt{{0.75}} = {}",
    "paper.r0": "r_0 = {}",
    "chain.before": ("solution ({})", "解 ({})"),
    "chain.after": ("solution ({})", "解 ({})"),
    "scene.rows": ("3 · 6 + 20 = {} rows", "3 · 6 + 20 = {} 行"),
    "scene.zeros_in_H": ("zero blocks of H_{{pp}}: {}", "H_{{pp}} 的零块：{}"),
    "scene.zeros_in_S": ("Zero blocks of S: {}", "S 的零块：{}"),
    "zeros.0": ("no prior {}", "没有先验 {}"),
    "zeros.1": ("one {}", "一个先验 {}"),
    "zeros.2": ("two {}", "两个先验 {}"),
    "line.free": ("free: {}", "自由：{}"),
    "line.held": ("x_1 held: {}", "固定 x_1：{}"),
    "rank_one.e0": "e_0 = −(0.25 · 6 + 0.5 · 3) = {}",
    "rank_one.e": "e = −3 + 2 = {}",
    "rank_one.e_null": "e = −3 + 2 · 1 + 1 · (−2) = {}",
    "cut.before": ("rows of J: {},", "J 的行数：{}，"),
    "cut.after": ("then {}", "之后：{}"),
    "background.marginal": "= 2 − 1 = {}",
    "background.determinant": "det = {}",
    "drive.blocks": ("= {} blocks", "= {} 块"),
}


def decimal(text):
    """Six digits; what is only a rounding error beside 1 is 0."""
    value = float(text)
    return f"{value if abs(value) > 1e-9 else 0.0:.6g}".replace("-", "−")


class WorkedNumbers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if not PROGRAM.exists():
            raise unittest.SkipTest(f"{PROGRAM} is not built")
        lines = run(PROGRAM, check=True).stdout.splitlines()
        cls.rows = [(name, [decimal(number) for number in numbers]) for name, *numbers in map(str.split, lines)]

    def test_every_number_is_the_solvers(self):
        self.assertGreater(len(self.rows), 40)
        for language, (pages, text) in enumerate(handouts()):
            for name, numbers in self.rows:
                sentence = SENTENCES.get(name, "[ {} ]")
                sentence = sentence if isinstance(sentence, str) else sentence[language]
                wanted = sentence.format((", " if name in SENTENCES else " ").join(numbers))
                self.assertIn(wanted, plain(text), f"{pages[0]}: {name}")

    def test_every_sentence_has_its_number(self):
        self.assertLessEqual(set(SENTENCES), {name for name, _ in self.rows})
