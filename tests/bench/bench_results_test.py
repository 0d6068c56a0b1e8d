"""What ./course bench makes of its runs: numbers worked by hand."""

import contextlib
import io
import subprocess
import unittest
from pathlib import Path
from unittest import mock

from ch5_backend.course.experiments import bench
from ch5_backend.course.base.errors import CourseError


def run(trace, steps=4, peak=10.0):
    return {"initial_cost": trace[0][1], "final_cost": trace[-1][1], "seconds": trace[-1][0], "steps": steps,
            "peak_mb": peak, "trace": trace}


FAST = run([[0.0, 500.0], [0.1, 101.0], [0.2, 100.05], [0.4, 100.0]])
SLOW = run([[0.0, 500.0], [1.0, 102.0], [2.0, 100.5], [3.0, 100.2]], steps=3, peak=30.0)


class Rows(unittest.TestCase):
    def rows(self, ours, theirs, peer="Ceres"):
        return {row["problem"]: row for row in bench.rows_of("case", 1, ours, peer, theirs)}

    def test_an_estimator_is_measured_against_its_recording(self):
        images = [{"seconds": 0.001 * k, "steps": 3, "final_cost": 5.0} for k in range(1, 101)]
        rows = {row["problem"]: row for row in bench.rows_of("odometry/vins", 1, [images], "Ceres", [])}
        self.assertEqual(set(rows), {f"odometry/vins {what}" for what in ("mean", "median", "99th percentile")})
        self.assertAlmostEqual(rows["odometry/vins mean"]["ours_ms"], 50.5)
        self.assertAlmostEqual(rows["odometry/vins mean"]["ratio"], 50.0 / 50.5, msg="of an image's 50 ms")
        self.assertAlmostEqual(rows["odometry/vins 99th percentile"]["ours_ms"], 99.99)
        for row in rows.values():
            self.assertEqual(tuple(row), bench.FIELDS)

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

    def test_a_task_has_one_time_and_names_its_peer(self):
        rows = bench.rows_of("marginalize/a", 1, [[FAST]], "Ceres", [[SLOW]])
        self.assertEqual([(row["problem"], row["peer"]) for row in rows], [("marginalize/a total", bench.VINS)])
        self.assertAlmostEqual(rows[0]["ratio"], 7.5)
        self.assertEqual(bench.traces_of(bench.Case("covariance/a", "", 1, ours=[[FAST]], theirs=[[SLOW]])), [])

    def test_bytes_an_observation(self):
        ours, theirs = [dict(FAST, observations=4, solver_bytes=1000.0)], [dict(SLOW, observations=4, solver_bytes=2400.0)]
        row = self.rows([ours], [theirs])["case total"]
        self.assertEqual((row["ours_bytes"], row["peer_bytes"]), (250.0, 600.0))
        self.assertIsNone(self.rows([[FAST]], [[SLOW]])["case total"]["ours_bytes"], "a window has no such count")

    def test_medians_of_turns(self):
        def lasting(seconds):
            return run([[0.0, 2.0], [seconds, 1.0]], steps=1)
        turns = [[lasting(1.0), lasting(1.2), lasting(9.0)], [lasting(5.0)], [lasting(1.4)]]
        self.assertAlmostEqual(self.rows(turns, [])["case total"]["ours_ms"], 1400.0)

    def test_problems_are_chosen_by_part_of_their_name(self):
        self.assertEqual(bench.chosen(["window/vio_M"]), ["window/vio_M", "window/vio_Md"])
        self.assertEqual(bench.chosen([]), list(bench.PROBLEMS))
        with self.assertRaisesRegex(CourseError, "no problem is called 'nothing'"):
            bench.chosen(["vio_M", "nothing"])


class Rounds(unittest.TestCase):
    def rounds(self, cases, run_side, quick):
        """What is measured when each process answers with `run_side`, the calls, and what is said."""
        calls, said = [], io.StringIO()

        def side(side, case, threads, seconds):
            calls.append((side, case.name, threads))
            return run_side(side, case, threads, seconds)
        with mock.patch.object(bench, "run_side", side), contextlib.redirect_stderr(said):
            return bench.run_rounds(cases, "Ceres", quick), calls, said.getvalue()

    def test_each_round_goes_through_all_cases(self):
        cases = [bench.Case(name, "", 1, peer_threads=(1,)) for name in ("a", "b")]
        measured, calls, said = self.rounds(cases, lambda *_: [FAST], quick=False)
        self.assertEqual(calls, [(side, name, 1) for name in ("a", "b") for side in ("ours", "ceres")] * bench.ROUNDS)
        self.assertEqual([len(case.ours) for case in measured], [bench.ROUNDS] * 2)
        self.assertEqual(said, "")

    def test_the_peer_keeps_the_number_of_threads_that_serves_it(self):
        for better in (1, 2):
            case = bench.Case("a", "", 2, peer_threads=(1, 2))
            _, calls, _ = self.rounds([case], lambda side, _, n, __: [FAST if n == better else SLOW], quick=False)
            tried = [threads for side, _, threads in calls if side == "ceres"]
            self.assertEqual(tried, [1, 2] + [better] * (bench.ROUNDS - 1))
            self.assertEqual(case.theirs, [[FAST]] * bench.ROUNDS)

    def test_quick_leaves_out_what_there_is_no_time_for(self):
        def run_side(side, case, threads, seconds):
            self.assertLessEqual(seconds, bench.QUICK_SECONDS)
            if case.name == "slow" and side == "ceres":
                raise subprocess.TimeoutExpired("measure_ceres", seconds)
            return [FAST]
        cases = [bench.Case(name, "", 1, peer_threads=(1,)) for name in ("slow", "fast")]
        measured, calls, said = self.rounds(cases, run_side, quick=True)
        self.assertEqual([(case.name, len(case.ours)) for case in measured], [("fast", bench.QUICK_ROUNDS)])
        self.assertEqual(calls.count(("ours", "slow", 1)), 1, "once is enough to know")
        self.assertIn("left out, for want of time: slow", said)

    def test_problems_without_a_file_are_named(self):
        said = io.StringIO()
        with mock.patch.object(bench, "data_folder", lambda: Path("/nowhere")), contextlib.redirect_stderr(said):
            self.assertEqual([case.name for case in bench.cases_of(["bal/49-7776", "scene/3x20"], True)], ["scene/3x20"])
            self.assertIn("left out, for want of their files in /nowhere: bal/49-7776", said.getvalue())
            with self.assertRaisesRegex(CourseError, "nothing to measure: bal/49-7776 .* set CH5_DATA_DIR"):
                bench.cases_of(["bal/49-7776"], False)
