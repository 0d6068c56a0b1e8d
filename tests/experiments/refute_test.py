"""./course refute: the numbers of pairs are checked, the usual slip is named, and only what is right is kept."""

import csv
import os
import subprocess

import numpy as np

from ch5_backend.course.experiments.refute import NAME, mean_and_error, sign_of, slip
from ch5_backend.figures import tables
from tests.folder import FolderTest
from tests.project import ROOT, run

ONE, OTHER = np.array([7.0, 9.0, 12.0, 6.0]), np.array([5.0, 8.0, 9.0, 6.0])  # the handout's
TABLE = "refute/csv/near_start.csv"


class Refute(FolderTest):
    def refute(self, lines: str, *words) -> subprocess.CompletedProcess:
        return run(ROOT / "course", "refute", *words, "--out", self.folder, input=lines,
                   env={**os.environ, "LC_ALL": "C.UTF-8", "CH5_CHECK_FOLDER": str(self.folder)})

    def kept(self) -> list:
        with open(self.folder / NAME, newline="", encoding="utf-8") as file:
            return list(csv.reader(file))

    def test_right_numbers_are_the_handouts_and_each_usual_slip_is_named(self):
        mean, error = mean_and_error(ONE - OTHER)
        self.assertAlmostEqual(mean, 1.5)
        self.assertAlmostEqual(error, np.sqrt(5 / 3) / 2)
        self.assertEqual(sign_of(mean, error), "+")
        slips = {"": (mean, error), "mean": (mean + 0.1, error), "other_way_around": (-mean, error), "of_one": (mean, 2 * error),
                 "variance": (mean, 4 * error ** 2), "by_n": (mean, error * np.sqrt(3 / 4)), "of_one_by_n": (mean, error * np.sqrt(3)),
                 "not_paired": (mean, np.sqrt(7 / 4 + 10 / 12)), "error": (mean, 5.0)}
        for name, numbers in slips.items():
            self.assertEqual(slip(ONE, OTHER, *numbers), name and f"refute.slip_{name}")

    def test_what_chance_can_do_decides_no_sign(self):
        self.assertEqual([sign_of(*numbers) for numbers in ((1.0, 0.6), (-1.0, 0.6), (-1.0, 0.4))], ["0", "0", "-"])

    def test_it_asks_until_an_answer_is_right_and_keeps_it(self):
        rows = [(k, start, w, value + 4 * (start == "stated"), 60) for start in ("stated", "less damping", "earlier stop")
                for w, values in ((10, ONE), (1e8, OTHER)) for k, value in enumerate(values)]
        (self.folder / TABLE).parent.mkdir(parents=True)
        tables.write(self.folder / TABLE, ("trial", "start", "weight", "iterations", "start_px"), rows)
        first = self.refute("1.5 1.29\n1.5 0.645\n0\n+\n", "2")
        self.assertEqual(first.returncode, 1, first.stderr)
        self.assertIn("standard deviation of one difference", first.stdout)
        self.assertIn("2.32558 times its standard error", first.stdout)
        self.assertEqual(self.kept(), [["2", "peak_stated", "1.5", "0.645", "+"]])
        self.assertEqual(self.refute("1.5 0.645\n+\n3/2 0.6455\n+\n\n", "2").returncode, 1, "no sentence is none")
        rest = self.refute("The peak moves.\n", "2")
        self.assertEqual(rest.returncode, 0, rest.stderr)
        self.assertEqual(self.kept()[-1], ["2", "", "The peak moves."])
        self.assertEqual(len(self.kept()), 4)
        self.assertEqual(self.refute("", "2").returncode, 0, "nothing is left to ask")
