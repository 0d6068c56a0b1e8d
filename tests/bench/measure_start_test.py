"""What measure_start.py makes of its runs: numbers worked by hand."""

import unittest

from ch5_backend.course.documents import measure_start
from ch5_backend.figures.numbers.peers import pairs_of


def run(trace, trials=3):
    return {"final_cost": trace[-1][1], "seconds": trace[-1][0], "trials": trials, "trace": trace}


class Start(unittest.TestCase):
    def test_a_pair_is_judged_by_its_time_to_a_thousandth_of_the_least_cost_of_all_pairs(self):
        soon, late, never = (run([[0.1, 9.0], [t, cost]]) for t, cost in ((1.0, 5.0), (2.0, 5.001), (1.5, 6.0)))
        rows = measure_start.rows_of({"a": {"": [soon] * 3, "late": [late], "never": [never]}})
        self.assertEqual([(row["pair"], row["ms"], row["arrives"]) for row in rows],
                         [("unasked", 1000.0, 1), ("late", 2000.0, 1), ("never", 3000.0, 0)], "what does not arrive counts twice")

    def test_the_summary_is_relative_to_each_problem_s_best_pair(self):
        rows = [{"problem": problem, "pair": pair, "ms": ms, "arrives": arrives}
                for problem, pair, ms, arrives in (("a", "x", 10.0, 1), ("a", "y", 40.0, 1), ("b", "x", 9.0, 0), ("b", "y", 1.0, 1))]
        found = pairs_of(rows)
        self.assertEqual([(pair, round(mean, 9), *rest) for pair, mean, *rest in found], [("y", 2.0, 1.0, 4.0, 2), ("x", 3.0, 1.0, 9.0, 1)])

    def test_the_choice_has_not_seen_what_it_is_checked_on(self):
        self.assertGreaterEqual(len(measure_start.SEEN), 8)
        self.assertGreaterEqual(len(measure_start.UNSEEN), 2)
        self.assertFalse(set(measure_start.SEEN) & set(measure_start.UNSEEN))
