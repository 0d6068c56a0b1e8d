"""What the fifth lecture says in words holds in the measurements that it keeps; measure them anew, and this says what to
rewrite."""

import unittest

from tests.project import ROOT

from slides.deck_fast_solver import FIGURES
from slides.deck_fast_solver_facts import BEST, PROBLEMS, facts, iteration, ladder, time_of
from ch5_backend.course.experiments.bench import check_order
from ch5_backend.figures.numbers import peers
from ch5_backend.figures.tables import Tables

TABLES = Tables(ROOT / "slides/measured")


class SpeedClaims(unittest.TestCase):
    def share(self, problem, *steps):
        return sum(time_of(TABLES, problem, step, *BEST) for step in steps) / iteration(TABLES, problem, *BEST)

    def test_linearizing_and_forming_s_take_most_of_an_iteration(self):
        for problem in PROBLEMS:
            self.assertGreater(self.share(problem, "linearize", "schur"), 0.5, problem)
            self.assertLess(self.share(problem, "poses"), 0.3, problem)

    def test_blocks_alone_are_slower_than_dense_in_the_scene_and_fixed_sizes_faster_than_both(self):
        times = ladder(TABLES, "scene/30x1000")
        self.assertGreater(times["plain"], 1.5 * times["dense"])
        for problem in PROBLEMS:
            times = ladder(TABLES, problem)
            self.assertGreater(times["plain"], 2.0 * times["fixed"], problem)
            self.assertGreater(times["fixed"], 1.5 * times["avx2"], problem)

    def test_forming_s_is_limited_by_operations_and_back_substitution_by_memory(self):
        row = {step: TABLES("speed_steps").row(problem="bal/16-22106", step=step, solver="sparse", simd="avx2")
               for step in ("schur", "back", "linearize")}
        peak = TABLES("speed_machine").row(simd="avx2", limit="peak")["value"]
        memory = max(TABLES("speed_machine", simd="avx2", limit="read").rows(), key=lambda r: r["megabytes"])["value"]
        ridge = peak / memory
        self.assertGreater(row["schur"]["flop"] / row["schur"]["bytes"], ridge)
        self.assertLess(row["back"]["flop"] / row["back"]["bytes"], ridge)
        self.assertGreater(1e-6 * row["back"]["bytes"] / row["back"]["milliseconds"], 0.4 * memory)
        self.assertGreater(row["schur"]["flop"] / row["schur"]["milliseconds"],
                           3.0 * row["linearize"]["flop"] / row["linearize"]["milliseconds"])

    def test_both_sides_reach_the_same_cost(self):
        for row in peers.kept(TABLES):
            if row["problem"].split(" ")[0] in PROBLEMS and row["setting"] == peers.BEST and row["problem"].endswith(" total"):
                self.assertLess(row["ours_cost"], 1.001 * row["peer_cost"], row["problem"])

    def test_every_row_of_the_peers_names_where_and_how_it_was_measured(self):
        for table, columns in (("speed_peers", ("processor", "date", "rounds", "load", "threads")),
                               ("speed_elsewhere", ("peer", "version", "processor", "threads", "commit", "problem", "question", "ratio", "how"))):
            for row in TABLES(table).rows():
                self.assertTrue(all(str(row[column]) not in ("", "nan") for column in columns), (table, row))
        self.assertGreater(len({row["processor"] for table in ("speed_peers", "speed_elsewhere") for row in TABLES(table).rows()}), 1,
                           "what another machine gave")

    def test_nobody_arrives_after_its_end(self):
        cases = {}
        for row in TABLES("speed_peers").rows():
            cases.setdefault((row["processor"], row["problem"].split(" ")[0], row["setting"], row["threads"]), []).append(row)
        for (*_, setting, _), rows in cases.items():
            if setting in (peers.SAME, peers.BEST):
                check_order(rows)

    def test_points_that_move_along_their_rays_take_fewer_iterations(self):
        found = facts(TABLES)
        for within in ("percent", "thousandth", "myriad"):
            self.assertLess(float(found[f"rays.ray.{within}"]), 0.7 * float(found[f"rays.xyz.{within}"]), within)

    def test_implicit_solvers_are_first_for_hundreds_of_cameras(self):
        found = facts(TABLES)
        for name in ("pcg", "series"):
            self.assertLess(2.0 * float(found[f"reduced.{name}"]), float(found["reduced.sparse"]))
            self.assertGreater(float(found[f"reduced.{name}.end"]), 0.3)
        self.assertEqual(float(found["reduced.sparse.end"]), 0)

    def test_wider_registers_gain_most_where_most_of_the_time_goes(self):
        gain = {step: time_of(TABLES, "bal/16-22106", step, "sparse", "portable") / time_of(TABLES, "bal/16-22106", step, *BEST)
                for step in ("linearize", "schur", "poses", "back", "invert", "cost")}
        self.assertGreater(min(gain["linearize"], gain["schur"]), 1.5 * max(gain["poses"], gain["back"]))
        self.assertLess(max(gain["invert"], gain["cost"]), 1.3)

    def test_every_bar_stands_on_its_page_with_its_number(self):
        drawn = FIGURES["rungs"](TABLES, "en")
        for ms in (ms for problem in PROBLEMS for ms in ladder(TABLES, problem).values()):
            self.assertIn(f">{ms:.3g}<" if ms < 100 else f">{ms:.0f}<", drawn)
