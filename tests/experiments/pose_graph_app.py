"""ch5_pose_graph as its users see it: results, exit codes, messages."""

import csv
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

APP = os.environ["CH5_POSE_GRAPH"]
PLOT = "ch5_backend.figures.pose_graph"

UNIT = "1 0 0 1 0 1"
# A triangle that does not quite close, and a line that nobody here knows.
GOOD = f"""VERTEX_SE2 5 0 0 0
VERTEX_SE2 6 1 0.1 2
VERTEX_SE2 7 0.4 0.9 -2
SENSOR_CHEESE 1 2 3
EDGE_SE2 5 6 1 0 2.1 {UNIT}
EDGE_SE2 6 7 1 0 2.1 {UNIT}
EDGE_SE2 7 5 1 0 2.1 {UNIT}
"""
RESULTS = {"good-result.g2o", "summary.csv", "trace.csv", "poses.csv", "edges.csv"}


def app(*words):
    return subprocess.run([APP, *map(str, words)], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=120)


def table(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


class PoseGraphApp(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.out = self.folder / "out"

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text, encoding="utf-8")
        return path

    def test_good_file_is_solved(self):
        good = self.write("good.g2o", GOOD)
        done = app(good, "--out", self.out)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual({path.name for path in self.out.iterdir()}, RESULTS)
        self.assertIn(f"{good}:4: unknown, kept as it is: SENSOR_CHEESE 1 2 3\n", done.stdout)
        self.assertIn("pose 5 was held", done.stdout)

        summary = {row["key"]: row["value"] for row in table(self.out / "summary.csv")}
        self.assertEqual((summary["problem"], summary["vertices"], summary["edges"]), ("good", "3", "3"))
        self.assertLess(float(summary["final_cost"]), float(summary["initial_cost"]))
        self.assertAlmostEqual(float(summary["chi2"]), 2 * float(summary["final_cost"]), delta=1e-12)
        self.assertIn("converged", summary["termination"])
        self.assertEqual(table(self.out / "trace.csv")[-1]["cost"], summary["final_cost"])
        edges = table(self.out / "edges.csv")
        self.assertAlmostEqual(sum(float(edge["chi2_after"]) for edge in edges), float(summary["chi2"]), delta=1e-12)
        poses = table(self.out / "poses.csv")
        self.assertEqual([pose["id"] for pose in poses], ["5", "6", "7"] * 2)

        # The result is a problem whose first cost is the cost that was reached; the unknown line is still there.
        again = app(self.out / "good-result.g2o", "--out", self.folder / "again", "--iterations", 0)
        self.assertIn(f"cost {float(summary['final_cost']):.6e} -> {float(summary['final_cost']):.6e}", again.stdout)
        self.assertIn("SENSOR_CHEESE 1 2 3", (self.out / "good-result.g2o").read_text())

    def test_faulty_files_are_named_with_line_and_value(self):
        for text, message in ((GOOD.replace("7 5 1 0", "7 8 1 0"), "7: EDGE_SE2: there is no pose with the id 8"),
                              (GOOD.replace("0.4", "nan"), '3: value: not finite, got "nan"'),
                              ("1 2 3\n", '1: expected a tag such as VERTEX_SE3:QUAT, got "1"')):
            path = self.write("bad.g2o", text)
            done = app(path, "--out", self.out)
            self.assertEqual((done.returncode, done.stderr), (2, f"ch5_pose_graph: {path}:{message}\n"))
            self.assertFalse(self.out.exists())

    def test_a_graph_whose_poses_are_all_fixed_keeps_its_cost_and_is_drawn(self):
        ring = GOOD.replace("SENSOR_CHEESE 1 2 3", "FIX 5 6 7")
        straight = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nFIX 0 1\n" + f"EDGE_SE2 0 1 1 0 0 {UNIT}\n"  # costs nothing
        for name, text in (("ring", ring), ("straight", straight)):
            out = self.folder / name
            done = app(self.write(f"{name}.g2o", text), "--out", out)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertIn("nothing to optimize", done.stdout)
            summary = {row["key"]: row["value"] for row in table(out / "summary.csv")}
            self.assertEqual([row["cost"] for row in table(out / "trace.csv")], [summary["initial_cost"]])
            self.assertEqual(summary["final_cost"], summary["initial_cost"])
            self.assertEqual(float(summary["initial_cost"]) == 0.0, name == "straight")
            done = subprocess.run([sys.executable, "-m", PLOT, out], capture_output=True, text=True, timeout=120)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertTrue((out / "figures" / "pose_graph.png").exists())

    def test_the_input_is_not_overwritten(self):
        path = self.write("edges.csv", GOOD)
        done = app(path, "--out", self.folder)
        self.assertEqual(done.returncode, 2)
        self.assertIn(f"cannot write {path}: it is the input", done.stderr)
        self.assertEqual([file.name for file in self.folder.iterdir()], ["edges.csv"])
        self.assertEqual(path.read_text(encoding="utf-8"), GOOD)

    def test_graph_without_edges_is_refused(self):
        path = self.write("lonely.g2o", "VERTEX_SE2 0 1 2 3\n")
        done = app(path, "--out", self.out)
        self.assertEqual((done.returncode, done.stderr),
                         (2, f"ch5_pose_graph: {path}: no edge of a known type, so nothing to optimize\n"))
        self.assertFalse(self.out.exists())
