"""ch5_pose_graph, and ./course run FILE on a pose graph: results, exit codes, messages."""

import math
import re

from tests.experiments.programs_under_test import AppTest, table

UNIT = "1 0 0 1 0 1"
# A triangle that does not quite close.
GOOD = f"""VERTEX_SE2 5 0 0 0
VERTEX_SE2 6 1 0.1 2
VERTEX_SE2 7 0.4 0.9 -2
# a comment
EDGE_SE2 5 6 1 0 2.1 {UNIT}
EDGE_SE2 6 7 1 0 2.1 {UNIT}
EDGE_SE2 7 5 1 0 2.1 {UNIT}
"""
RESULTS = {"good-result.g2o", "summary.csv", "trace.csv", "poses.csv", "edges.csv"}


class PoseGraphApp(AppTest):
    app = "ch5_pose_graph"

    def test_good_file_is_solved(self):
        good = self.write("good.g2o", GOOD)
        done = self.solve(good, "--out", self.out)
        self.assertEqual({path.name for path in self.out.iterdir()}, RESULTS)
        self.assertIn("pose 5 was held", done.stdout)
        self.assertRegex(done.stdout, r"\n   0 .* - +- +- +0 +[\d.]+\n")  # no step has led there

        summary = self.summary()
        self.assertEqual((summary["problem"], summary["vertices"], summary["edges"]), ("good", "3", "3"))
        self.assertLessEqual(float(summary["final_cost"]), float(summary["initial_cost"]))  # the start may be the optimum
        self.assertAlmostEqual(float(summary["chi2"]), 2 * float(summary["final_cost"]), delta=1e-12)
        self.assertIn("converged", summary["termination"])
        self.assertEqual(table(self.out / "trace.csv")[-1]["cost"], summary["final_cost"])
        edges = table(self.out / "edges.csv")
        self.assertAlmostEqual(sum(float(edge["chi2_after"]) for edge in edges), float(summary["chi2"]), delta=1e-12)
        poses = table(self.out / "poses.csv")
        self.assertEqual([pose["id"] for pose in poses], ["5", "6", "7"] * 2)

        # The result is a problem whose first cost is the cost that was reached.
        again = self.solve(self.out / "good-result.g2o", "--out", self.folder / "again", "--iterations", 0)
        self.assertIn(f"cost {float(summary['final_cost']):.6e} -> {float(summary['final_cost']):.6e}", again.stdout)

    def test_edges_in_another_unit_direction_or_with_covariances_are_named_with_the_remedy(self):
        """A square of sides of 2 m, walked five times in steps of 1 m, with exact edges."""
        at = [((0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1))[i % 8] for i in range(40)]
        turns = [(0, 1, 1, 2, 2, 3, 3, 4)[i % 8] * math.pi / 2 for i in range(40)]
        def between(i, j):
            c, s, dx, dy = math.cos(turns[i]), math.sin(turns[i]), at[j][0] - at[i][0], at[j][1] - at[i][1]
            return c * dx + s * dy, c * dy - s * dx, math.remainder(turns[j] - turns[i], 2 * math.pi)
        ends = [(i, i + 1) for i in range(39)] + [(i, i + 7) for i in range(33)]
        noise = lambda k, axis: 0.1 * math.sin(7.1 * k + 2.3 * axis)
        edges = [(i, j, tuple(z + noise(k, axis) for axis, z in enumerate(between(i, j)))) for k, (i, j) in enumerate(ends)]
        scaled = lambda by: lambda i, j, z: (i, j, (by * z[0], by * z[1], z[2]))
        def file(name, change=lambda i, j, z: (i, j, z), W=200, unit=1, W_xy=None):
            rows = [f"VERTEX_SE2 {i} {unit * at[i][0]} {unit * at[i][1]} {turns[i]}" for i in range(40)]
            for i, j, z in edges:
                i, j, z = change(i, j, z)
                rows.append(f"EDGE_SE2 {i} {j} {z[0]} {z[1]} {z[2]} {W_xy or W} 0 0 {W_xy or W} 0 {W}")
            return self.write(name + ".g2o", "\n".join(rows) + "\n")
        is_loop = lambda i, j: j > i + 1
        false = file("false", lambda i, j, z: (i, j, (z[0] + 400 * (is_loop(i, j) and i % 4 == 0), *z[1:])))
        for name, path, said in (
                ("right", file("right"), None),
                ("millimeters", file("millimeters", scaled(1000)), "the first in line 41, have positions 1000 times"),
                ("poses", file("poses", scaled(0.001)), "are the poses in millimeters?"),
                ("drift where a place is seen again", file("drift", lambda i, j, z: scaled(0.01 if (i, j) == (0, 7) else 1)(i, j, z)), None),
                ("loops", file("loops", lambda i, j, z: scaled(1000 if is_loop(i, j) else 1)(i, j, z)), "line 80, have positions 1000 times"),
                ("swapped", file("swapped", lambda i, j, z: (j, i, z) if is_loop(i, j) else (i, j, z)), "from the second pose to the first: exchange their two ids"),
                ("covariance", file("covariance", W=1 / 200), "are the last numbers of the edges covariances?"),
                ("covariance in mm²", file("mm", scaled(1000), 1 / 200, 1000, 5000), "are the last numbers of the edges covariances?"),
                ("false loops", false, None), ("false loops, --gnc", false, None)):
            with self.subTest(name):
                done = self.solve(path, "--out", self.out, *(["--gnc"] if "--gnc" in name else []))
                self.assertEqual(self.summary()["doubts"], "1" if said else "0", done.stdout)
                self.assertIn(said or "pose 0 was held", done.stdout)

    def test_an_edge_of_zero_information_connects_nothing_and_is_named(self):
        for last, parts in (("", True), (f"EDGE_SE2 5 7 1 0 2 {UNIT}\n", False)):
            path = self.write("zero.g2o", "".join(GOOD.splitlines(True)[:5]) + "EDGE_SE2 6 7 1 0 2.1 0 0 0 0 0 0\n" + last)
            done = self.solve(path, "--out", self.out)
            self.assertIn("edges whose information is zero, so that they hold nothing: 1, the first in line 6\n", done.stdout)
            for words in ("line 6: the information is zero, and no other edge connects its two ends", "pose 7 was held"):
                self.assertEqual(words in done.stdout, parts)

    def test_a_tag_that_is_not_known_is_refused_or_left_out_and_said(self):
        path = self.write("cheese.g2o", GOOD.replace("# a comment", "SENSOR_CHEESE 1 2 3"))
        self.refuses(path, "--out", self.out, message=f"{path}:4: SENSOR_CHEESE: not known, so what it says would be missing; --leave-out solves the rest")
        done = self.solve(path, "--out", self.out, "--leave-out")
        self.assertIn(f"1 lines left out, since their tags are not known:\n{path}:4: SENSOR_CHEESE 1 2 3\n", done.stdout)
        self.assertEqual(self.summary()["unknown_lines"], "1")
        self.assertIn("SENSOR_CHEESE 1 2 3", (self.out / "cheese-result.g2o").read_text())

    def test_landmarks_and_priors_are_solved_with_the_poses(self):
        """The optima are those of an independent solver; they stand in the issue."""
        square = "".join(f"VERTEX_SE2 {line}\n" for line in ("0 0 0 0", "1 1.1 0 0.05", "2 2.2 0.1 0", "3 2.9 0 0"))
        square += "".join(f"EDGE_SE2 {line} 0 0 100 0 0 100 0 400\n" for line in ("0 1 1", "1 2 1", "2 3 1", "0 3 3.1"))
        landmark = "VERTEX_XY 50 2 2\nEDGE_SE2_XY 0 50 2 2 100 0 100\nEDGE_SE2_XY 3 50 -1.3 2 10000 0 10000\n"
        for name, more, cost, held, expected in (
                ("landmark", landmark, 1.171610, True, {"50": (1.907263, 2.017976), "3": (3.144494, -0.020708, -0.030621)}),
                ("fixed", landmark + "FIX 50\n", 1.993496, True, {"50": (2, 2), "3": (3.198130, -0.061038, -0.049342)}),
                ("prior", "EDGE_PRIOR_SE2 3 10 0 0 1e6 0 0 1e6 0 1e6\n", 0.125, False, {"0": (6.925, 0, 0), "3": (10, 0, 0)}),
                ("position", "EDGE_PRIOR_SE2_XY 3 10 0 1e6 0 1e6\n", 0.125, False, {"3": (10, 0)})):
            with self.subTest(name):
                done = self.solve(self.write(f"{name}.g2o", square + more), "--out", self.out)
                self.assertEqual("pose 0 was held" in done.stdout, held)
                self.assertAlmostEqual(float(self.summary()["final_cost"]), cost, delta=1e-6)
                lines = [line.split() for line in (self.out / f"{name}-result.g2o").read_text().splitlines()]
                places = {line[1]: [float(x) for x in line[2:]] for line in lines if line[0].startswith("VERTEX")}
                for vertex, place in expected.items():
                    for x, y in zip(places[vertex], place):
                        self.assertAlmostEqual(x, y, delta=2e-6)
                self.draw()

    def test_edges_alone_start_from_a_tree_or_the_relaxation(self):
        edges = self.write("edges.g2o", "".join(line + "\n" for line in GOOD.splitlines() if line.startswith("EDGE")))
        costs = []
        for start in ("odometry", "spanning-tree", "chordal", None):
            self.solve(edges, "--out", self.out, *(("--init", start) if start else ()))
            self.assertEqual(self.summary()["start"], start or "chordal")
            costs.append(float(self.summary()["final_cost"]))
        self.assertLess(max(costs) - min(costs), 1e-9, costs)
        self.solve(self.out / "edges-result.g2o", "--out", self.folder / "again", "--init", "file")  # it has poses
        self.refuses(edges, "--out", self.out, "--init", "file",
                     message=f"{edges}: this file holds edges only, so no poses to start from")

    def test_an_information_that_is_none_is_refused_with_the_way_out(self):
        path = self.write("bad.g2o", GOOD.replace("2.1 1 0 0 1 0 1", "2.1 1 0 0 1 0 -3", 1))
        self.refuses(path, "--out", self.out, message=f"{path}:5: EDGE_SE2: the information matrix is not positive "
                     "semi-definite: (2, 2) = -3 (g2o gives its upper half row by row); --project-information takes the nearest one that is")
        done = self.solve(path, "--out", self.out, "--project-information")
        self.assertIn("1 information matrices were not positive semi-definite, and were projected\n", done.stdout)
        self.assertEqual(self.summary()["projected_information"], "1")

    def test_ids_of_gtsam_and_a_repeated_edge(self):
        text = re.sub(r"(?<=VERTEX_SE2 )\d|(?<=EDGE_SE2 )\d|(?<=EDGE_SE2 \d )\d", lambda id: str((ord("x") << 56) + int(id[0])), GOOD)
        done = self.solve(self.write("ids.g2o", text + text.splitlines()[-1] + "\n"), "--out", self.out)
        self.assertIn("pose 8646911284551352325 was held", done.stdout)
        self.assertIn("counted twice: 1, the first in line 8\n", done.stdout)
        self.draw()

    def test_what_a_file_has_too_often_or_for_nothing_is_said(self):
        alone = "".join(f"VERTEX_SE2 {i} {i} 2 0.5\n" for i in range(10, 17))
        done = self.solve(self.write("odd.g2o", alone + GOOD.splitlines()[0] + "\n" + GOOD[:-1]), "--out", self.out)
        self.assertIn("without an edge, which stay where the file has them: 7, with the ids 10 11 12 13 14 …\n", done.stdout)
        self.assertIn("with the same numbers, and counted once: 1, the first in line 9\n", done.stdout)
        self.assertIn('odd.g2o:15: the file ends without a line\'s end; if it is cut, so may be its last number, "1"\n', done.stdout)
        summary = self.summary()
        self.assertEqual([summary[key] for key in ("without_edges", "repeated_vertices", "last_line_unended")], ["7", "1", "1"])
        self.assertIn("VERTEX_SE2 16 16 2 0.5\n", (self.out / "odd-result.g2o").read_text())

    def test_a_run_that_ends_at_its_limit_says_so(self):
        good = self.write("good.g2o", GOOD)
        words = "not converged: the last iteration still lowered the cost by"
        self.assertIn(words, self.solve(good, "--out", self.out, "--init", "file", "--iterations", 1).stdout)
        self.assertNotIn(words, self.solve(good, "--out", self.out, "--init", "file").stdout)

    def test_the_place_of_the_origin_is_of_no_matter(self):
        costs, turn = [], math.tau / 12
        for east, north in ((0, 0), (512345.678, 4649776.22)):  # UTM
            circle = "".join(f"VERTEX_SE2 {i} {east + 1.9 * math.cos(i * turn) + 0.5 * math.sin(1.7 * i)} "
                             f"{north + 1.9 * math.sin(i * turn) + 0.5 * math.cos(2.3 * i)} {i * turn + 1.6}\n" for i in range(12))
            edges = "".join(f"EDGE_SE2 {i} {(i + 1) % 12} 1 {0.05 * math.sin(i)} {turn} {UNIT}\n" for i in range(12))
            self.solve(self.write("map.g2o", circle + edges + f"EDGE_SE2 0 6 3 4 3 {UNIT}\n"), "--out", self.out, "--init", "file")
            costs.append(float(self.summary()["final_cost"]))
        self.assertAlmostEqual(costs[0] / costs[1], 1.0, 6)

    def test_course_run_gives_the_numbers_as_json(self):
        result = self.course_run(self.write("good.g2o", "\ufeff" + GOOD), "--init", "odometry", "--project-information")
        self.assertEqual((result["start"], result["projected_information"]), ("odometry", 0))
        self.assertEqual((result["vertices"], result["edges"]), (3, 3))
        self.assertIn("converged", result["termination"])
        self.assertLessEqual({".csv", ".g2o", ".png"}, {path.suffix for path in self.out.rglob("*")})

    def test_faulty_files_are_named_with_line_and_value(self):
        for text, message in ((GOOD.replace("0.4", "nan"), ':3: value: not finite, got "nan"'),  # the others: tests/files/g2o_file_test.cc
                              ("VERTEX_SE2 0 1 2 3\n", ": no edge of a known type, so nothing to optimize"),
                              (GOOD.replace(UNIT, "0 0 0 0 0 0"), ": the information matrices of all edges are zero, so nothing to optimize")):
            path = self.write("bad.g2o", text)
            self.refuses(path, "--out", self.out, message=f"{path}{message}")
            self.assertFalse(self.out.exists())

    def test_a_graph_whose_poses_are_all_fixed_keeps_its_cost_and_is_drawn(self):
        ring = GOOD.replace("# a comment", "FIX 5 6 7")
        straight = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nFIX 0 1\n" + f"EDGE_SE2 0 1 1 0 0 {UNIT}\n"  # costs nothing
        for name, text in (("ring", ring), ("straight", straight)):
            done = self.solve(self.write(f"{name}.g2o", text), "--out", self.out)
            self.assertIn("nothing to optimize", done.stdout)
            summary = self.summary()
            self.assertEqual([row["cost"] for row in table(self.out / "trace.csv")], [summary["initial_cost"]])
            self.assertEqual(summary["final_cost"], summary["initial_cost"])
            self.assertEqual(float(summary["initial_cost"]) == 0.0, name == "straight")
            self.draw()
