"""What the fourth lecture says in words holds in its tables."""

import re
import unittest
from math import degrees, radians

import numpy as np

from tests.project import OUT, ROOT

from slides import gauge_examples as toy
from slides.deck_gauge import facts
from ch5_backend.figures.tables import Tables

TABLES = Tables(OUT / "csv")
FOLDER = OUT / "gauge"


class Examples(unittest.TestCase):
    def test_q_is_a_projection_into_the_gauge(self):
        H, U, free, V, Q, fixed = toy.two_numbers()
        for zero in (H @ U, Q @ U, V.T @ Q, Q @ Q - Q, H @ free @ H - H, fixed - np.diag([0, toy.SIGMA ** 2])):
            self.assertFalse(zero.any())
        self.assertEqual(toy.difference_variance(free), toy.difference_variance(fixed))

    def test_a_tilted_book_turns_by_the_area_of_its_loop(self):
        self.assertAlmostEqual(abs(toy.tilted_yaw()), degrees(radians(toy.TILT) ** 2), delta=0.01)

    def test_a_weak_prior_creeps_and_all_end_in_the_valley(self):
        steps = {weight: len(toy.walk(weight)) for weight in (None, 0.0, toy.WEAK, 1e3)}
        self.assertGreater(steps[toy.WEAK], 1.5 * steps[0.0])
        self.assertLess(steps[1e3], steps[toy.WEAK])
        for weight in steps:
            a, b = toy.walk(weight)[-1]
            self.assertAlmostEqual(b - a, 1, delta=0.01)
        a, b = toy.walk(0.0)[-1]
        self.assertAlmostEqual(a, -b, delta=1e-9, msg="the shortest way")


class GaugeClaims(unittest.TestCase):
    def setUp(self):
        if not (FOLDER / "csv/methods.csv").exists():
            self.skipTest(f"{FOLDER} has no tables; ./course slides writes them")
        self.facts = facts(TABLES)

    def test_numbers_of_recordings_are_those_of_the_model_answer(self):
        answer = (ROOT / "solutions/gauge_freedom.md").read_text(encoding="utf-8")
        plain = re.sub(r"<!--.*?-->", "", answer)
        for name in ("real.fixation_position", "real.free_position", "real.fixation_iterations", "real.free_iterations"):
            self.assertIn(self.facts[name], plain)
