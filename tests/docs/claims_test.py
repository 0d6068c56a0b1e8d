"""What the lectures say in words holds: their examples are computed right, their kept measurements are whole and in the figures."""

import re
import unittest
from fractions import Fraction as F
from math import degrees, radians

import numpy as np

from tests.project import OUT, ROOT

from ch5_backend.course.experiments.bench import check_order
from ch5_backend.figures.numbers import peers
from ch5_backend.figures.tables import Tables
from slides import gauge_examples, marginalization_examples as toy
from slides.deck_fast_solver import FIGURES
from slides.deck_fast_solver_facts import PROBLEMS, ladder
from slides.deck_gauge import facts

MEASURED = Tables(ROOT / "slides/measured")


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


class Windows(unittest.TestCase):
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


class Gauge(unittest.TestCase):
    def test_q_is_a_projection_into_the_gauge(self):
        H, U, free, V, Q, fixed = gauge_examples.two_numbers()
        for zero in (H @ U, Q @ U, V.T @ Q, Q @ Q - Q, H @ free @ H - H, fixed - np.diag([0, gauge_examples.SIGMA ** 2])):
            self.assertFalse(zero.any())
        self.assertEqual(gauge_examples.difference_variance(free), gauge_examples.difference_variance(fixed))

    def test_a_tilted_book_turns_by_the_area_of_its_loop(self):
        self.assertAlmostEqual(abs(gauge_examples.tilted_yaw()), degrees(radians(gauge_examples.TILT) ** 2), delta=0.01)

    def test_a_weak_prior_creeps_and_all_end_in_the_valley(self):
        steps = {weight: len(gauge_examples.walk(weight)) for weight in (None, 0.0, gauge_examples.WEAK, 1e3)}
        self.assertGreater(steps[gauge_examples.WEAK], 1.5 * steps[0.0])
        self.assertLess(steps[1e3], steps[gauge_examples.WEAK])
        for weight in steps:
            a, b = gauge_examples.walk(weight)[-1]
            self.assertAlmostEqual(b - a, 1, delta=0.01)
        a, b = gauge_examples.walk(0.0)[-1]
        self.assertAlmostEqual(a, -b, delta=1e-9, msg="the shortest way")

    @unittest.skipUnless((OUT / "gauge/csv/methods.csv").exists(), f"{OUT}/gauge has no tables; ./course slides writes them")
    def test_numbers_of_recordings_are_those_of_the_model_answer(self):
        plain, found = re.sub(r"<!--.*?-->", "", (ROOT / "solutions/gauge_freedom.md").read_text(encoding="utf-8")), facts(Tables(OUT / "csv"))
        for name in ("real.fixation_position", "real.free_position", "real.fixation_iterations", "real.free_iterations"):
            self.assertIn(found[name], plain)


class Speed(unittest.TestCase):
    def test_both_sides_reach_the_same_cost(self):
        for row in peers.kept(MEASURED):
            if row["problem"].split(" ")[0] in PROBLEMS and row["setting"] == peers.BEST and row["problem"].endswith(" total"):
                self.assertLess(row["ours_cost"], 1.001 * row["peer_cost"], row["problem"])

    def test_every_row_of_the_peers_names_where_and_how_it_was_measured(self):
        for table, columns in (("speed_peers", ("processor", "date", "rounds", "load", "threads")),
                               ("speed_elsewhere", ("peer", "version", "processor", "threads", "commit", "problem", "question", "ratio", "how"))):
            for row in MEASURED(table).rows():
                self.assertTrue(all(str(row[column]) not in ("", "nan") for column in columns), (table, row))
        self.assertGreater(len({row["processor"] for table in ("speed_peers", "speed_elsewhere") for row in MEASURED(table).rows()}), 1,
                           "what another machine gave")

    def test_nobody_arrives_after_its_end(self):
        cases = {}
        for row in MEASURED("speed_peers").rows():
            cases.setdefault((row["processor"], row["problem"].split(" ")[0], row["setting"], row["threads"]), []).append(row)
        for (*_, setting, _), rows in cases.items():
            if setting in (peers.SAME, peers.BEST):
                check_order(rows)

    def test_every_bar_stands_on_its_page_with_its_number(self):
        drawn = FIGURES["rungs"](MEASURED, "en")
        for ms in (ms for problem in PROBLEMS for ms in ladder(MEASURED, problem).values()):
            self.assertIn(f">{ms:.3g}<" if ms < 100 else f">{ms:.0f}<", drawn)
