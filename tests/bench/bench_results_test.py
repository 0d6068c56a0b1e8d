"""What ./course bench makes of its runs: numbers worked by hand."""

import contextlib
import io
import subprocess
import unittest
from pathlib import Path
from unittest import mock

from ch5_backend.course.experiments import bench
from ch5_backend.figures.numbers import peers
from ch5_backend.course.base.errors import CourseError


def run(trace, trials=4, peak=10.0):
    return {"initial_cost": trace[0][1], "final_cost": trace[-1][1], "seconds": trace[-1][0], "trials": trials,
            "peak_mb": peak, "trace": trace}


def lasting(seconds):
    return run([[0.0, 2.0], [seconds, 1.0]], trials=1)


FAST = run([[0.0, 500.0], [0.1, 101.0], [0.2, 100.05], [0.4, 100.0]])
SLOW = run([[0.0, 500.0], [1.0, 102.0], [2.0, 100.5], [3.0, 100.2]], trials=3, peak=30.0)
WAY, OTHER = bench.ways_of("bal/49-7776")[:2]


def case(ours, theirs, name="bal/49-7776", threads=1):
    """Both settings of ours are measured alike; of the peer {way: turns}, or the turns of the first way."""
    ways = theirs if isinstance(theirs, dict) else {WAY: theirs} if theirs else {}
    return bench.Case(name, "", threads, ours={bench.UNASKED: ours, WAY: ours}, theirs=ways)


