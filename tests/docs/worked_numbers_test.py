"""What the handouts work out by hand is what the course's solvers compute."""

import json
import os
import unittest
from pathlib import Path

from tests.docs.markdown import ROOT, handouts, plain
from tests.project import run

PROGRAM = Path(os.environ.get("CH5_HANDOUT_NUMBERS", ROOT / "build/release/tests/docs/handout_numbers"))

# How a number, or a row of numbers, is written in the text. Of others each row is in brackets, [ 1  2 ].
SENTENCES = json.loads(Path(__file__).with_name("worked_numbers.json").read_text(encoding="utf-8"))


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
        for language, (pages, text) in zip(("en", "zh"), handouts()):
            for name, numbers in self.rows:
                wanted = SENTENCES[name][language].format(", ".join(numbers)) if name in SENTENCES else f"[ {' '.join(numbers)} ]"
                self.assertIn(wanted, plain(text), f"{pages[0]}: {name}")

    def test_every_sentence_has_its_number(self):
        self.assertLessEqual(set(SENTENCES), {name for name, _ in self.rows})
