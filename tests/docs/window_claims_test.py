"""What the third and the sixth lecture say in words holds in their tables, and their examples are computed right."""

import unittest
from fractions import Fraction as F

import numpy as np

from tests.project import OUT, ROOT

from slides import marginalization_examples as toy
from slides.deck_consistency_facts import REMEDIES
from ch5_backend.figures.numbers import systems as numbers
from ch5_backend.figures.numbers.windows import FLIGHTS, KEPT, cuts, kept_summary, paired, spectra
from ch5_backend.figures.tables import Tables

TABLES = Tables(OUT / "csv")


def nees_of_a_place(slopes, share):
    """Mean NEES per coordinate of a place in the plane, seen 100 times with σ = 1, of which a share is anywhere. The claim
    is W_ρ's (graph/loss.h)."""
    random, nees = np.random.default_rng(7), []
    for _ in range(400):
        seen = random.normal(size=(100, 2))
        wrong = random.random(100) < share
        seen[wrong] = random.uniform(-50, 50, (wrong.sum(), 2))
        place = np.median(seen, axis=0)
        for _ in range(40):
            weight = slopes(np.sum((seen - place) ** 2, axis=1))[0]
            place = weight @ seen / weight.sum()
        r = seen - place
        s = np.sum(r ** 2, axis=1)
        first, second = slopes(s)
        rank_one = np.where(first + 2 * second * s > 1e-12, 2 * second, 0)
        nees.append(place @ (first.sum() * np.eye(2) + (rank_one[:, None] * r).T @ r) @ place / 2)
    return np.mean(nees)


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
        self.assertEqual([-value * e0 for value in u], list(b))

    def test_two_tangents_cross_and_one_does_not(self):
        same, mixed = toy.two_tangents()
        self.assertEqual(toy.det(same), 0)
        (a, b), (c, d) = (toy.jacobian(point)[0] for point in toy.POINTS)
        self.assertEqual(toy.det(mixed), (a * d - b * c) ** 2)
        for x, y in toy.POINTS:
            self.assertEqual(x * y, toy.PRODUCT)

    def test_okvis_inverse_is_another_one_than_moore_penrose_and_gives_the_same_e0(self):
        J, P, b0 = np.array([[2.0, 1.0]]), np.diag([2.0, 1.0]), np.array([6.0, 3.0])
        okvis = np.array([[0.5, 0.5]]) @ np.linalg.inv(P)  # S^-½ Uᵀ P⁻¹, as in stage 5
        self.assertGreater(np.abs(okvis - np.linalg.pinv(J.T)).max(), 0.1)
        for inverse in (okvis, np.linalg.pinv(J.T)):
            np.testing.assert_allclose(inverse @ b0, [3])

    def test_small_entries_set_to_zero_make_most_of_badly_scaled_singular_matrices_indefinite(self):
        for decades, least, most in ((8, 0.8, 1.0), (4, 0.0, 0.01)):
            random, wrong = np.random.default_rng(1), 0
            for _ in range(200):
                J = random.normal(size=(8, 12)) * 10 ** random.uniform(-0.75 * decades, 0.25 * decades, 12)
                H = J.T @ J
                p = np.sqrt(np.diag(H))
                wrong += np.linalg.eigvalsh(np.where(np.abs(H) < 1e-9, 0, H) / np.outer(p, p))[0] < -1e-9
            self.assertTrue(least <= wrong / 200 <= most, (decades, wrong))

    def test_cauchys_claim_is_too_modest_and_hubers_too_certain_among_outliers(self):
        cauchy = lambda s: (1 / (1 + s), -1 / (1 + s) ** 2)  # noqa: E731
        huber = lambda s: (np.minimum(1, 1.345 / np.sqrt(s)), np.where(s > 1.345 ** 2, -0.6725 / s ** 1.5, 0))  # noqa: E731
        for share in (0, 0.2):
            self.assertLess(nees_of_a_place(cauchy, share), 0.7)
        self.assertLess(nees_of_a_place(huber, 0), 1.05)
        self.assertGreater(nees_of_a_place(huber, 0.2), 1.1)

    def test_neighbors_of_what_leaves_are_the_poses_that_share_its_landmarks(self):
        self.assertEqual(toy.neighbors(), [("x", 1), ("x", 2), ("x", 3)])