class Rows(unittest.TestCase):
    def rows(self, ours, theirs, peer="Ceres", setting=bench.BEST):
        return {row["problem"].split(" ", 1)[1]: row for row in bench.rows_of(case(ours, theirs), peer) if row["setting"] == setting}

    def test_an_estimator_is_measured_against_its_recording(self):
        images = [{"seconds": 0.001 * k, "steps": 3, "final_cost": 5.0} for k in range(1, 101)]
        given = bench.Case("odometry/vins_200", "", 1, ours={bench.UNASKED: [images]})
        rows = {row["problem"]: row for row in bench.rows_of(given, "Ceres")}
        self.assertEqual(set(rows), {f"odometry/vins_200 {what}" for what in ("mean", "median", "99th percentile", "worst")})
        self.assertAlmostEqual(rows["odometry/vins_200 mean"]["ours_ms"], 50.5)
        self.assertAlmostEqual(rows["odometry/vins_200 mean"]["ratio"], 50.0 / 50.5, msg="of an image's 50 ms")
        self.assertAlmostEqual(rows["odometry/vins_200 99th percentile"]["ours_ms"], 99.99)
        self.assertAlmostEqual(rows["odometry/vins_200 worst"]["ours_ms"], 100.0)
        for row in rows.values():
            self.assertEqual(tuple(row), bench.FIELDS)

    def test_times_and_ratio(self):
        rows = self.rows([[FAST]], [[SLOW]])
        self.assertAlmostEqual(rows["iteration"]["ours_ms"], 100.0)
        self.assertAlmostEqual(rows["iteration"]["peer_ms"], 1000.0, msg="by trials, the one that ends the solve too")
        self.assertAlmostEqual(rows["iteration"]["ratio"], 10.0)
        self.assertAlmostEqual(rows["to 1 %"]["ours_ms"], 100.0)
        self.assertAlmostEqual(rows["to 1 %"]["peer_ms"], 2000.0)
        self.assertAlmostEqual(rows["to the peer's cost"]["ours_ms"], 200.0)
        self.assertEqual(tuple(rows["total"]), bench.FIELDS)

    def test_a_side_that_does_not_get_there_has_no_time(self):
        row = self.rows([[FAST]], [[SLOW]])["to 0.1 %"]
        self.assertAlmostEqual(row["ours_ms"], 200.0)
        self.assertIsNone(row["peer_ms"])
        self.assertIsNone(row["ratio"])
        self.assertIsNone(row["peer_way"])

    def test_the_peer_s_best_way_is_that_of_the_row(self):
        soon = run([[0.0, 500.0], [0.5, 100.9], [9.0, 100.2]], trials=3)  # at 1 % first, and late at its end
        rows = self.rows([[FAST]], {WAY: [[SLOW]], OTHER: [[soon]]})
        self.assertEqual([(rows[q]["peer_way"], rows[q]["peer_ms"]) for q in ("to 1 %", "total", "iteration")],
                         [(OTHER, 500.0), (WAY, 3000.0), (WAY, 1000.0)])
        alike = self.rows([[FAST]], {WAY: [[SLOW]], OTHER: [[soon]]}, setting=bench.SAME)
        self.assertEqual({row["peer_way"] for row in alike.values()} - {None}, {WAY})
        self.assertAlmostEqual(alike["to 1 %"]["ratio"], 20.0)

    def test_a_total_counts_only_near_the_least_cost(self):
        hasty = run([[0.0, 500.0], [0.1, 400.0]])
        self.assertEqual(self.rows([[FAST]], {WAY: [[SLOW]], OTHER: [[hasty]]})["total"]["peer_way"], WAY)

    def test_a_way_that_was_not_kept_does_not_count(self):
        rows = self.rows([[FAST]] * 2, {WAY: [[SLOW]] * 2, OTHER: [[FAST]]})
        self.assertEqual(rows["total"]["peer_way"], WAY)

    def test_the_ratio_is_that_of_neighbors_in_time(self):
        row = self.rows([[lasting(1.0)], [lasting(2.0)], [lasting(9.0)]], [[lasting(3.0)], [lasting(6.0)], [lasting(18.0)]])["total"]
        self.assertAlmostEqual(row["ratio"], 3.0)
        self.assertEqual((row["ours_ms"], row["peer_ms"]), (2000.0, 6000.0))

    def test_to_arrive_after_the_end_stops_the_bench(self):
        twice = dict(SLOW, seconds=1.5)  # as if a part of the trace's times were counted twice
        for ours, theirs, side in (([[FAST]], [[twice]], "peer_ms"), ([[dict(FAST, seconds=0.05)]], [[SLOW]], "ours_ms")):
            with self.assertRaisesRegex(CourseError, f"'bal/49-7776 to .*{side} is .* after the total of .* counted twice"):
                self.rows(ours, theirs)

    def test_without_a_peer_ours_stand_alone(self):
        rows = self.rows([[FAST]], [], None)
        self.assertNotIn("to the peer's cost", rows)
        row = rows["total"]
        self.assertEqual([row[key] for key in ("peer", "peer_way", "peer_ms", "ratio", "peer_cost", "peer_peak_mb")], [None] * 6)
        self.assertAlmostEqual(row["ours_ms"], 400.0)
        self.assertIn("–", bench.table(list(rows.values())))
        for columns in (60, 80, 120):  # of a terminal
            shown = bench.table(list(rows.values()), columns).splitlines()
            self.assertLessEqual(max(map(len, shown)), columns)
            self.assertIn("ours ms", shown[0])
        self.assertEqual(peers.kinds_of(list(rows.values())), [])

    def test_a_task_has_one_time_for_each_of_its_peers(self):
        given = bench.Case("marginalize/a", "", 1, ours={"": [[FAST]]}, theirs={"": [[SLOW]], "ldlt": [[FAST]]})
        rows = bench.rows_of(given, "Ceres")
        self.assertEqual([(row["problem"], row["peer"]) for row in rows],
                         [("marginalize/a total", "VINS-Mono's way"), ("marginalize/a total", "Eigen's LDLT")])
        self.assertAlmostEqual(rows[0]["ratio"], 7.5)
        self.assertAlmostEqual(rows[1]["ratio"], 1.0)
        self.assertEqual(bench.traces_of(bench.Case("covariance/a", "", 1, ours={"": [[FAST]]}, theirs={"": [[SLOW]]})), [])

    def test_bytes_an_observation(self):
        ours, theirs = [dict(FAST, observations=4, solver_bytes=1000.0)], [dict(SLOW, observations=4, solver_bytes=2400.0)]
        row = self.rows([ours], [theirs])["total"]
        self.assertEqual((row["ours_bytes"], row["peer_bytes"]), (250.0, 600.0))
        self.assertIsNone(self.rows([[FAST]], [[SLOW]])["total"]["ours_bytes"], "a window has no such count")

    def test_medians_of_turns(self):
        turns = [[lasting(1.0), lasting(1.2), lasting(9.0)], [lasting(5.0)], [lasting(1.4)]]
        self.assertAlmostEqual(self.rows(turns, [])["total"]["ours_ms"], 1400.0)

    def test_a_kind_has_the_geometric_mean_of_all_its_problems(self):
        rows = [{"problem": f"window/{k} to 0.1 %", "setting": bench.BEST, "threads": 1, "peer": "Ceres", "ratio": ratio}
                for k, ratio in enumerate((2.0, 8.0, None))]
        self.assertEqual(peers.kinds_of(rows), [("windows", bench.BEST, "to 0.1 %", 4.0, 2.0, 8.0, 2, 3)])
        self.assertEqual(peers.kinds_of([dict(row, threads=2) for row in rows]), [])

    def test_problems_are_chosen_by_part_of_their_name(self):
        self.assertEqual(bench.chosen(["window/vio_M"]), ["window/vio_M", "window/vio_Md"])
        self.assertEqual(bench.chosen([]), list(bench.PROBLEMS))
        with self.assertRaisesRegex(CourseError, "no problem is called 'nothing'"):
            bench.chosen(["vio_M", "nothing"])


