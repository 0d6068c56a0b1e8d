"""ch5_bal, and ./course run FILE: results, exit codes, messages, and old results that no failure touches."""

import json
import random
import re
from pathlib import Path

from tests.experiments.programs_under_test import AppTest, contents, real, table
from tests.project import ROOT, run

# Two cameras see three points; line 1 the counts, 2-7 observations, then cameras and points.
GOOD = """2 3 6
0 0 25 50
1 0 -25 50
0 1 -25 50
1 1 -75 50
0 2 10 -20
1 2 -40 -20
0 0 0 0 0 -5 500 0 0
0 0.1 0 0 0 -5 500 0 0
0.25 0.5 0
-0.25 0.5 0.125
0.1 -0.2 0.1
"""


def made_up(off=0.0, points_off=20) -> str:
    """Eight cameras in a row see 300 points, with a third of a pixel of noise; so many of the 2400 are off by so many pixels."""
    draw = random.Random(5)
    points = [(draw.uniform(-2, 2), draw.uniform(-2, 2), draw.uniform(-9, -5)) for _ in range(300)]
    seen = [f"{i} {k} {500 * (x - 0.3 * i) / -z + draw.gauss(0, 0.33) + off * (-1) ** k * (k < points_off and i == k % 8)!r} {500 * y / -z + draw.gauss(0, 0.33)!r}"
            for k, (x, y, z) in enumerate(points) for i in range(8)]
    numbers = [number for i in range(8) for number in (0, 0, 0, -0.3 * i, 0, 0, 500, 0, 0)] + [x for point in points for x in point]
    return "\n".join([f"8 300 {len(seen)}", *seen, *map(repr, numbers), ""])


RESULTS = {"good-result.txt", "good-before.ply", "good-after.ply", "summary.csv", "trace.csv", "points.csv",
           "cameras.csv"}