class WindowClaims(unittest.TestCase):
    def setUp(self):
        if not (TABLES.folder / "slide_frames.csv").exists():
            self.skipTest(f"{TABLES.folder} has no slide_frames.csv; ./course slides writes it")

    def test_a_cut_finds_the_shifts_and_not_the_yaw_that_has_leaked(self):
        plain, scaled = spectra(TABLES)
        for values, cut in zip((plain, scaled), cuts(scaled)):
            self.assertEqual(sum(value <= cut for value in values), 3)
        self.assertLess(max(abs(value) for value in plain[:3]), 1e-11 * plain[-1])
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

    def test_an_exact_host_is_the_larger_mistake_and_the_second_use_the_smaller(self):
        right = kept_summary("vins")
        self.assertLess(abs(right["nees_pose"] - 6), 1.5)
        host, twice = kept_summary("vins", hosts="exact"), kept_summary("vins", observations="twice")
        for wrong in (host, twice):
            self.assertGreater(wrong["nees_pose"] - right["nees_pose"], 4 * wrong["nees_pose_error"])
        self.assertGreater(host["nees_pose"], 3 * twice["nees_pose"])

    def test_with_exact_hosts_full_constraints_help_vins_and_nothing_is_consistent(self):
        self.assertLess(kept_summary("vins", "full", hosts="exact")["nees_pose"], 0.5 * kept_summary("vins", hosts="exact")["nees_pose"])
        for policy in ("vins", "okvis"):
            for mode in ("none", "prior_only", "full"):
                self.assertLess(kept_summary(policy, mode, hosts="exact")["pose_inside"], 0.2, (policy, mode))

    def test_full_constraints_are_consistent_and_change_little_for_okvis(self):
        for policy in ("vins", "okvis"):
            full = kept_summary(policy, "full")
            self.assertLess(abs(full["nees_pose"] - 6), 3 * full["nees_pose_error"] + 0.3, policy)
        self.assertLess(abs(kept_summary("okvis", "full")["nees_pose"] - kept_summary("okvis")["nees_pose"]), 0.5)

    def test_a_clean_prior_alone_claims_more_yaw_than_none(self):
        most = {mode: kept_summary("vins", mode)["yaw_information_gain"] for mode in ("none", "prior_only", "full")}
        for policy in ("vins", "okvis"):
            self.assertGreater(kept_summary(policy, "prior_only")["nees_pose"], kept_summary(policy)["nees_pose"] + 1)
        self.assertLess(most["full"], most["none"])
        self.assertGreater(most["prior_only"], 1.5 * most["none"])

    def test_on_recordings_noisy_hosts_are_no_better_than_the_loss(self):
        ate = lambda recording, policy, hosts: KEPT("host_noise", recording=recording, policy=policy, hosts=hosts)["ate_m"][0]  # noqa: E731
        for recording in ("euroc_v1_01_easy", "tango_walk"):
            for policy in ("vins", "okvis"):
                rows = KEPT("host_noise", recording=recording, policy=policy).rows()
                whole = [row for row in rows if row["images"] == max(row["images"] for row in rows)]
                self.assertEqual(min(whole, key=lambda row: row["ate_m"])["hosts"], "exact with loss")
        self.assertLess(ate("tango_walk", "vins", "noisy"), ate("tango_walk", "vins", "exact"))
        self.assertGreater(ate("tango_walk", "okvis", "noisy"), ate("tango_walk", "okvis", "exact"))


