"""What the fourth lecture says in words holds in its tables, and it counts as the report does."""

import os
import re
import unittest
from math import degrees, radians
from pathlib import Path

from tests.docs.markdown import ROOT

from slides import deck4
from slides.deck4 import plots, toy
from slides.deck4.facts import difference
from slides.tables import Tables

from ch5_backend.figures import gauge_numbers, gauge_paper

TABLES = Tables(Path(os.environ.get("CH5_TABLES", ROOT / "out")).resolve() / "csv")
FOLDER = TABLES.folder.parent / "gauge"


class Examples(unittest.TestCase):
    def test_q_is_a_projection_into_the_gauge(self):
        H, U, free, V, Q, fixed = toy.two_numbers()
        zero = [[0], [0]]
        self.assertEqual(toy.product(H, U), zero)
        self.assertEqual(toy.product(Q, U), zero)
        self.assertEqual(toy.product(toy.transpose(V), Q), [[0, 0]])
        self.assertEqual(toy.product(Q, Q), Q)
        self.assertEqual(toy.product(toy.product(H, free), H), H)
        self.assertEqual(fixed, [[0, 0], [0, toy.SIGMA ** 2]])
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
        self.facts = deck4.facts(TABLES)

    def number(self, name):
        """A fact in TeX as a number."""
        text = self.facts[name].strip("$").replace(r"\times ", "*").replace("10^{", "1e").replace("}", "").rstrip("%")
        mantissa, _, power = text.partition("*")
        return float(mantissa) * float(power or 1)

    def test_the_deck_counts_as_the_report_does(self):
        found = gauge_numbers.numbers(FOLDER)
        sine, power = found["sweep"], lambda value: float(f"{value:.0e}")
        for name, value, digits in (
                ("zeros.imu", found["spectrum"]["camera and IMU", "zero eigenvalues"], 0),
                ("zeros.camera", found["spectrum"]["camera alone", "zero eigenvalues"], 0),
                ("sweep.peak", sine["sine planes", "iterations at the peak"], 1),
                ("sweep.peak_weight", sine["sine planes", "weight of the peak"], 0),
                ("sweep.zero", sine["sine planes", "iterations at 0"], 1),
                ("damping.identity", found["prior_choice"]["damping identity", "iterations at 10¹⁰"], 1),
                ("damping.radius", found["prior_choice"]["damping radius", "iterations at 10¹⁰"], 1),
                ("place.poses", found["prior_choice"]["poses 0 and 1, perturbed", "error / that without a prior at 10⁵"], 2),
                ("choice.low", found["prior_choice"]["any damping", "least right weight"], 0),
                ("choice.high", found["prior_choice"]["any damping", "greatest right weight"], 0),
                ("arrival.last", found["convergence"]["w = 100", "mean last iteration"], 1),
                ("sigma.fixed_last", 100 * found["deviations"]["fixed", "σ of the last position [m]"], 1)):
            self.assertAlmostEqual(self.number(name), value, delta=0.501 * 10 ** -digits, msg=name)
        for name, value in (
                ("methods.prior", found["methods"]["prior and fixation", "largest relative difference of an RMSE at convergence"]),
                ("methods.free", found["methods"]["free and fixation", "largest relative difference of an RMSE at convergence"]),
                ("cov.free_to_fixed", found["covariance"]["free to fixed", "largest relative Frobenius distance"])):
            self.assertEqual(power(self.number(name)), power(value), name)

    def test_accuracy_is_the_same_and_a_middling_prior_slow(self):
        for scene in gauge_paper.SCENES:
            self.assertLess(difference(TABLES, scene, "prior", "position_m"), 1e-5)
            self.assertLess(difference(TABLES, scene, "free", "position_m"), 1e-2)
            weights, found = plots.over_weight(TABLES, "sweep", "iterations", path=scene[0], points=scene[1])
            at = found.index(max(found))
            self.assertTrue(1 < weights[at] < 1e3, weights[at])
            self.assertGreater(found[at], 1.5 * max(found[0], found[-1]))

    def test_the_rising_curve_is_the_dampings_and_too_full_a_prior_costs_accuracy(self):
        self.assertGreater(self.number("damping.identity"), 1.5 * self.number("damping.diagonal"))
        self.assertGreater(self.number("place.poses"), self.number("place.pose"))
        self.assertGreater(self.number("place.pose"), 1.5)
        self.assertAlmostEqual(self.number("place.gauge"), 1, delta=0.01)

    def test_numbers_of_recordings_are_those_of_the_model_answer(self):
        answer = (ROOT / "solutions/gauge_freedom.md").read_text(encoding="utf-8")
        plain = re.sub(r"<!--.*?-->", "", answer)
        for name in ("real.fixation_position", "real.free_position", "real.fixation_iterations", "real.free_iterations"):
            self.assertIn(self.facts[name], plain)
