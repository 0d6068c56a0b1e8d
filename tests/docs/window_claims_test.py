"""What the third lecture says in words holds in its tables, and its examples are computed right."""

import os
import unittest
from fractions import Fraction as F
from pathlib import Path

from tests.docs.markdown import ROOT

from slides import marginalization_examples as toy
from ch5_backend.figures.numbers.windows import KEPT, consistency, cuts, spectra
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


class Certainty(unittest.TestCase):
    """Of the kept tables, which ch5_nees wrote."""

    def nees(self, policy="vins", mode="none", **case):
        return consistency(KEPT, policy, mode, "consistency_summary", **case).rows()[0]

    def test_an_exact_host_is_the_larger_mistake_and_the_second_use_the_smaller(self):
        right = self.nees()
        self.assertLess(abs(right["nees_pose"] - 6), 1.5)
        host, twice = self.nees(hosts="exact"), self.nees(observations="twice")
        for wrong in (host, twice):
            self.assertGreater(wrong["nees_pose"] - right["nees_pose"], 4 * wrong["nees_pose_error"])
        self.assertGreater(host["nees_pose"], 3 * twice["nees_pose"])

    def test_with_exact_hosts_full_constraints_help_vins_and_nothing_is_consistent(self):
        self.assertLess(self.nees(mode="full", hosts="exact")["nees_pose"], 0.5 * self.nees(hosts="exact")["nees_pose"])
        for policy in ("vins", "okvis"):
            for mode in ("none", "prior_only", "full"):
                self.assertEqual(self.nees(policy, mode, hosts="exact")["pose_inside"] < 0.2, True, (policy, mode))

    def test_full_constraints_are_consistent_and_change_little_for_okvis(self):
        for policy in ("vins", "okvis"):
            full = self.nees(policy, "full")
            self.assertLess(abs(full["nees_pose"] - 6), 3 * full["nees_pose_error"] + 0.3, policy)
        self.assertLess(abs(self.nees("okvis", "full")["nees_pose"] - self.nees("okvis")["nees_pose"]), 0.5)

    def test_a_clean_prior_alone_claims_more_yaw_than_none(self):
        most = {mode: self.nees(mode=mode)["yaw_information_gain"] for mode in ("none", "prior_only", "full")}
        self.assertLess(most["full"], most["none"])
        self.assertGreater(most["prior_only"], 1.5 * most["none"])

    def test_on_recordings_noisy_hosts_are_no_better_than_the_loss(self):
        ate = lambda recording, policy, hosts: KEPT("host_noise", recording=recording, policy=policy, hosts=hosts)["ate_m"][0]  # noqa: E731
        for recording in ("euroc_v1_01_easy", "tango_walk"):
            for policy in ("vins", "okvis"):
                self.assertLess(ate(recording, policy, "exact with loss"), 1.05 * ate(recording, policy, "noisy"))
        self.assertLess(ate("tango_walk", "vins", "noisy"), ate("tango_walk", "vins", "exact"))
        self.assertGreater(ate("tango_walk", "okvis", "noisy"), ate("tango_walk", "okvis", "exact"))

    def test_kept_tables_have_the_cases_and_columns_that_the_program_writes(self):
        if not (TABLES.folder.parent / "nees").exists():
            self.skipTest("no tables of ch5_nees")
        for name in ("consistency", "consistency_summary"):
            fresh, kept = Tables(TABLES.folder.parent / "nees" / "csv")(name), KEPT(name)
            self.assertEqual(list(fresh.columns), list(kept.columns))
            cases = lambda table: {tuple(row[key] for key in ("policy", "observations", "hosts", "mode"))  # noqa: E731
                                   for row in table.rows()}
            self.assertEqual(cases(fresh), cases(kept))
