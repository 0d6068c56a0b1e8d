"""The examples of the third and the sixth lecture are computed right."""

import unittest
from fractions import Fraction as F

import numpy as np

from slides import marginalization_examples as toy


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
