"""What ./course bench makes of its runs: numbers worked by hand."""

import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "ch5_backend" / "apps"))
from course import bench
from course.errors import CourseError


def run(trace, steps=4, peak=10.0):
    return {"initial_cost": trace[0][1], "final_cost": trace[-1][1], "seconds": trace[-1][0], "steps": steps,
            "peak_mb": peak, "trace": trace}


FAST = run([[0.0, 500.0], [0.1, 101.0], [0.2, 100.05], [0.4, 100.0]])
SLOW = run([[0.0, 500.0], [1.0, 102.0], [2.0, 100.5], [3.0, 100.2]], steps=3, peak=30.0)


class Rows(unittest.TestCase):
    def rows(self, ours, theirs, peer="Ceres"):
        return {row["problem"]: row for row in bench.rows_of("case", 1, ours, peer, theirs)}

    def test_each_question_is_a_row(self):
        rows = self.rows([[FAST]], [[SLOW]])
        self.assertEqual(set(rows), {"case iteration", "case total", "case to 1 %", "case to 0.1 %",
                                     "case to the peer's cost"})
        for row in rows.values():
            self.assertEqual(tuple(row), bench.FIELDS)
            self.assertEqual((row["ours_cost"], row["peer_cost"]), (100.0, 100.2))
            self.assertEqual((row["ours_peak_mb"], row["peer_peak_mb"]), (10.0, 30.0))

    def test_times_and_ratio(self):
        rows = self.rows([[FAST]], [[SLOW]])
        self.assertAlmostEqual(rows["case iteration"]["ours_ms"], 100.0)
        self.assertAlmostEqual(rows["case iteration"]["peer_ms"], 1000.0)
        self.assertAlmostEqual(rows["case iteration"]["ratio"], 10.0)
        self.assertAlmostEqual(rows["case to 1 %"]["ours_ms"], 100.0)
        self.assertAlmostEqual(rows["case to 1 %"]["peer_ms"], 2000.0)
        self.assertAlmostEqual(rows["case to the peer's cost"]["ours_ms"], 200.0)

    def test_a_side_that_does_not_get_there_has_no_time(self):
        row = self.rows([[FAST]], [[SLOW]])["case to 0.1 %"]
        self.assertAlmostEqual(row["ours_ms"], 200.0)
        self.assertIsNone(row["peer_ms"])
        self.assertIsNone(row["ratio"])

    def test_without_a_peer_ours_stand_alone(self):
        rows = self.rows([[FAST]], [], None)
        self.assertNotIn("case to the peer's cost", rows)
        row = rows["case total"]
        self.assertEqual([row[key] for key in ("peer", "peer_ms", "ratio", "peer_cost", "peer_peak_mb")], [None] * 5)
        self.assertAlmostEqual(row["ours_ms"], 400.0)
        self.assertIn("–", bench.table(list(rows.values())))

    def test_medians_of_turns(self):
        def lasting(seconds):
            return run([[0.0, 2.0], [seconds, 1.0]], steps=1)
        turns = [[lasting(1.0), lasting(1.2), lasting(9.0)], [lasting(5.0)], [lasting(1.4)]]
        self.assertAlmostEqual(self.rows(turns, [])["case total"]["ours_ms"], 1400.0)

    def test_problems_are_chosen_by_part_of_their_name(self):
        self.assertEqual(bench.chosen(["vio_M"]), ["window/vio_M", "window/vio_Md"])
        self.assertEqual(bench.chosen([]), list(bench.PROBLEMS))
        with self.assertRaisesRegex(CourseError, "no problem is called 'nothing'"):
            bench.chosen(["vio_M", "nothing"])


if __name__ == "__main__":
    unittest.main()
