"""ch5_recording, and ./course run FOLDER: what they print, write and refuse."""

import csv
import html
import json
import os
import re
import shutil
import sys
from pathlib import Path
from unittest import mock

from ch5_backend.figures import recording as figures
from ch5_backend.figures import style
from tests.experiments.programs_under_test import AppTest, contents, real, table
from tests.project import BUILD, ROOT, run

SEGMENT = ["segment", "first_s", "last_s", "frames", "ate_m", "scale_error", "yaw_error_deg"]
KEYS = ["policy", "ate_m", "scale_error", "yaw_error_deg", "realtime_factor", "p99_window_ms", "frames", "restarts",
        "rpe_m", "path_m", "drift_percent", "nees_motion", "nees_windows"]
TABLES = {f"odometry_{name}.csv" for name in
          "policies results segments path lengths consistency windows spectrum gauge warnings machine".split()}
TABLES |= {"film_blocks.csv", "film_vertices.csv", "film_frames.csv"}
# Of one line of a table: the file, its number, what becomes of it (of the line before and itself), and what is said. The others:
# tests/files/recording_file_test.cc.
DAMAGED = [
    ("imu.csv", 200, lambda before, line: line[:40], "a row of "),
    ("imu.csv", 500, lambda before, line: "9999999999" + line, "timestamp [ns]: must lie in"),
    ("tracks.csv", 300, lambda before, line: before, "the track is in this image already"),
    ("tracks.csv", 900, lambda before, line: line.rsplit(",", 2)[0] + ",367.2,248.4", "coordinates must be normalized"),
    ("groundtruth.csv", 50, lambda before, line: before, "the timestamp is repeated"),
    ("imu.csv", 1602, lambda before, line: line[:-4], "the file ends in the middle of a line"),
]
# ./course without a recording's figures, which take four times as long as following it: one test by day and others by night draw them.
UNDRAWN = (sys.executable, "-X", "utf8", "-c", """import sys
from ch5_backend.course import __main__ as entry
from ch5_backend.course.experiments import run
draws = run.figures
run.figures = lambda kind, *words: ["true"] if kind == "recording" else draws(kind, *words)
sys.exit(entry.main(sys.argv[1:]))
""")
TRAJECTORIES = {"vins.tum", "vins.csv", "okvis.tum", "okvis.csv"}


def edit(path, change) -> None:
    """Writes a table anew: change(rows) are its rows now, lists of words, but for the head."""
    head, *rows = (line.split(",") for line in path.read_text().splitlines())
    path.write_text("".join(",".join(row) + "\n" for row in [head, *change(rows)]))


def film_of(page) -> dict:
    """What the film's canvas is given."""
    return json.loads(html.unescape(re.search(r'data-film="([^"]*)"', page)[1]))


def white(figure, directory, name) -> None:
    """Stands for style.save."""
    (Path(directory) / "figures").mkdir(exist_ok=True)
    style.plt.imsave(Path(directory) / "figures" / f"{name}.png", [[1.0]])
    style.plt.close(figure)


def later(row, seconds) -> list:
    return [str(int(row[0]) + int(1e9 * seconds)), *row[1:]]