class Systems(unittest.TestCase):
    """Of the kept tables, which ch5_systems wrote."""

    def test_what_is_fixed_or_dropped_is_lost_or_far_too_certain(self):
        for policy in ("vins", "okvis"):
            of = {way: KEPT("ablation", policy=policy, way=way) for way in numbers.WAYS}
            self.assertTrue((of["dropped"]["restarts"] > 0).all())
            for way in ("fixed", "poses fixed"):
                self.assertGreater(np.median(of[way]["ate_m"]), 5 * np.median(of["marginalized"]["ate_m"]), (policy, way))
                self.assertGreater(np.median(of[way]["nees_motion"]), 1e3, (policy, way))
            for way in ("marginalized", "first estimates"):
                self.assertEqual(of[way]["restarts"].max(), 0)
                self.assertTrue(5 < np.median(of[way]["nees_motion"]) < 7.5, (policy, way))

    def test_on_a_recording_first_estimates_are_no_better_and_nothing_is_consistent(self):
        for policy in ("vins", "okvis"):
            usual, first = (KEPT("ablation_recording", policy=policy, way=way).rows()[0]
                            for way in ("marginalized", "first estimates"))
            self.assertGreater(first["ate_m"], 0.99 * usual["ate_m"])
            self.assertGreater(min(usual["nees_motion"], first["nees_motion"]), 60)

    def test_a_walks_scale_is_that_of_its_readings(self):
        def scale(*measured):
            columns = dict(zip(("observations", "gyroscope", "accelerometer"), measured))
            return 100 * np.mean(KEPT("walk_scale", **columns)["scale_error"])
        truth, recorded = "by the truth", "recorded"
        self.assertLess(abs(scale(truth, truth, truth)), 0.5)
        self.assertGreater(scale(truth, recorded, recorded), 2.5)
        self.assertGreater(scale(recorded, recorded, recorded) - scale(recorded, truth, truth), 2.5)

    def test_on_a_recording_noise_five_times_as_large_or_a_truth_that_errs_explain_most(self):
        for policy in ("vins", "okvis"):
            of = {row["setting"]: row for row in KEPT("consistency_recording", recording="euroc_v1_01_easy", policy=policy).rows()}
            self.assertLess(of["both x 5"]["nees_motion"], 10)
            self.assertLess(of["both x 5"]["ate_m"], 1.2 * of["none"]["ate_m"])
            self.assertLess(of["truth errs too"]["nees_motion"], 0.3 * of["none"]["nees_motion"])
            for remedy in REMEDIES:
                self.assertGreater(of[remedy]["nees_motion"], 60)
                self.assertGreater(of[remedy]["ate_m"], of["none"]["ate_m"])

    def test_the_table_of_first_estimates_is_that_of_the_runs(self):
        def cell(setting, recording):
            rows = [KEPT("consistency_recording", recording=recording, policy=policy, setting=setting) for policy in ("vins", "okvis")]
            digits = 2 if recording == "tango_walk" else 3
            return "; ".join(f"{np.mean(of['ate_m']):.{digits}f}, {np.mean(of['nees_motion']):.0f}" for of in rows)
        for page in ("README.md", "README.zh.md"):
            text = (ROOT / "ch5_backend/experiments" / page).read_text(encoding="utf-8")
            for setting in ("none", "prior", "full"):
                row = [cell(setting, recording) for recording in ("euroc_v1_01_easy", "simulated", "tango_walk")]
                self.assertIn(f"| {setting} | {' | '.join(row)} |", text)
            for kind in FLIGHTS:
                self.assertIn(f"| {paired(kind, 'vins', 'full')} | {paired(kind, 'okvis', 'full')} |", text)

    def test_schur_loses_a_weak_prior_whatever_root_follows_and_qr_keeps_it(self):
        of = {name: KEPT("back_ends", window="simulated", back_end=name) for name in numbers.BACK_ENDS}
        weak = of["qr"]["weakness"] <= 1e-5
        for name in numbers.SCHUR_ROOTS:
            self.assertTrue((of[name]["worst_error"][weak] >= 1 - 1e-9).all(), name)
            self.assertLess(of[name]["worst_error"][0], 1e-8)
        self.assertLess(of["qr"]["worst_error"].max(), 1e-5)
        self.assertTrue((of["qr float"]["worst_error"] > of["eigen vins"]["worst_error"]).all())

    def test_calibration_comes_down_to_what_the_tests_ask(self):
        for policy in ("vins", "okvis"):
            for quantity, goal in numbers.CALIBRATION_GOALS.items():
                _, medians = numbers.median_over_flights(KEPT("calibration", policy=policy, quantity=quantity))
                self.assertLess(medians[-1], goal, (policy, quantity))
                self.assertGreater(medians[0], 5 * goal, (policy, quantity))

    def test_densities_are_true_and_a_samples_sigma_is_not(self):
        rows = KEPT("preintegration")
        self.assertLess(np.abs(rows["claimed"] / rows["measured"] - 1).max(), 0.08)
        share = numbers.rotation_by_sample(KEPT)
        self.assertAlmostEqual(share[200], 0.5**0.5, delta=0.03)
        self.assertAlmostEqual(share[1600], 0.25, delta=0.02)

    def test_no_policy_is_better_everywhere_and_three_keyframes_suffice(self):
        half = {(one["recording"], one["policy"]): one["q50"] for one in KEPT("distance", share=0.2).rows()}
        self.assertLess(half["euroc_v1_01_easy", "vins"], half["euroc_v1_01_easy", "okvis"])
        self.assertGreater(half["tango_walk", "vins"], half["tango_walk", "okvis"])
        for temporal in numbers.TEMPORAL:
            keyframes, ate = numbers.over_keyframes(KEPT, "euroc_v1_01_easy", temporal, "ate_m")
            of = dict(zip(keyframes, ate))
            self.assertGreater(of[1], 1.5 * of[3])
            self.assertGreater(of[12], 0.95 * of[3])

    def test_algorithms_agree_but_for_the_bad_start(self):
        for data_set in numbers.DATA_SETS:
            ends = {}
            for row in KEPT("pose_graphs", data_set=data_set, solver="sparse").rows():
                ends[row["algorithm"]] = row["cost"]
            if data_set == "MIT":
                self.assertEqual(min(ends, key=ends.get), "Dogleg")
                self.assertGreater(ends["Dogleg"], 5 * numbers.least_cost(KEPT, data_set), "a wrong valley too")
            else:
                self.assertLess(max(ends.values()), (1 + 1e-6) * min(ends.values()), data_set)

    def test_chordal_relaxation_costs_least_and_ends_lowest(self):
        every = KEPT("pose_graph_starts")
        for data_set in set(every["data_set"]):
            rows = every.where(data_set=data_set)
            least = {row["start"]: row["first_cost"] for row in rows.rows()}
            if data_set == "simulated sphere":
                least.pop("file")  # the truth
            self.assertEqual(min(least, key=least.get), "chordal", data_set)
            self.assertLess(rows.row(start="chordal")["cost"], (1 + 1e-9) * rows["cost"].min(), data_set)
            self.assertNotIn("maximum of iterations", rows["termination"])