class Rounds(unittest.TestCase):
    def rounds(self, cases, run_side, quick):
        """What is measured when each process answers with `run_side`, the calls, and what is said."""
        calls, said = [], io.StringIO()

        def side(side, case, way, seconds):
            calls.append((side, case.name, way))
            return run_side(side, case, way, seconds)
        with mock.patch.object(bench, "run_side", side), contextlib.redirect_stderr(said):
            return bench.run_rounds(cases, "Ceres", quick), calls, said.getvalue()

    def test_each_round_goes_through_all_cases(self):
        cases = [bench.Case(name, "", 1, ways=(WAY,)) for name in ("bal/49-7776", "bal/16-22106")]
        measured, calls, said = self.rounds(cases, lambda *_: [FAST], quick=False)
        self.assertEqual(calls, [call for name in ("bal/49-7776", "bal/16-22106") for call in
                                 (("ours", name, ""), ("ours", name, WAY), ("ceres", name, WAY))] * bench.ROUNDS)
        self.assertEqual([len(case.ours[""]) for case in measured], [bench.ROUNDS] * 2)
        self.assertEqual(said, "")

    def test_later_rounds_keep_the_ways_that_were_best_at_something_and_that_of_the_same_problem(self):
        ways = bench.ways_of("bal/49-7776")
        one = bench.Case("bal/49-7776", "", 1, ways=ways)
        two = bench.Case("bal/49-7776", "", 2, alone=one)
        times = {OTHER: FAST, OTHER + ",threads=1": run([[0.0, 500.0], [0.05, 101.0], [0.1, 100.05], [0.3, 100.0]])}
        _, calls, _ = self.rounds([one, two], lambda side, case, way, _: [times.get(way, SLOW)], quick=False)
        tried = [way for side, _, way in calls if side == "ceres"]
        both = (WAY, WAY + ",threads=1", OTHER, OTHER + ",threads=1")
        self.assertEqual(tried, [*ways, *both] + [WAY, OTHER, WAY, OTHER + ",threads=1"] * (bench.ROUNDS - 1))

    def test_quick_leaves_out_what_there_is_no_time_for(self):
        def run_side(side, case, way, seconds):
            self.assertLessEqual(seconds, bench.QUICK_SECONDS)
            if case.name == "bal/49-7776" and side == "ceres":
                raise subprocess.TimeoutExpired("measure_ceres", seconds)
            return [FAST]
        cases = [bench.Case(name, "", 1, ways=(WAY,)) for name in ("bal/49-7776", "bal/16-22106")]
        measured, calls, said = self.rounds(cases, run_side, quick=True)
        self.assertEqual([(case.name, len(case.ours[""])) for case in measured], [("bal/16-22106", bench.QUICK_ROUNDS)])
        self.assertEqual(calls.count(("ours", "bal/49-7776", "")), 1, "once is enough to know")
        self.assertIn("left out, because time ran out: bal/49-7776", said)

    def test_problems_without_a_file_are_named(self):
        said = io.StringIO()
        with mock.patch.object(bench, "data_folder", lambda: Path("/nowhere")), contextlib.redirect_stderr(said):
            self.assertEqual([case.name for case in bench.cases_of(["bal/49-7776", "scene/3x20"], True)], ["scene/3x20"])
            self.assertIn("left out, because their files are not in /nowhere: bal/49-7776", said.getvalue())
            with self.assertRaisesRegex(CourseError, "nothing to measure: bal/49-7776 .* set CH5_DATA_DIR"):
                bench.cases_of(["bal/49-7776"], False)