class RecordingApp(AppTest):
    app = "ch5_recording"

    def simulate(self, seconds=8, *kind):
        """A folder with some seconds of a hand-held camera, or a stereo pair, in a room, or of a circle at 2 m/s."""
        recording = self.folder / "room"
        done = run(BUILD / "tests" / "experiments" / "simulate_recording", recording, seconds, *kind)
        self.assertEqual(done.returncode, 0, done.stderr)
        return recording

    def test_recording_is_followed(self):
        recording = self.simulate()
        done = self.solve(recording, "--out", self.out)
        self.assertIn("161 images, 1601 IMU measurements, 8.0 s", done.stdout)
        self.assertLessEqual(max(map(len, done.stdout.splitlines())), 80)
        self.assertEqual(done.stderr, "", "nothing is doubtful")
        self.assertEqual({path.name for path in self.out.iterdir()}, TRAJECTORIES | {"csv"})
        self.assertEqual({path.name for path in (self.out / "csv").iterdir()}, TABLES)
        policies = table(self.out / "csv" / "odometry_policies.csv")
        self.assertEqual([row["policy"] for row in policies], ["vins", "okvis"])
        for row in policies:
            self.assertLess(float(row["ate_m"]), 0.2)
            self.assertLess(abs(float(row["scale_error"])), 0.1)
            self.assertEqual(row["restarts"], "0")
            # TUM: t x y z qx qy qz qw, times ascending, one line for each image that was answered.
            text = (self.out / f"{row['policy']}.tum").read_text()
            tum = [list(map(float, line.split())) for line in text.splitlines()]
            self.assertEqual(len(tum), int(row["frames"]))
            self.assertGreater(len(tum), 80)
            self.assertEqual([len(state) for state in tum], [8] * len(tum))
            times = [state[0] for state in tum]
            self.assertTrue(all(a < b for a, b in zip(times, times[1:])))
            for state in tum:
                self.assertAlmostEqual(sum(q * q for q in state[4:]), 1.0, places=9)
            windows = [line for line in table(self.out / "csv" / "odometry_windows.csv")
                       if line["policy"] == row["policy"]]
            self.assertEqual(len(windows), 161, "one row an image")
            for line in windows:  # what no solve has found is missing, not 0
                solved = [line[key] != "" for key in ("landmarks", "iterations", "initial_cost", "final_cost")]
                self.assertEqual(solved, [line["status"] == "tracking"] * 4)
                self.assertGreater(int(line["tracks"]), 5)
            lengths, claims = (table(self.out / "csv" / f"odometry_{name}.csv") for name in ("lengths", "consistency"))
            of = [float(line["q50"]) for line in lengths if (line["policy"], line["quantity"]) == (row["policy"], "position_m")]
            self.assertEqual(len(of), 5)
            self.assertLess(of[0], of[-1], "errors grow with the length of the path")
            nees = [float(line["nees"]) for line in claims if line["policy"] == row["policy"]]
            self.assertAlmostEqual(sum(nees) / int(row["nees_windows"]), float(row["nees_motion"]), places=6, msg="the figure's mean is the table's")
            self.assertTrue(1.0 < float(row["nees_motion"]) < 60.0, "of six numbers, with claims a few times too small at most")
            times = [float(line["milliseconds"]) for line in windows if line["status"] == "tracking"]
            self.assertGreaterEqual(sum(time <= float(row["p99_window_ms"]) for time in times), 0.99 * len(times))

    def test_course_run_gives_the_numbers_as_json(self):
        recording = self.simulate()
        result = self.course_run(recording, "--language", "zh")
        self.assertEqual([list(row) for row in result["policies"]], [[*KEYS, "results", "segments"]] * 2)
        self.assertEqual(result["warnings"], [])
        for row in result["policies"]:
            self.assertTrue(all(isinstance(row[key], (int, float)) for key in KEYS[1:]), row)
            self.assertEqual(row["results"]["time_offset_s"], {"value": None, "sigma": None}, "the clocks agree")
            segment, = row["segments"]
            self.assertEqual(list(segment), SEGMENT)
            self.assertEqual([segment[key] for key in SEGMENT[3:]],
                             [row[key] for key in ("frames", "ate_m", "scale_error", "yaw_error_deg")])
            self.assertTrue(row["ate_m"] > 0 and row["realtime_factor"] > 0 and row["p99_window_ms"] > 0, row)
            self.assertTrue(isinstance(row["frames"], int) and isinstance(row["restarts"], int), row)
        out = self.out / "room"
        for suffix in (".csv", ".tum", ".png", ".svg", ".pdf"):
            self.assertTrue(list(out.rglob("*" + suffix)), f"no {suffix} among the results")
        page = (out / "report.html").read_text(encoding="utf-8")
        self.assertEqual(result["report"], str(out / "report.zh.html"))
        self.assertTrue((out / "report.zh.html").exists(), "both are written, the user's is named")
        self.assertNotIn('src="http', page)
        self.assertIn("vins.tum", page)

        # Without the truth there is no error: an empty cell, which is null, and no number that looks like one.
        (recording / "groundtruth.csv").unlink()
        self.solve(recording, "--out", out)
        for row in table(out / "csv" / "odometry_policies.csv"):
            self.assertEqual([row[key] for key in ("ate_m", "scale_error", "yaw_error_deg")], [""] * 3)
            self.assertGreater(int(row["frames"]), 80)
        self.out = out
        figures, page = out / "figures", self.page()
        self.assertIn("There is no truth beside this recording", page)
        self.assertNotIn("nan", page)
        for name, is_drawn in (("lengths", False), ("consistency", False), ("timeline", True), ("biases", True), ("path", True)):
            self.assertEqual((figures / f"odometry_{name}.png").exists(), is_drawn, f"{name}: none of the run before is left")

    def test_a_table_of_all_recordings_leaves_out_what_is_missing(self):
        room = self.simulate()
        told, silent, broken = (self.folder / name for name in ("V1_02_medium", "no truth", "MH_03_medium"))
        for copy in (told, silent, broken):
            shutil.copytree(room, copy)
        (silent / "groundtruth.csv").unlink()
        (broken / "imu.csv").write_text("#timestamp [ns]\n")
        done = run(*UNDRAWN, "run", told, silent, broken, "--table", "--out", self.out, "--json")
        self.assertEqual(done.returncode, 2, done.stderr)
        results = json.loads(done.stdout)["results"]
        self.assertEqual([(one["problem"], one["first_estimates"], "error" in one) for one in results],
                         [(name, mode, False) for name in ("V1_02_medium", "no truth") for mode in ("none", "full")] + [("MH_03_medium", "none", True)])
        rows = table(self.out / "csv" / "recordings.csv")
        self.assertEqual([(row["policy"], row["nees_windows"]) for row in rows if row["recording"] == "no truth"], [("vins", "0"), ("okvis", "0")] * 2)
        for row in rows:
            for quantity in ("ate_m", "rpe_m", "nees_motion"):
                self.assertEqual(row[quantity] != "", row["recording"] == "V1_02_medium", "missing is empty, not 0")
            if row["nees_motion"]:  # 6, but for the outliers and the second use of observations
                self.assertTrue(2 < float(row["nees_motion"]) < 40 and int(row["nees_windows"]) > 3, row)
        for page in ("report.html", "report.zh.html"):
            text = (self.out / page).read_text(encoding="utf-8")
            for words in ('">MH_01</th><td>–</td><td>–</td>', '">MH_03_medium</th><td>–</td>', ">0.11</td>", "J Σ Jᵀ", "github.com/openxrlab/xrslam"):
                self.assertIn(words, text)
            self.assertNotIn("nan", re.sub(r'src="[^"]*"', "", text))
        done = run(ROOT / "course", "run", told, "--table", "--first-estimates", "full")
        self.assertIn("leave --first-estimates out", done.stderr)

    def test_settings_come_from_the_file_and_the_command_line_prevails(self):
        recording = self.simulate()
        calibration = recording / "calibration.yaml"
        known = calibration.read_text()
        calibration.write_text(known + "camera2:\n  model: pinhole\nestimator:\n  policy: okvis\n  seconds: 0:7\n")
        done = run(BUILD / "bin" / "ch5_recording", recording, "--out", self.out, "--policy", "vins", "--batch")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("141 images", done.stdout)
        self.assertIn("camera2.model", done.stderr)
        vins, batch = table(self.out / "csv" / "odometry_policies.csv")
        self.assertEqual((vins["policy"], batch["policy"]), ("vins", "batch"))
        self.assertEqual(vins["frames"], batch["frames"])
        self.assertLess(float(batch["ate_m"]), 0.1)
        self.assertLess(float(vins["rpe_m"]), 0.1)
        self.assertFalse((self.out / "okvis.tum").exists())
        calibration.write_text(known + "estimator:\n  polcy: vins\n")
        line = len(known.splitlines()) + 2
        done = run(BUILD / "bin" / "ch5_recording", recording, "--out", self.out)
        self.assertEqual(done.returncode, 2)
        self.assertIn(f"calibration.yaml:{line}: estimator.polcy: nothing of this name is known here", done.stderr)

    def test_a_second_camera_is_followed_unless_it_is_left_out(self):
        trajectories = {}
        for name, cameras, words in (("one", [], []), ("left out", ["stereo"], ["--mono"]), ("two", ["stereo"], [])):
            self.solve(self.simulate(6, *cameras), "--out", self.out, "--policy", "vins", *words)
            trajectories[name] = (self.out / "vins.tum").read_text()
        self.assertEqual(trajectories["one"], trajectories["left out"], "to the byte")
        first = {name: float(text.split()[0]) for name, text in trajectories.items()}
        self.assertLess(first["two"], first["one"] - 1.0, "two cameras start at rest")
        self.assertLess(float(table(self.out / "csv" / "odometry_policies.csv")[0]["ate_m"]), 0.05)

        # While it hardly moves, any scale and any yaw lay the estimate upon the truth.
        row = self.course_run(self.simulate(6, "stereo"), "--seconds", "0:1.7", course=UNDRAWN)["policies"][0]
        self.assertLess(row["ate_m"], 0.01)
        self.assertEqual([row["scale_error"], row["yaw_error_deg"]], [None, None])
        self.out /= "room"
        self.assertIn("at rest, which tells no scale", self.page())

    def test_a_gap_in_the_imu_begins_a_segment(self):
        recording = self.simulate(16)
        edit(recording / "imu.csv", lambda rows: [row for row in rows if not 5.0 < (int(row[0]) - int(rows[0][0])) / 1e9 < 7.0])
        self.out.mkdir()
        (self.out / "vins_7.tum").write_text("of an earlier run\n")
        done = self.solve(recording, "--out", self.out)
        self.assertIn("segment 1 begins at 5.0", done.stdout)
        self.assertIn("no IMU for too long", done.stdout)
        expected = {f"{policy}{end}" for policy in ("vins", "okvis") for end in (".tum", ".csv", "_1.tum", "_1.csv")}
        self.assertEqual({path.name for path in self.out.iterdir()}, expected | {"csv"})
        segments = table(self.out / "csv" / "odometry_segments.csv")
        self.assertEqual([(row["policy"], row["segment"]) for row in segments],
                         [("vins", "0"), ("vins", "1"), ("okvis", "0"), ("okvis", "1")])
        for row in segments:
            end = "" if row["segment"] == "0" else "_1"
            self.assertEqual(len((self.out / f"{row['policy']}{end}.tum").read_text().splitlines()), int(row["frames"]))
            self.assertLess(float(row["ate_m"]), 0.2)
        for row in table(self.out / "csv" / "odometry_policies.csv"):
            self.assertLess(float(row["ate_m"]), 0.2, "with one alignment over both it is a meter")
            self.assertEqual(row["restarts"], "1")
        page = self.page()
        self.assertIn("Each restart begins a segment", page)
        self.assertRegex(page, r"Restarts a, no IMU for too long: VINS (\d\.\d); OKVIS \1\ss\.", "one reason, said once")
        self.assertIn("vins_1.tum", page)
        self.assertNotIn("found no start", page)
        self.assertEqual(set(film_of(page)["shots"]), {"vins", "okvis"})

    def test_clocks_that_jump_together_begin_a_segment(self):
        """Set by years, or back by an hour, or after a pause: both parts are followed, and files keep the stamps."""
        recording = self.simulate(16)
        names = ("imu.csv", "tracks.csv", "groundtruth.csv")
        for name in names:
            edit(recording / name, lambda rows: [later(row, 1e9) for row in rows])
        tables = {name: (recording / name).read_text() for name in names}
        first = int(tables["imu.csv"].splitlines()[1].split(",")[0])
        for hours, words in ((200000, ()), (-1, ("--policy", "vins"))):
            for name, text in tables.items():
                (recording / name).write_text(text)
                edit(recording / name, lambda rows: [later(row, 3600 * hours * (int(row[0]) > first + 8e9)) for row in rows])
            done = self.program(recording, "--out", self.out, *words)
            self.assertIn(f"imu.csv:1603: at 9.0 s all clocks jump by {3600 * hours} s", done.stderr)
            warnings = table(self.out / "csv" / "odometry_warnings.csv")
            self.assertEqual([row["warning"] for row in warnings], ["clock_jump"])
            for row in table(self.out / "csv" / "odometry_policies.csv"):
                self.assertEqual(row["restarts"], "1")
                self.assertGreater(int(row["frames"]), 200)
                self.assertLess(float(row["ate_m"]), 0.2)
            stamps = {row.split(",")[0] for row in (recording / "tracks.csv").read_text().splitlines()}
            segment = (self.out / "vins_1.csv").read_text().splitlines()[1:]
            self.assertLessEqual({row.split(",")[0] for row in segment}, stamps)
        (recording / "groundtruth.csv").write_text(tables["groundtruth.csv"])
        self.assertIn("its clock does not jump with the others", self.program(recording, "--out", self.out, "--policy", "vins").stderr)
        edit(recording / "tracks.csv", lambda rows: [later(row, -3600 * (int(row[0]) > first + 8.1e9)) for row in rows])
        done = self.program(recording, "--out", self.out)  # now the IMU's alone: what comes before is followed
        self.assertEqual([row["restarts"] for row in table(self.out / "csv" / "odometry_policies.csv")], ["1", "1"], done.stderr)

    def test_a_truth_of_another_time_is_named(self):
        recording = self.simulate()
        edit(recording / "groundtruth.csv", lambda rows: [later(row, 3600) for row in rows])
        done = self.program(recording, "--out", self.out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("no estimate was compared with groundtruth.csv: its 1601 poses are from 3600.00 to 3608.00 s, the images "
                      "from 0.00 to 8.00 s", done.stderr)

    def test_a_truth_of_distant_poses_another_unit_or_another_clock_is_named(self):
        recording = self.simulate()
        truth = recording / "groundtruth.csv"
        whole = truth.read_text()
        in_millimeters = lambda row: [row[0], *(str(1000 * float(x)) for x in row[1:4]), *row[4:]]
        for change, name, words in (
                (lambda rows: [later(row, 0.2) for row in rows], "truth_late", "0 ms too late for the IMU, which explains most of the error"),
                (lambda rows: [later(row, 1.4) for row in rows], "truth_late", " ms too late for the IMU, which explains most of the error"),
                (lambda rows: [[*row[:2], row[3], row[2], *row[4:]] for row in rows], "truth_axes", "if they are read as x, z, y: its world must have z up"),
                (lambda rows: [[*row[:5], *(str(-float(x)) for x in row[5:8]), *row[8:]] for row in rows], "truth_inverse", "only if they are inverted"),
                (lambda rows: rows[::150], "distant_truth", "the poses of groundtruth.csv are 0.75 s apart (median)"),
                (lambda rows: map(in_millimeters, rows), "truth_unit", " times as far as vins estimates; is it in meters?")):
            truth.write_text(whole)
            edit(truth, change)
            done = self.program(recording, "--out", self.out, "--policy", "vins")
            self.assertIn(words, done.stderr)
            self.assertEqual([row["warning"] for row in table(self.out / "csv" / "odometry_warnings.csv")], [name])
        self.assertRegex(self.page(), "Warning \\d: </strong>The truth moves (9|10)\\d\\d times as far")

    def test_a_truth_of_another_size_and_shape_is_not_called_one_of_another_unit(self):
        recording = self.simulate()
        edit(recording / "groundtruth.csv", lambda rows: [[row[0], *(str(1e-3 * float(x)) for x in other[1:4]), *row[4:]]
                                                          for row, other in zip(rows, rows[::-1])])
        done = self.program(recording, "--out", self.out, "--policy", "vins")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("is it in meters?", done.stderr)

    def test_a_wrong_focal_length_is_corrected_unless_the_user_keeps_it(self):
        recording = self.simulate(12)
        edit(recording / "tracks.csv", lambda rows: [[*row[:2], *(repr(0.8 * float(x)) for x in row[2:])] for row in rows])
        for words, said in (((), "the focal length multiplied by this factor (corrected)"), (("--keep-focal-length",), "is the focal length right?")):
            done = self.program(recording, "--out", self.out, "--policy", "vins", *words)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(said, done.stderr)

    def test_a_clock_that_is_late_and_an_inverted_extrinsic_are_named(self):
        recording = self.simulate(12)
        calibration = recording / "calibration.yaml"
        known = calibration.read_text()
        edit(recording / "tracks.csv", lambda rows: [later(row, 0.1) for row in rows])
        done = self.program(recording, "--out", self.out, "--policy", "vins")
        late = r"the camera's stamps are (\d+) ± \d+ ms late \(corrected\)"
        self.assertRegex(done.stderr, late)
        self.assertAlmostEqual(float(re.search(late, done.stderr)[1]), 100, delta=3)
        self.assertIn("<p><strong>Warning 1: </strong>The camera&#39;s stamps are " + re.search(late, done.stderr)[1], self.page())
        self.assertIn("<p><strong>警告 1：</strong>相机的时间戳晚了 " + re.search(late, done.stderr)[1],
                      (self.out / "report.zh.html").read_text(encoding="utf-8").replace("\u00a0", " "))
        ate = float(table(self.out / "csv" / "odometry_policies.csv")[0]["ate_m"])
        done = self.program(recording, "--out", self.out, "--policy", "vins", "--estimate-time-offset")
        self.assertNotIn("warning", done.stderr)
        self.assertAlmostEqual(float(re.search(r"images are taken (.*) ms earlier than stamped", done.stdout)[1]), 100, delta=10)
        self.assertLess(ate, 1.5 * float(table(self.out / "csv" / "odometry_policies.csv")[0]["ate_m"]))
        calibration.write_text(re.sub(r"(q_B_C: .*)", lambda q: re.sub(r"([xyz]): (-?)", lambda axis: axis[1] + ": " + ("" if axis[2] else "-"), q[1]), known))
        done = self.program(recording, "--out", self.out, "--policy", "vins")
        self.assertRegex(done.stderr, r"\(correlation 0\.\d+\); it is 0\.9\d with the inverse of camera\.q_B_C, which must rotate camera")

    def test_what_is_estimated_beside_the_path_is_told_and_files_keep_the_images_stamps(self):
        recording = self.simulate(12)
        edit(recording / "tracks.csv", lambda rows: [later(row, 0.1) for row in rows])
        answer = self.course_run(recording, "--policy", "vins", "--estimate-extrinsic", course=UNDRAWN)
        self.assertRegex(answer["version"], r"^\d+\.\d+\.\d+$")
        row, = answer["policies"]
        results = row["results"]
        self.assertAlmostEqual(results["time_offset_s"]["value"], -0.1, delta=0.003)
        self.assertTrue(0.0002 < results["time_offset_s"]["sigma"] < 0.003, results)
        self.assertTrue(1.5 < results["first_pose_s"]["value"] < 3.0, results)
        self.assertAlmostEqual(results["estimated_path_m"]["value"] / row["path_m"], 1.0, delta=0.2)
        moved = [results[f"extrinsic_moved_{axis}_{unit}"] for unit in ("m", "deg") for axis in "xyz"]
        for one in moved:  # what the file says is true
            self.assertLess(abs(one["value"]), 5.0 * one["sigma"] + 1e-3, moved)
        images = {row[0] for row in csv.reader((recording / "tracks.csv").read_text().splitlines()[1:])}
        stamps = [line.split()[0].replace(".", "") for line in (self.out / "room" / "vins.tum").read_text().splitlines()]
        self.assertEqual(set(stamps) - images, set(), "the images' own stamps")
        self.assertEqual(len(stamps), row["frames"])

    def test_readings_at_a_limit_or_that_cannot_be_are_named(self):
        recording = self.simulate(6)
        imu = recording / "imu.csv"
        edit(imu, lambda rows: [[row[0], *6 * ["0"]] if 700 <= k < 710 else [*row[:2], "-4.36", *row[3:]] if k in range(310, 910, 100) else row
                                for k, row in enumerate(rows)])
        done = self.program(recording, "--out", self.out, "--strict")
        self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (2, "", 1))
        self.assertIn(f"ch5_recording: {imu}:702: at 3.500 s, w = 0.000 0.000 0.000, a = 0.000 0.000 0.000: IMU readings that cannot be: ", done.stderr)
        warnings = {row["warning"]: row for row in self.course_run(recording, course=UNDRAWN)["warnings"]}
        stuck, rail = warnings["imu_stuck"], warnings["gyroscope_rail"]
        self.assertEqual((stuck["value"], stuck["other"]), (10, 3.5))
        self.assertTrue(stuck["detail"].startswith(f"{imu}:702: at 3.500 s"), stuck["detail"])
        self.assertEqual(rail["detail"], "y")
        self.assertIn("the gyroscope is at its limit on axis y in 6 readings, ±4.36 rad/s", rail["words"])
        self.out /= "room"
        page = self.page().replace("\u00a0", " ")
        self.assertIn("IMU readings left out: 10, because", page)
        self.assertIn("The gyroscope is at its limit on axis y in 6 readings, ±4.36 rad/s.", page)
        self.assertIn("略去了 10 个 IMU 读数", (self.out / "report.zh.html").read_text(encoding="utf-8").replace("\u00a0", " "))

    def test_a_scale_that_is_hardly_known_is_named(self):
        done = self.program(self.simulate(12, "circle"), "--out", self.out)
        self.assertRegex(done.stderr, r"warning: just after the estimator started \(at \d\.\d\d s\) it knew the scale only to ±[78] %")
        self.assertRegex(self.page().replace("\u00a0", " "), r"it knew the scale only to ±[78] %")
        self.assertIn("尺度的不确定度仍有", (self.out / "report.zh.html").read_text(encoding="utf-8"))

    def test_windows_that_disagree_are_named(self):
        recording = self.simulate(12)
        edit(recording / "tracks.csv", lambda rows: [[*row[:2], str(float(row[2]) + 0.1), *row[3:]] for row in rows])  # the principal point
        done = self.program(recording, "--out", self.out)
        self.assertRegex(done.stderr, r"warning: the paths of okvis and vins through the same images are 0\.\d\d and 0\.\d\d m large")
        self.assertIn("at least one is wrong", self.page())
        self.assertIn("至少有一条是错的", (self.out / "report.zh.html").read_text(encoding="utf-8"))

    def test_another_lens_and_an_inverted_accelerometer_are_named(self):
        recording = self.simulate(12)
        (recording / "groundtruth.csv").unlink()  # with it the reader names the accelerometer at once
        tracks, imu = recording / "tracks.csv", recording / "imu.csv"
        for path, change, words, name in (
                (tracks, lambda x, y: (x * (1 - 0.28 * (x * x + y * y)), y * (1 - 0.28 * (x * x + y * y))),
                 r"times better if their points are moved by 1 \+ k r², k = 0\.[3-5]\d: does the lens model", "lens"),
                (imu, lambda *rates_forces: (*rates_forces[:3], *(-force for force in rates_forces[3:])),
                 r"of 12 windows [01] start in motion, and \d+ if its columns are read as -x, -y, -z; at rest", "force"),
                (imu, lambda *rates_forces: (*rates_forces[:5], -rates_forces[5]),
                 r"of 12 windows \d start in motion, and \d+ if its columns are read as x, y, -z; at rest", "force")):
            whole = path.read_text()
            kept = 2 if path == tracks else 1
            edit(path, lambda rows: [[*row[:kept], *map(str, change(*map(float, row[kept:])))] for row in rows])
            done = self.program(recording, "--out", self.out, "--policy", "vins")
            self.assertRegex(done.stderr, words)
            self.assertEqual(done.stderr.count("warning"), 1, done.stderr)
            if done.returncode == 0:
                self.assertEqual([row["warning"] for row in table(self.out / "csv" / "odometry_warnings.csv")], [name])
                self.assertIn("Warning 1: ", self.page())
            path.write_text(whole)

    def test_images_far_apart_are_followed_or_said_to_be_too_far(self):
        for whole, every, warned in ((whole, *case) for whole in real("euroc_v1_01_easy", self.simulate(30)) for case in ((10, False), (20, True))):
            recording = self.folder / f"{whole.name}_every_{every}"
            shutil.copytree(whole, recording)
            times = sorted({row["#timestamp [ns]"] for row in table(whole / "tracks.csv")}, key=int)[::every]
            edit(recording / "tracks.csv", lambda rows: [row for row in rows if row[0] in times])
            done = run(BUILD / "bin" / "ch5_recording", recording, "--out", self.out)
            self.assertEqual(done.returncode, 0)
            self.assertEqual("the images are 1.00 s apart" in done.stderr, warned, done.stderr)
            if warned:
                continue
            for row in table(self.out / "csv" / "odometry_policies.csv"):
                self.assertEqual(row["restarts"], "0", row["policy"])
                self.assertLess(float(row["ate_m"]), 0.15, row["policy"])

    def page(self) -> str:
        """Of the results, without its pictures, which are drawn by night."""
        if "CH5_LONG" in os.environ:
            self.draw()
        else:
            with mock.patch.object(style, "save", white):
                figures.draw(self.out)
        return re.sub(r'src="[^"]*"', "", (self.out / "report.html").read_text(encoding="utf-8"))

    def silence(self, policy):
        """Makes of the tables what a run leaves in which this policy has found no start."""
        silent = {"odometry_policies": lambda row: [[row[0], *4 * [""], row[5], "", "", "0", "0", "", "", "", "", "0"]],
                  "odometry_windows": lambda row: [[*row[:3], "starting", *row[4:]]]}
        for path in (self.out / "csv").iterdir():
            change = silent.get(path.stem, lambda row: [])
            edit(path, lambda rows: [new for row in rows for new in (change(row) if row[0] == policy else [row])])
        (self.out / f"{policy}.tum").write_text("")

    def test_a_policy_that_never_starts_is_drawn_as_such(self):
        self.solve(self.simulate(), "--out", self.out)
        self.silence("okvis")
        page = self.page()
        self.assertIn("OKVIS found no start in this recording", page)
        self.assertNotIn(">OKVIS</th><td>0", page)
        self.assertRegex(page, r"VINS \d+ times real time")
        self.assertNotIn("nan", page)
        self.assertEqual(film_of(page)["names"], {"vins": "VINS"})
        # The other one has started, but too late for a prior.
        for name in ("odometry_spectrum", "odometry_gauge", "film_blocks", "film_vertices", "film_frames"):
            edit(self.out / "csv" / f"{name}.csv", lambda rows: [])
        page = self.page()
        self.assertNotIn("prior should", page)
        self.assertNotIn("<canvas", page)

    def test_faulty_recordings_are_named_and_nothing_is_lost(self):
        recording = self.simulate()
        self.out.mkdir()
        (self.out / "vins.tum").write_text("of an earlier run\n")
        imu, tracks = recording / "imu.csv", recording / "tracks.csv"
        whole_imu = imu.read_text()
        edit(imu, lambda rows: [*rows[:4], [rows[4][0], *"0,0,zero,0,0,9.8".split(",")], *rows[5:]])  # the others: tests/files/recording_file_test.cc
        before = contents(self.folder)
        done = self.program(recording, "--out", self.out, "--strict")
        self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (2, "", 1))
        self.assertIn(f'ch5_recording: {imu}:6: w_z: not a number, got "zero"', done.stderr)
        self.assertEqual(contents(self.folder), before)
        imu.write_text(whole_imu)
        whole_tracks = tracks.read_text()
        tracks.write_text("".join(whole_tracks.splitlines(keepends=True)[:200]))  # a fraction of a second
        before = contents(self.folder)
        done = self.program(recording, "--out", self.out)
        self.assertEqual(done.returncode, 2)
        self.assertIn("no image was answered", done.stderr)
        self.assertEqual(contents(self.folder), before)
        for program in (self.program, lambda *words: run(ROOT / "course", "run", *words)):
            self.assertEqual(program(recording, "--out", self.folder / "new" / "out").returncode, 2)
            self.assertFalse((self.folder / "new").exists(), "no empty folder is left")
        for lines, words, where in ((2, (), ""), (None, ("--seconds", "0:0.01"), " lie in the seconds asked for")):
            tracks.write_text("".join(whole_tracks.splitlines(keepends=True)[:lines]))
            done = self.program(recording, "--out", self.out, *words)
            self.assertIn(f"fewer than two images or IMU measurements{where}\n", done.stderr)
        tracks.unlink()
        done = self.program(recording, "--out", self.out)
        self.assertEqual(done.returncode, 2)
        self.assertIn(str(tracks), done.stderr)

    def test_a_damaged_line_does_not_cost_the_recording(self):
        recording = self.simulate()
        self.solve(recording, "--out", self.out)
        ate = [float(row["ate_m"]) for row in table(self.out / "csv" / "odometry_policies.csv")]
        whole = {file: (recording / file).read_text() for file, *_ in DAMAGED}
        damaged = {file: text.split("\n") for file, text in whole.items()}
        for file, number, change, words in DAMAGED:
            lines = whole[file].split("\n")
            new = change(lines[number - 2], lines[number - 1])
            damaged[file][number - 1] = lines[number - 1] = new
            last = len(lines) - (number == len(lines) - 1)  # a line that is cut has no end
            (recording / file).write_text("\n".join(lines[:last]))
            done = self.program(recording, "--out", self.out, "--strict")
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(f"{file}:{number}: {words}", done.stderr)
            (recording / file).write_text(whole[file])
        for file, lines in damaged.items():
            (recording / file).write_text("\n".join(lines[:-1] if file == "imu.csv" else lines))
        result = self.course_run(recording, course=UNDRAWN)
        counts = {file: sum(one[0] == file for one in DAMAGED) for file in damaged}
        self.assertEqual([(row["warning"], row["value"], row["other"]) for row in result["warnings"]], [("left_out", count, None) for count in counts.values()])
        for row, (file, count) in zip(result["warnings"], counts.items()):
            self.assertIn(f"{recording / file}: lines left out: {count}, the first: {recording / file}:", row["words"])
        self.out /= "room"
        self.assertIn("Lines or images left out of a file: 3; the first: ", self.page().replace("\u00a0", " "))
        for row, before in zip(result["policies"], ate):
            self.assertLess(row["ate_m"], 1.2 * before + 0.01)

        # More than one line in twenty is no damage.
        edit(recording / "imu.csv", lambda rows: [row[:3] if k % 15 == 0 else row for k, row in enumerate(rows)])
        done = self.program(recording, "--out", self.out)
        self.assertEqual(done.returncode, 2)
        self.assertIn("imu.csv:2: a row of 3 columns", done.stderr)

    def test_a_drone_is_followed_from_its_raw_start(self):
        for recording in real("euroc_v1_01_easy", self.simulate(20)):
            self.program(recording, "--out", self.out)
            rows = table(self.out / "csv" / "odometry_policies.csv")
            self.assertEqual([row["policy"] for row in rows], ["vins", "okvis"])
            for row in rows:
                self.assertLessEqual(float(row["ate_m"]), 0.10)
                self.assertLessEqual(abs(float(row["scale_error"])), 0.02)
                self.assertEqual(row["restarts"], "0")
