"""What the second lecture says in words holds in the tables that it shows."""

import unittest

from tests.project import OUT

from ch5_backend.figures.tables import Tables

TABLES = Tables(OUT / "csv")


class SolverClaims(unittest.TestCase):
    def setUp(self):
        if not (TABLES.folder / "solver_pcg.csv").exists():
            self.skipTest(f"{TABLES.folder} has no solver_pcg.csv; ch5_solvers writes it")

    def last(self, table, column, **where):
        return TABLES(table, **where)[column].tolist()[-1]

    def test_blocks_gather_all_but_a_handful_of_eigenvalues_at_one(self):
        values = TABLES("solver_spectrum", preconditioner="blocks")["eigenvalue"].tolist()
        self.assertLess(sum(not 0.5 < value < 2.1 for value in values), 0.15 * len(values))
        for better, worse in (("blocks", "diagonal"), ("diagonal", "none")):
            condition = [max(v) / min(v) for v in (TABLES("solver_spectrum", preconditioner=name)["eigenvalue"].tolist()
                                                   for name in (better, worse))]
            self.assertLess(condition[0], condition[1])

    def test_without_the_first_step_the_residual_stays_where_it_began(self):
        for name in ("none", "diagonal", "blocks"):
            rows = TABLES("solver_pcg", preconditioner=name).rows()
            self.assertGreater(min(row["without_first_step"] for row in rows), 0.3)
        self.assertLess(rows[-1]["relative_residual"], 1e-10)
        self.assertGreater(rows[-1]["without_first_step"], 1.0)

    def test_the_landmarks_step_does_not_shrink_when_the_poses_alone_are_damped(self):
        rows = TABLES("solver_half_damped").rows()
        self.assertGreater(rows[-1]["half_damped_step"], 0.9 * rows[0]["half_damped_step"])
        self.assertLess(rows[-1]["step"], 0.01 * rows[0]["step"])
        self.assertLess(rows[-1]["half_damped_gain_ratio"], 0.01)
        self.assertGreater(min(row["gain_ratio"] for row in rows), 0.9)
        self.assertLess(rows[0]["relative_difference"], 1e-3)  # for small λ both are Gauss-Newton

    def test_every_rule_finds_the_same_minimum_and_none_is_best_everywhere(self):
        best = set()
        for problem in ("curve", "valley", "bundle"):
            trials = {rule: self.last("solver_rules", "trial", problem=problem, rule=rule)
                      for rule in ("nielsen", "ceres", "tenfold")}
            costs = [self.last("solver_rules", "cost", problem=problem, rule=rule) for rule in trials]
            self.assertLess(max(costs) - min(costs), 1e-9 * (1 + min(costs)))
            best.add(min(trials, key=trials.get))
        self.assertGreater(len(best), 1)

    def test_only_gauss_newton_climbs(self):
        for name, climbs in (("gauss-newton", True), ("levenberg-marquardt", False), ("dogleg", False)):
            costs = TABLES("solver_paths", algorithm=name)["cost"].tolist()
            self.assertEqual(any(b > a for a, b in zip(costs, costs[1:])), climbs, name)
            self.assertLess(costs[-1], 1e-15)

    def test_dogleg_ends_with_gauss_newton_from_every_first_radius(self):
        radii = sorted({row["first_radius"] for row in TABLES("solver_dogleg").rows()})
        self.assertGreaterEqual(radii[-1] / radii[0], 1e6)
        for radius in radii:
            self.assertEqual(self.last("solver_dogleg", "step", first_radius=radius), "Gauss-Newton")
        self.assertEqual(TABLES("solver_dogleg", first_radius=radii[0]).rows()[1]["step"], "steepest descent")

    def test_each_of_the_last_steps_is_shorter_by_a_greater_factor(self):
        for scene in ("course", "large"):
            steps = [row["step_norm"] for row in TABLES("mono_ba_trace", scene=scene).rows()][-4:]
            factors = [before / after for before, after in zip(steps, steps[1:])]
            self.assertEqual(factors, sorted(factors), scene)

    def test_cauchy_holds_huber_breaks_last_of_the_others_and_tukey_fails_without_outliers(self):
        error = {(row["loss"], row["fraction"]): row["rmse_position_m"] for row in TABLES("solver_outliers").rows()}
        self.assertLess(error["cauchy", 0.4], 0.01)
        self.assertLess(error["huber", 0.3], 0.03)
        self.assertGreater(error["huber", 0.4], 0.1)
        self.assertGreater(error["none", 0.02], 0.1)
        self.assertGreater(error["tukey", 0.0], 10 * error["none", 0.0])

    def test_both_corrections_find_the_same_minimum(self):
        costs = TABLES("solver_corrections", loss="cauchy")["final_cost"].tolist()
        self.assertAlmostEqual(costs[0], costs[1], delta=1e-5 * costs[0])
