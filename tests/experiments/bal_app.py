"""ch5_bal as its users see it: results, exit codes, messages, and old results that no failure touches."""

import csv
import os
import resource
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

APP = os.environ["CH5_BAL"]
PLOT = "ch5_backend.figures.bal"

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
RESULTS = {"good-result.txt", "good-before.ply", "good-after.ply", "summary.csv", "trace.csv", "points.csv",
           "cameras.csv"}


def app(*words, **options):
    return subprocess.run([APP, *map(str, words)], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=120, **options)


class BalApp(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.out = self.folder / "out"
        self.good = self.write("good.txt", GOOD)

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def refuses(self, *words, message, **options):
        """Exit 2, exactly this message on standard error, no file but the old ones."""
        before = self.snapshot()
        done = app(*words, **options)
        self.assertEqual(done.returncode, 2, done)
        self.assertEqual(done.stderr, f"ch5_bal: {message}\n")
        self.assertEqual(self.snapshot(), before)

    def snapshot(self):
        return {path: path.read_bytes() for path in self.folder.rglob("*") if path.is_file()}

    def test_good_file_is_solved(self):
        done = app(self.good, "--out", self.out)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual({path.name for path in self.out.iterdir()}, RESULTS)
        with open(self.out / "summary.csv", newline="") as file:
            summary = dict(csv.reader(file))
        self.assertEqual((summary["problem"], summary["cameras"], summary["points"], summary["observations"]),
                         ("good", "2", "3", "6"))
        self.assertLess(float(summary["final_cost"]), float(summary["initial_cost"]))
        self.assertIn("converged", summary["termination"])
        with open(self.out / "trace.csv", newline="") as file:
            trace = list(csv.DictReader(file))
        self.assertEqual(int(trace[-1]["iteration"]), int(summary["iterations"]))
        self.assertEqual(trace[-1]["cost"], summary["final_cost"])
        self.assertIn(f"{float(summary['final_cost']):.6e}", done.stdout)
        # The result is a problem whose first cost is the cost that was reached.
        again = app(self.out / "good-result.txt", "--out", self.folder / "again", "--iterations", 0)
        self.assertIn(f"cost {float(summary['final_cost']):.6e} -> {float(summary['final_cost']):.6e}", again.stdout)

    def test_too_few_iterations_are_no_error(self):
        done = app(self.good, "--out", self.out, "--iterations", 1)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("maximum of iterations", done.stdout)

    def test_result_does_not_depend_on_threads(self):
        for threads in (1, 2, 3):
            self.assertEqual(app(self.good, "--out", self.folder / str(threads), "--threads", threads).returncode, 0)
        results = {(self.folder / str(threads) / "good-result.txt").read_bytes() for threads in (1, 2, 3)}
        self.assertEqual(len(results), 1)

    def test_picture_is_drawn_and_the_same_twice(self):
        self.assertEqual(app(self.good, "--out", self.out).returncode, 0)

        def draw():
            done = subprocess.run([sys.executable, "-m", PLOT, self.out], capture_output=True, text=True, timeout=120)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            return {path.name: path.read_bytes() for path in (self.out / "figures").iterdir()}
        first = draw()
        self.assertEqual(set(first), {"before_after.png", "before_after.svg"})
        self.assertEqual(draw(), first)
        (self.out / "points.csv").write_text("x_before\n")
        done = subprocess.run([sys.executable, "-m", PLOT, self.out], capture_output=True, text=True, timeout=120)
        self.assertEqual((done.returncode, done.stderr), (2, f"bal.py: {self.out}/points.csv: no rows\n"))

    def test_help(self):
        done = app("--help")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        for option in ("--out", "--iterations", "--threads", "--huber", "--solver"):
            self.assertIn(option, done.stdout)

    def test_arguments_that_make_no_sense(self):
        def refuses(*words, message):
            self.refuses(*words, message=message + "; see --help")
        refuses(message="which FILE?")
        refuses(self.good, message="--out is missing")
        refuses(self.good, "--out", message="--out needs a value")
        refuses(self.good, self.good, "--out", self.out,
                message=f"one FILE at a time, got '{self.good}' and '{self.good}'")
        refuses(self.good, "--out", self.out, "--fast", message="unknown option '--fast'")
        refuses(self.good, "--out", self.out, "-v", message="unknown option '-v'")
        for word in ("-1", "1.5", "1e3", "many", "", "99999999999"):
            refuses(self.good, "--out", self.out, "--iterations", word,
                    message=f"--iterations must be a whole number from 0 to 1000000, got '{word}'")
        refuses(self.good, "--out", self.out, "--threads", "0",
                message="--threads must be a whole number from 1 to 256, got '0'")
        for word in ("0", "-2", "nan", "inf", "1e300", "1px"):
            refuses(self.good, "--out", self.out, "--huber", word,
                    message=f"--huber must be a number from 1e-06 to 1e+06, got '{word}'")
        refuses(self.good, "--out", self.out, "--solver", "magic", message="--solver must be one of automatic, dense, "
                "sparse, pcg, implicit-pcg, power-series, got 'magic'")
        self.assertFalse(self.out.exists())

    def test_every_solver_finds_the_same_optimum(self):
        costs = []
        for solver in ("automatic", "dense", "sparse", "pcg", "implicit-pcg", "power-series"):
            done = app(self.good, "--out", self.folder / solver, "--solver", solver, "--iterations", 100)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            with open(self.folder / solver / "summary.csv", newline="") as file:
                costs.append(float(dict(csv.reader(file))["final_cost"]))
        self.assertLess(max(costs) - min(costs), 1e-3, costs)

    def test_faulty_files_are_named_with_line_and_value(self):
        def refuses(text, message):
            path = self.write("bad.txt", text)
            self.refuses(path, "--out", self.out, message=f"{path}:{message}")
            self.assertFalse(self.out.exists())
        refuses("", "1: number of cameras: the file ends where a number is expected")
        refuses(GOOD[:-4], "12: point 2, z: the file ends where a number is expected")
        refuses(GOOD.replace("0 1 -25", "0 7 -25"), '4: observation 2, point: must lie in [0, 2], got "7"')
        refuses(GOOD.replace("2 3 6", "-2 3 6"), '1: number of cameras: must lie in [1, 2147483647], got "-2"')
        refuses(GOOD.replace("-75", "nan"), '5: observation 3, x: not finite, got "nan"')
        refuses(GOOD.replace("500", "1e300"), '8: camera 0, f: absurdly large (beyond 1e15), got "1e300"')
        refuses(GOOD + "7\n", '13: text after the end of the data, got "7"')
        refuses(GOOD.replace("1 0 -25", "0 0 -25"),
                "3: observation 1 is repeated: camera 0 saw point 0 in line 2 already")
        missing = self.folder / "missing.txt"
        self.refuses(missing, "--out", self.out, message=f"{missing}: cannot be read: No such file or directory")

    def test_a_pipe_that_nobody_writes_into_is_refused(self):
        pipe = self.folder / "pipe.txt"
        os.mkfifo(pipe)
        done = app(pipe, "--out", self.out)
        self.assertEqual((done.returncode, done.stderr),
                         (2, f"ch5_bal: {pipe}: cannot be read: it is not a regular file\n"))

    def test_a_cost_of_zero_is_drawn_without_a_warning(self):
        self.assertEqual(app(self.good, "--out", self.out).returncode, 0)
        trace = self.out / "trace.csv"
        head, *rows = trace.read_text().splitlines()
        for zeros in (1, len(rows)):  # the last one, or all
            cells = [row.split(",") for row in rows]
            for row in cells[-zeros:]:
                row[1] = "0"
            trace.write_text("\n".join([head, *map(",".join, cells), ""]))
            done = subprocess.run([sys.executable, "-m", PLOT, self.out], capture_output=True, text=True, timeout=120)
            self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_point_in_a_cameras_plane(self):
        path = self.write("plane.txt", GOOD.replace("0.25 0.5 0\n", "0.25 0.5 5\n", 1))
        self.refuses(path, "--out", self.out, message=f"{path}: observation 0: point 0 cannot be projected into "
                                                      "camera 0: the residual is not finite")

    def test_out_that_cannot_be_a_folder(self):
        file = self.write("file", "mine")
        self.refuses(self.good, "--out", file, message=f"cannot write {file}: Not a directory")

    def test_full_disk_touches_no_old_result(self):
        self.assertEqual(app(self.good, "--out", self.out, "--iterations", 1).returncode, 0)
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

    def test_file_size_limit_touches_no_old_result(self):
        self.assertEqual(app(self.good, "--out", self.out, "--iterations", 1).returncode, 0)
        self.refuses_to_write("good-result.txt: File too large", restore_signals=False,
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100)))

    def refuses_to_write(self, what, **options):
        before = {name: (self.out / name).read_bytes() for name in RESULTS if not (self.out / name).is_symlink()}
        done = app(self.good, "--out", self.out, **options)
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stderr, f"ch5_bal: cannot write {self.out}/{what}\n")
        self.assertEqual({path.name for path in self.out.iterdir()}, RESULTS)
        for name, content in before.items():
            self.assertEqual((self.out / name).read_bytes(), content, name)

    def test_standard_output_on_a_full_disk(self):
        with open("/dev/full", "w") as full:
            done = subprocess.run([APP, self.good, "--out", self.out], stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual((done.returncode, done.stderr), (2, "ch5_bal: cannot write to standard output\n"))
