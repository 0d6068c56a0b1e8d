"""ch5_window, and ./course run FILE on a stored window: what they print, write and refuse."""

import random

from tests.experiments.programs_under_test import DATA, ROOT, AppTest, needs, run, table

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
        result = self.course_run(self.write("corner.txt", corner(noise=0.002)), "--iterations", "30", "--threads", "2")
        for key, kind in (("initial_cost", float), ("final_cost", float), ("iterations", int), ("seconds", float)):
            self.assertIsInstance(result[key], kind, key)
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

    def test_faulty_windows_are_named_and_nothing_is_lost(self):
        path = self.write("corner.txt", corner())
        self.assertEqual(self.program(path, "--out", self.out).returncode, 0)
        lines = corner().splitlines()
        for line, words, value in ((5, "LOSS quadratic 1", "quadratic"), (4, "SQRTINFO -3", "-3"),
                                   (10, lines[9].replace("0.5", "half"), "half"), (12, lines[11].replace("1.05", "nan"), "nan"),
                                   (16, lines[15].replace("L 0 0", "L 0 7"), "7"),
                                   (16, "L 0 0 2 1e-310 0.2 0.3 0.4", "inverse depth: must not be 0")):
            spoilt = [*lines[:line - 1], words, *lines[line:]]
            self.refuses_line(self.write("corner.txt", "\n".join(spoilt) + "\n"), line, value)
        self.refuses_line(self.write("corner.txt", "\n".join(lines[:20]) + "\n"), None, "")  # breaks off

    def test_a_point_in_a_cameras_plane_has_no_cost(self):
        lines = corner().splitlines()
        lines[9] = "F 1 0.1 0 0 1 0 0 0 1" + 9 * " 0"    # 1 m ahead,
        lines[15] = "L 0 0 2 1 0.2 0.3 0.4"              # where the first landmark is, 1 m from the first camera
        path = self.write("corner.txt", "\n".join(lines) + "\n")
        self.refuses(path, "--out", self.out, message=f"{path}: residual 0 (EdgeReprojection) is not finite at the start")

    def refuses_line(self, path, line, value):
        before = {file.name: file.read_bytes() for file in self.out.iterdir()}
        done = self.program(path, "--out", self.out)
        self.assertEqual((done.returncode, done.stdout), (2, ""), value)
        self.assertIn(f"ch5_window: {path}:" + (f"{line}: " if line else ""), done.stderr)
        self.assertIn(value, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, "one message")
        self.assertEqual({file.name: file.read_bytes() for file in self.out.iterdir()}, before)

    def test_a_window_is_refused_a_loss(self):
        done = run(ROOT / "course", "run", self.write("corner.txt", corner()), "--huber", "1", "--out", self.out)
        self.assertEqual(done.returncode, 2)
        self.assertIn("--huber does not apply", done.stderr)
        self.assertFalse(self.out.exists())

    def test_stored_windows_reach_their_known_costs(self):
        for name, initial, converged in (("vio_S", 3.394001e2, 2.799642868e2), ("real_euroc_sub2", 1.572934e8, 2.259314504e2)):
            result = self.course_run(needs(DATA / "windows" / f"{name}.txt"), "--iterations", "200")
            self.assertAlmostEqual(result["initial_cost"], initial, delta=1e-6 * initial)
            self.assertLessEqual(result["final_cost"], converged * (1 + 1e-4))
