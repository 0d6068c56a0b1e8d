"""ch5_window, and ./course run FILE on a stored window: what they print, write and refuse."""

import random
import re

from tests.experiments.programs_under_test import AppTest, contents, table
from tests.project import ROOT, run

RESULTS = {"frames.csv", "trace.csv", "summary.csv", "corner-result.tum"}


def corner(noise=0.0) -> str:
    """Three frames 0.5 m apart that see twenty points; two frames are held, the third starts 5 cm off."""
    draw = random.Random(3).uniform
    rest = "0 0 0 0 0 0 0 0 0"
    true = [f"{i} {0.5 * i!r} 0 0 0 0 0 1 {rest}" for i in range(3)]  # T has no time
    start = [f"{i} {0.1 * i!r} {0.5 * i!r} 0 0 0 0 0 1 {rest}" for i in range(2)]
    start.append(f"2 0.2 1.05 0.05 -0.03 0 0 0 1 {rest}")
    lines = ["VIOWIN 1", "G 0 0 9.81", "NOISE 0.08 0.004 4e-5 2e-6", "SQRTINFO 300", "LOSS cauchy 1",
             "EXT 0 0 0 0 0 0 1 1", "FRAMES 3"]
    for before, truth in zip(start, true):
        lines += ["F " + before, "T " + truth]
    lines += ["IMUS 0", "LANDMARKS 20"]
    for k in range(20):
        x, y, z = draw(-2, 2), draw(-2, 2), draw(4, 8)
        lines.append(f"L {k} 0 2 {1 / (z + 0.3)!r} {1 / z!r} {x / z!r} {y / z!r}")
        lines += [f"  {i} {(x - 0.5 * i) / z + draw(-noise, noise)!r} {y / z!r}" for i in (1, 2)]
    return "\n".join([*lines, "PRIOR 0 0", "FIXED 2 0 1", "END", ""])


class WindowApp(AppTest):
    app = "ch5_window"

    def test_window_is_solved(self):
        path = self.write("corner.txt", corner())
        self.solve(path, "--out", self.out)
        self.assertEqual({file.name for file in self.out.iterdir()}, RESULTS)
        summary = self.summary()
        self.assertEqual((summary["problem"], summary["frames"], summary["landmarks"]), ("corner", "3", "20"))
        self.assertLess(float(summary["final_cost"]), 1e-9 * float(summary["initial_cost"]), "exact data")
        self.assertEqual(table(self.out / "trace.csv")[-1]["cost"], summary["final_cost"])
        frames = {(row["state"], row["frame"]): row for row in table(self.out / "frames.csv")}
        for axis in ("x_m", "y_m", "z_m"):
            self.assertAlmostEqual(float(frames["after", "2"][axis]), float(frames["truth", "2"][axis]), delta=1e-6)
        tum = [line.split() for line in (self.out / "corner-result.tum").read_text().splitlines()]
        self.assertEqual([len(state) for state in tum], [8, 8, 8])

    def test_course_run_gives_the_numbers_as_json(self):
        result = self.course_solve(self.write("corner.txt", corner(noise=0.002)))
        self.assertTrue(0.0 < result["final_cost"] < 0.1 * result["initial_cost"], result)
        self.assertIn("converged", result["termination"])
        for suffix in (".csv", ".tum", ".png"):
            self.assertTrue(list((self.out / "corner").rglob("*" + suffix)), f"no {suffix} among the results")

    def test_a_bare_frame_costs_nothing_and_is_drawn(self):
        head = corner().splitlines()[:6]
        state = "0 0 0 0 0 0 1" + 9 * " 0"
        lines = [*head, "FRAMES 1", f"F 0 0 {state}", f"T 0 {state}", "IMUS 0", "LANDMARKS 0", "PRIOR 0 0", "FIXED 0",
                 "END", ""]
        path = self.write("bare.txt", "\n".join(lines))
        done = run(ROOT / "course", "run", path, "--out", self.out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("Warning", done.stderr)
        self.assertIn("nothing to optimize", done.stdout)
        self.assertEqual([row["cost"] for row in table(self.out / "bare" / "trace.csv")], ["0"])
        self.assertTrue((self.out / "bare" / "figures" / "window.png").exists())

    def test_a_faulty_window_is_named_and_nothing_is_lost(self):
        self.solve(self.write("corner.txt", corner()), "--out", self.out)
        path = self.write("corner.txt", corner().replace("SQRTINFO 300", "SQRTINFO -3"))  # others: tests/files/window_dump_test.cc
        before = contents(self.folder)
        done = self.program(path, "--out", self.out)
        self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (2, "", 1))
        self.assertRegex(done.stderr, rf"^ch5_window: {re.escape(str(path))}:4: .*-3")
        self.assertEqual(contents(self.folder), before)

    def test_a_point_in_a_cameras_plane_has_no_cost(self):
        lines = corner().splitlines()
        lines[9] = "F 1 0.1 0 0 1 0 0 0 1" + 9 * " 0"    # 1 m ahead,
        lines[15] = "L 0 0 2 1 0.2 0.3 0.4"              # where the first landmark is, 1 m from the first camera
        path = self.write("corner.txt", "\n".join(lines) + "\n")
        self.refuses(path, "--out", self.out, message=f"{path}: not finite: the cost of the initial states is not "
                                                      "finite; EdgeReprojection 0 has a residual or a Jacobian that is not finite")
