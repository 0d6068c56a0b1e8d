"""What the third lecture says in words holds in its tables, and its examples are computed right."""

import os
import unittest
from fractions import Fraction as F
from pathlib import Path

from tests.docs.markdown import ROOT

from slides.deck3 import toy
from ch5_backend.figures.numbers.windows import CONSISTENCY, cuts, spectra
from ch5_backend.figures.tables import Tables

TABLES = Tables(Path(os.environ.get("CH5_TABLES", ROOT / "out")).resolve() / "csv")


class Examples(unittest.TestCase):
    def test_chain_moves_by_a_fifth_before_and_after(self):
        H, b, prior, b_prior = toy.chain()
        self.assertEqual((b[1], H[1][1] - H[0][0] - H[2][2]), (5, 25))
        self.assertEqual(toy.solve(H, b), [F(1, 5)] * 3)
        self.assertEqual(toy.solve(prior, b_prior), [F(1, 5)] * 2)
        self.assertEqual([round(float(value), 4) for value in b_prior], [3.6735, 0.4082])

    def test_without_the_hidden_prior_the_chain_is_singular(self):
        H = toy.chain()[0]
        H[1][1] -= 25
        self.assertEqual([sum(row) for row in H], [0, 0, 0])

    def test_prior_of_rank_one_gives_its_right_hand_side_back(self):
        u, H, b, e0 = toy.rank_one()
        self.assertEqual(toy.det(H), 0)
        self.assertEqual([-value * e0 for value in u], b)

    def test_two_tangents_cross_and_one_does_not(self):
        same, mixed = toy.two_tangents()
        self.assertEqual(toy.det(same), 0)
        (a, b), (c, d) = (toy.jacobian(point)[0] for point in toy.POINTS)
        self.assertEqual(toy.det(mixed), (a * d - b * c) ** 2)
        for x, y in toy.POINTS:
            self.assertEqual(x * y, toy.PRODUCT)

    def test_neighbors_of_what_leaves_are_the_poses_that_share_its_landmarks(self):
        self.assertEqual(toy.neighbors(), [("x", 1), ("x", 2), ("x", 3)])


class WindowClaims(unittest.TestCase):
    def setUp(self):
        if not (TABLES.folder / "slide_frames.csv").exists():
            self.skipTest(f"{TABLES.folder} has no slide_frames.csv; ./course slides writes it")

    def test_no_cut_finds_the_gauge_of_an_old_prior(self):
        plain, scaled = spectra(TABLES)
        for values, cut in zip((plain, scaled), cuts(scaled)):
            self.assertLess(sum(value <= cut for value in values), 3)
        self.assertLess(max(abs(value) for value in plain[:3]), 1e-12 * plain[-1])
        self.assertGreater(plain[3], 1e4 * abs(plain[2]), "yaw has leaked")

    def test_yaw_leaks_and_position_does_not(self):
        for policy in ("vins", "okvis"):
            last = {axis: TABLES("odometry_gauge", policy=policy, direction=axis).rows()[-1]["information"]
                    for axis in ("x", "y", "z", "yaw")}
            self.assertGreater(last["yaw"], 1e3 * max(abs(last[axis]) for axis in "xyz"))

    def test_frames_leave_at_once_with_vins_and_keyframes_stay_with_okvis(self):
        seen = {}
        for row in TABLES("slide_frames").rows():
            seen.setdefault((row["policy"], row["frame"]), []).append(row)
        last = max(TABLES("slide_frames")["image"].tolist())
        gone = {policy: [rows for (name, _), rows in seen.items() if name == policy and rows[-1]["image"] < last]
                for policy in ("vins", "okvis")}
        self.assertGreater(sum(len(rows) < 3 for rows in gone["vins"]), 3)
        self.assertGreater(sum(not rows[-1]["speed"] for rows in gone["okvis"]), 2)
        self.assertTrue(all(row["speed"] for rows in gone["vins"] for row in rows))

    def test_used_twice_is_overconfident_and_a_clean_prior_alone_worse_than_none(self):
        mean = lambda policy, mode, column: TABLES(CONSISTENCY, policy=policy, mode=mode)[column].sum()  # noqa: E731
        self.assertGreater(mean("vins twice", "none", "nees_pose"), 3 * mean("vins", "none", "nees_pose"))
        most = {mode: TABLES(CONSISTENCY, policy="vins", mode=mode)["yaw_information"].max()
                for mode in ("none", "prior_only", "full")}
        self.assertLess(most["full"], most["none"])
        self.assertGreater(most["prior_only"], 1.5 * most["none"])
