"""The measurements that the fifth lecture keeps are whole, and in its figures."""

import unittest

from tests.project import ROOT

from slides.deck_fast_solver import FIGURES
from slides.deck_fast_solver_facts import PROBLEMS, ladder
from ch5_backend.course.experiments.bench import check_order
from ch5_backend.figures.numbers import peers
from ch5_backend.figures.tables import Tables

TABLES = Tables(ROOT / "slides/measured")


class SpeedClaims(unittest.TestCase):
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

    def test_every_bar_stands_on_its_page_with_its_number(self):
        drawn = FIGURES["rungs"](TABLES, "en")
        for ms in (ms for problem in PROBLEMS for ms in ladder(TABLES, problem).values()):
            self.assertIn(f">{ms:.3g}<" if ms < 100 else f">{ms:.0f}<", drawn)