class BalApp(AppTest):
    app = "ch5_bal"

    def setUp(self):
        super().setUp()
        self.good = self.write("good.txt", GOOD)

    def test_good_file_is_solved(self):
        done = self.solve(self.good, "--out", self.out)
        self.assertEqual({path.name for path in self.out.iterdir()}, RESULTS)
        summary, trace = self.summary(), table(self.out / "trace.csv")
        self.assertEqual((summary["problem"], summary["cameras"], summary["points"], summary["observations"]),
                         ("good", "2", "3", "6"))
        self.assertLess(float(summary["final_cost"]), float(summary["initial_cost"]))
        self.assertIn("converged", summary["termination"])
        self.assertEqual(int(trace[-1]["iteration"]), int(summary["iterations"]))
        self.assertEqual(trace[-1]["cost"], summary["final_cost"])
        self.assertIn(f"{float(summary['final_cost']):.6e}", done.stdout)
        # The result is a problem whose first cost is the cost that was reached.
        again = self.solve(self.out / "good-result.txt", "--out", self.folder / "again", "--iterations", 0)
        self.assertIn(f"cost {float(summary['final_cost']):.6e} -> {float(summary['final_cost']):.6e}", again.stdout)

    def test_course_run_gives_the_numbers_as_json(self):
        result = self.course_solve(self.good)
        self.assertLess(result["final_cost"], result["initial_cost"])
        before = contents(self.out)
        self.assertLessEqual({".csv", ".ply", ".txt", ".png"}, {path.suffix for path in before})
        self.write("good.txt", GOOD[:len(GOOD) // 2])
        done = run(ROOT / "course", "run", self.good, "--out", self.out, "--json")
        self.assertEqual(done.returncode, 2)
        self.assertIn(str(self.good), json.loads(done.stdout)["error"])
        self.assertEqual(contents(self.out), before)

    def test_too_few_iterations_are_no_error(self):
        self.assertIn("maximum of iterations", self.solve(self.good, "--out", self.out, "--iterations", 1).stdout)

    def test_every_solver_finds_the_same_optimum(self):
        costs = []
        for solver in ("automatic", "dense", "sparse", "pcg", "implicit-pcg", "power-series"):
            self.solve(self.good, "--out", self.out, "--solver", solver, "--iterations", 100)
            costs.append(float(self.summary()["final_cost"]))
        self.assertLess(max(costs) - min(costs), 1e-3, costs)

    def test_doubtful_data_are_solved_and_told_of(self):
        lines = self.solve(self.good, "--out", self.out).stdout.splitlines()
        few = "cameras that see fewer than five points, so that their nine unknowns are not all determined: 2"
        self.assertIn(few, lines)
        self.assertFalse([line for line in lines if "--huber" in line or "no x is" in line or "fewer than two" in line or "focal" in line or "median" in line])
        for text, words in ((GOOD.replace("2 3 6", "2 4 6") + "1 2 3\n", "points that fewer than two cameras see, so that their distance is unknown: 1"),
                            (GOOD.replace("0 0.1 0 0", "0 6.3831853 0 0"), "cameras turned by more than a full turn: 1; BAL's rotations are in radians"),
                            (re.sub(r"^([01] [012]) .*", r"\1 320 240", GOOD, count=6, flags=re.M), "no x is negative: BAL's pixels are counted"),
                            (GOOD.replace("0 0 25 50", "0 0 1e9 50"), "as the median: 1, the first in line 2: camera 0, point 0, (1e+09, 50)"),
                            (GOOD.replace("-5 500", "-5 -500", 1), "camera 0 has the focal length -500 px in the file: negative"),
                            (made_up().replace("\n500\n", "\n1e12\n", 1), "camera 0 has the focal length 1e+12 px in the file: implausible beside the others"),
                            (GOOD.replace("0 -5", "0 5"), "in 6 observations the file has the point behind its camera")):
            self.assertIn(words, self.solve(self.write("doubtful.txt", text), "--out", self.out).stdout)

    def test_outliers_are_told_of_with_the_loss_that_limits_them(self):
        pairs = [(made_up(), made_up(off=60.0)), (made_up(), made_up(off=60.0, points_off=120))]
        for path in real("bal/problem-49-7776-pre.txt"):
            text = path.read_text()
            pairs.append((text, re.sub(r"^(0 \d+ ) *\S+ *(\S+)$", r"\1 500 \2", text, count=20, flags=re.M)))
        for text, spoilt in pairs:
            self.assertNotIn("--huber", self.solve(self.write("fine.txt", text), "--out", self.out, "--iterations", 15).stdout)
            bad = self.write("bad.txt", spoilt)
            said = self.solve(bad, "--out", self.out, "--iterations", 15).stdout
            self.assertRegex(said, rf"\d+ of {text.split(maxsplit=3)[2]} residuals are more than 5 times the median, [\d.]+, and hold \d\d % of "
                             r"the cost; --huber [\d.]+ limits")
            self.assertNotIn("residuals are more", self.solve(bad, "--out", self.out, "--iterations", 5, "--huber", "1.2").stdout)

    def test_faulty_files_are_named_with_line_and_value(self):
        bad = self.write("bad.txt", GOOD.replace("-75", "nan"))  # the others: tests/files/bad_bal_test.cc
        self.refuses(bad, "--out", self.out, message=f'{bad}:5: observation 3, x: not finite, got "nan"')
        self.assertFalse(self.out.exists())
        self.assertNotIn("without a line's end", self.solve(self.good, "--out", self.out).stdout)
        cut = self.write("cut.txt", GOOD.rstrip()[:-1])
        self.assertIn(f"{cut}:{GOOD.count(chr(10))}: the file ends without a line's end", self.solve(cut, "--out", self.out).stdout)
        self.assertEqual(self.summary()["last_line_unended"], "1")
        missing = self.folder / "missing.txt"
        self.refuses(missing, "--out", self.out, message=f"{missing}: cannot be read: No such file or directory")

    def test_a_cost_of_zero_is_drawn_without_a_warning(self):
        self.solve(self.good, "--out", self.out)
        trace = self.out / "trace.csv"
        head, *rows = trace.read_text().splitlines()
        for zeros in (1, len(rows)):  # the last one, or all
            cells = [row.split(",") for row in rows]
            for row in cells[-zeros:]:
                row[1] = "0"
            trace.write_text("\n".join([head, *map(",".join, cells), ""]))
            self.draw()

    def test_full_disk_touches_no_old_result(self):
        self.solve(self.good, "--out", self.out, "--iterations", 1)
        # The disk is full from the last table on: all other files are complete, and must not appear.
        (self.out / "summary.csv").unlink()
        (self.out / "summary.csv").symlink_to("/dev/full")
        self.refuses_to_write("summary.csv: No space left on device")
        self.assertTrue(Path("/dev/full").is_char_device())

    def test_the_input_is_not_overwritten(self):
        for name in ("points.csv", "summary.csv"):
            path = self.write(name, GOOD)
            self.refuses(path, "--out", self.folder,
                         message=f"cannot write {path}: it is the input; choose another folder for the results")
            path.unlink()

    def refuses_to_write(self, what, **options):
        before = {name: (self.out / name).read_bytes() for name in RESULTS if not (self.out / name).is_symlink()}
        done = self.program(self.good, "--out", self.out, **options)
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stderr, f"ch5_bal: cannot write {self.out}/{what}\n")
        self.assertEqual({path.name for path in self.out.iterdir()}, RESULTS)
        for name, content in before.items():
            self.assertEqual((self.out / name).read_bytes(), content, name)
