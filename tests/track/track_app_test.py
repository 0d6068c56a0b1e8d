"""ch5_track, ./course track and ./course run on a folder in EuRoC's layout: what they write, and what they say of broken ones."""

import json
import re
import shutil
import tempfile
import unittest
from pathlib import Path

import numpy as np

from tests.experiments.programs_under_test import AppTest, real, table
from tests.project import BUILD, ROOT, run

MOTION = "imu0/data.csv"
SENSOR = "cam0/sensor.yaml"
IMAGES = "cam0/data.csv"
TRUTH = "state_groundtruth_estimate0/data.csv"


def edit(file: str, change):
    """A change of a text file below mav0."""
    def apply(mav0: Path):
        path = mav0 / file
        path.write_bytes(change(path.read_bytes().decode("utf-8")).encode("utf-8"))
    return apply


def replace(file: str, pattern: str, words: str):
    def change(text: str) -> str:
        changed, count = re.subn(pattern, words, text, flags=re.MULTILINE)
        assert count, f"nothing to change in {file}"
        return changed
    return edit(file, change)


def on_line(file: str, number: int, change):
    """A change of one line, from 1."""
    def change_text(text: str) -> str:
        lines = text.split("\n")
        lines[number - 1] = change(lines[number - 1])
        return "\n".join(lines)
    return edit(file, change_text)


def image(mav0: Path, index: int) -> Path:
    return sorted((mav0 / "cam0" / "data").iterdir())[index]


def cut(mav0: Path) -> None:
    path = image(mav0, 3)
    path.write_bytes(path.read_bytes()[:20000])


def other_size(mav0: Path) -> None:
    replace(SENSOR, r"resolution: .*", "resolution: [640, 480]")(mav0)


def late_camera(mav0: Path) -> None:
    """The camera's clock counts from another day: names of files and the table agree."""
    replace(IMAGES, r"^15", "16")(mav0)
    for path in list((mav0 / "cam0" / "data").iterdir()):
        path.rename(path.with_name("16" + path.name[2:]))


def swap_vectors(line: str) -> str:
    cells = line.split(",")
    return ",".join(cells[:1] + cells[4:7] + cells[1:4]) if len(cells) == 7 and not line.startswith("#") else line


def swap_vectors_everywhere(text: str) -> str:
    return "\n".join(map(swap_vectors, text.split("\n")))


def scaled(text: str, w: float, a: float, head=lambda line: line) -> str:
    """imu0's table with so many times the rates and accelerations."""
    first, *rows = text.strip().split("\n")
    cells = [row.split(",") for row in rows]
    factors = [w] * 3 + [a] * 3
    return "\n".join([head(first), *(",".join([row[0], *(repr(k * float(cell)) for k, cell in zip(factors, row[1:]))]) for row in cells)]) + "\n"


# What is done to the folder, and the sentence; FOLDER stands for mav0, STAMP for any time stamp. In the file beside: by what a pattern
# in sensor.yaml is replaced.
BROKEN = {
    "no IMU table": (lambda mav0: (mav0 / MOTION).unlink(),
                     r"FOLDER/imu0/data\.csv: cannot be read: No such file or directory"),
    "no image file": (lambda mav0: image(mav0, 3).unlink(),
                      r"FOLDER/cam0/data\.csv:5: there is no image FOLDER/cam0/data/STAMP\.png"),
    "an image that is cut": (cut, r"FOLDER/cam0/data/STAMP\.png: cannot be read as PNG; is it cut or damaged\? .+"),
    "a camera's clock of another day": (
        late_camera, r"FOLDER/cam0/data\.csv: the clocks of camera and IMU differ: no image lies within the IMU's time; the "
        r"images are from 1\d+\.00 s to 1\d+\.00 s after its first measurement, its last is at 1\.00 s"),
    "swapped columns": (
        edit(MOTION, swap_vectors_everywhere), r"FOLDER/imu0/data\.csv:\d+: the accelerations are 0\.\d+ m/s² long \(median\), where "
        r"gravity alone is 9\.81: are they swapped with the rates, in another unit, or without gravity\?"),
    "rates in degrees": (edit(MOTION, lambda text: scaled(text, 3e4, 1.0)), r"FOLDER/imu0/data\.csv:\d+: the rates are up to "
                         r"\d+\.?\d* rad/s .*: are they in degrees\? Then call their columns w_x \[deg/s\] and so on"),
    "VINS-Mono's configuration as sensor.yaml": (
        edit(SENSOR, lambda text: '%YAML:1.0\nimu_topic: "/imu0"\nmodel_type: PINHOLE\n'), r"FOLDER/cam0/sensor\.yaml: configurations, such as "
        r"VINS-Mono's, are not read: ch5_backend/GUIDE\.md has a sensor\.yaml to fill in"),
    "no header": (edit(MOTION, lambda text: text.split("\n", 1)[1]),
                  r"FOLDER/imu0/data\.csv:1: the first line must name the columns and begin with \"#timestamp \[ns\]\", got .+"),
    "a NaN": (on_line(MOTION, 7, lambda line: re.sub(r",[^,]*$", ",nan", line)),
                              r"FOLDER/imu0/data\.csv:7: a_z: not finite, got \"nan\""),
    "a row that is cut": (on_line(MOTION, 9, lambda line: line.rsplit(",", 2)[0]),
                          r"FOLDER/imu0/data\.csv:9: a row of 5 columns, but the first line names 7, got .+"),
    "a time that goes backwards": (on_line(MOTION, 9, lambda line: "14" + line[2:]),
                                   r"FOLDER/imu0/data\.csv:9: the timestamp goes backwards, got 14\d+ after 15\d+"),
    "a truth without a pose": (
        edit(TRUTH, lambda text: text.split("\n")[0] + "\n"), r"FOLDER/state_groundtruth_estimate0/data\.csv:2: at least one pose is "
        r"needed; where the truth is not known, remove the file"),
    "an image of another kind": (lambda mav0: image(mav0, 3).write_bytes(b"GIF89a and more" + bytes(99)),
                                 r"FOLDER/cam0/data/STAMP\.png: this is no PNG, JPEG or binary PGM image; convert all of them, .+"),
    "images of another size": (
        other_size, r"FOLDER/cam0/data/STAMP\.png: an image of 752 × 480 pixels, but its calibration says 640 × 480"),
    **{name: (replace(SENSOR, *change), sentence) for name, (*change, sentence) in
       json.loads(Path(__file__).with_name("broken_calibrations.json").read_text(encoding="utf-8")).items()},
}


def with_returns(mav0: Path) -> None:
    for path in [*mav0.rglob("*.csv"), *mav0.rglob("*.yaml")]:
        path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n") + b"\r\n")


def other_headers(mav0: Path) -> None:
    on_line(MOTION, 1, lambda line: "timestamp,w_x,w_y,w_z,a_x,a_y,a_z")(mav0)
    on_line(IMAGES, 1, lambda line: "# timestamp [ns], filename")(mav0)


# What is done to the folder, which remains the same recording.
HARMLESS = {
    "ends of lines as Windows has them, and blank lines": with_returns,
    "other names of columns": other_headers,
    "columns in another order, with their names": edit(
        MOTION, lambda text: "\n".join(swap_vectors(line.replace("#", "")) for line in text.split("\n"))),
    "no newline at the end": edit(MOTION, lambda text: text.rstrip("\n")),
    "a comma at the end of each row": edit(MOTION, lambda text: re.sub(r"(\d)$", r"\1,", text, flags=re.MULTILINE)),
    "OpenCV's five coefficients": lambda mav0: [
        replace(SENSOR, "radial-tangential", "plumb_bob")(mav0), replace(SENSOR, r"(distortion_coefficients: .*)\]", r"\1, 0.0]")(mav0)],
    "a list over several lines, with comments": replace(SENSOR, r"^intrinsics: \[(.*?),(.*)\].*", r"intrinsics: [\1,  # fu\n  \2]"),
}


def with_kalibr(mav0: Path) -> None:
    """Calibrations as Kalibr writes them and TUM-VI has them: dso/camchain.yaml and dso/imu_config.yaml, no sensor.yaml."""
    text = (mav0 / SENSOR).read_text()
    numbers = lambda key: [float(number) for number in re.search(key + r": *\[([^\]]*)\]", text)[1].split(",")]
    value = lambda key: re.search(rf"^{key}: *(.*)$", text, re.MULTILINE)[1]
    T_cam_imu = np.linalg.inv(np.reshape(numbers("data"), (4, 4)))
    rows = "".join(f"\n  - [{', '.join(map(repr, map(float, row)))}]" for row in T_cam_imu)
    (mav0.parent / "dso").mkdir()
    (mav0.parent / "dso" / "camchain.yaml").write_text(
        f"cam0:\n  T_cam_imu:{rows}\n  cam_overlaps: [1]\n  camera_model: pinhole\n"
        f"  distortion_coeffs: {numbers('distortion_coefficients')}\n  distortion_model: radtan\n"
        f"  intrinsics: {numbers('intrinsics')}\n  resolution: {value('resolution')}\n  rostopic: /cam0/image_raw\n"
        "cam1:\n  camera_model: omni\n")
    imu = (mav0 / "imu0" / "sensor.yaml").read_text()
    noises = re.findall(r"^(?:gyro|accel).*$", imu, re.MULTILINE)
    rate = re.search(r"rate_hz: *(.*)", imu)[1]
    (mav0.parent / "dso" / "imu_config.yaml").write_text("\n".join(["#Accelerometers", *noises, "rostopic: /imu0",
                                                                   f"update_rate: {rate}"]) + "\n")
    for sensor in mav0.rglob("sensor.yaml"):
        sensor.unlink()


def inverse(chain: Path) -> None:
    """T_imu_cam instead of T_cam_imu."""
    text = chain.read_text()
    rows = re.search(r"T_cam_imu:((?:\n  - \[.*\]){4})", text)[1]
    T = np.linalg.inv(np.reshape([float(word) for word in re.findall(r"[^\s,\[\]]+(?=[,\]])", rows)], (4, 4)))
    chain.write_text(text.replace("T_cam_imu:" + rows, "T_imu_cam: " + str(T.tolist())))


def rendered(of: type, *flights) -> Path:
    """A folder that lasts as long as the tests of the class, with these flights in it: name, seconds, perhaps "stereo"."""
    if not (BUILD / "bin" / "ch5_track").exists():
        raise unittest.SkipTest("without ch5_track, which needs OpenCV: libopencv-video-dev, libpng-dev and libjpeg-dev")
    folder = tempfile.TemporaryDirectory()
    of.addClassCleanup(folder.cleanup)
    for name, *words in flights:
        done = run(BUILD / "tests" / "track" / "render_flight", Path(folder.name, name), *words)
        assert done.returncode == 0, done.stderr
    return Path(folder.name)


def numbers_of(path: Path) -> list:
    return [float(word) for word in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", path.read_text(encoding="utf-8"))]


class TrackApp(AppTest):
    app = "ch5_track"

    @classmethod
    def setUpClass(cls):
        folder = rendered(cls, ("flight", 1), ("moving", 4), ("pair", 0.95, "stereo"))
        cls.flight, cls.moving, pair = folder / "flight", folder / "moving", folder / "pair"
        cls.at_rest = real("euroc_v1_01_mav0", pair / "mav0")  # twenty images of two cameras that stand still

    def copy(self, change=lambda mav0: None, name="copy", of=None) -> Path:
        place = self.folder / name
        shutil.copytree(of or self.flight, place)
        change(place / "mav0")
        return place

    def test_each_broken_folder_is_named_in_a_sentence(self):
        for name, (change, sentence) in BROKEN.items():
            with self.subTest(name):
                place = self.copy(change, name.replace(" ", "_"))
                done = self.program(place, "--out", self.out, "--strict")
                self.assertEqual(done.returncode, 2, done.stderr)
                said = done.stderr.replace(str(place / "mav0"), "FOLDER")
                self.assertRegex(said, "^ch5_track: " + sentence.replace("STAMP", r"\d{19}") + "\n$")
                self.assertFalse(self.out.exists(), "nothing is written")

    def test_a_missing_image_or_line_does_not_cost_the_recording(self):
        for name in ("no image file", "an image that is cut", "a NaN", "a row that is cut", "a time that goes backwards"):
            with self.subTest(name):
                change, sentence = BROKEN[name]
                place = self.copy(change, name.replace(" ", "_"))
                said = self.solve(place, "--out", self.out).stdout.replace(str(place / "mav0"), "FOLDER")
                self.assertRegex(said, r": left out: 1, the first: " + sentence.replace("STAMP", r"\d{19}") + "\n")

    def test_other_spellings_of_a_folder_are_the_same_recording(self):
        self.solve(self.copy(name="plain"), "--out", self.folder / "expected")
        expected = {path.name: path.read_bytes() for path in (self.folder / "expected").iterdir()}
        self.assertEqual(set(expected), {"calibration.yaml", "imu.csv", "tracks.csv", "groundtruth.csv"})
        for name, change in HARMLESS.items():
            with self.subTest(name):
                out = self.folder / "out" / name
                self.solve(self.copy(change, name) / "mav0", "--out", out)
                for file, content in expected.items():
                    self.assertEqual((out / file).read_bytes(), content, file)
        done = self.solve(self.copy(HARMLESS["no newline at the end"], "cut"), "--out", self.out)
        self.assertIn("imu0: the last line has no end", done.stdout)

    def test_units_that_the_columns_name_are_converted(self):
        self.solve(self.copy(name="plain"), "--out", self.folder / "expected")
        head = lambda _: "#timestamp [ns],w_x [deg/s],w_y,w_z,a_x [g],a_y,a_z"
        self.solve(self.copy(edit(MOTION, lambda text: scaled(text, 180 / np.pi, 1 / 9.80665, head)), "units"), "--out", self.out)
        imu = [np.genfromtxt(place / "imu.csv", delimiter=",", skip_header=1) for place in (self.folder / "expected", self.out)]
        np.testing.assert_allclose(imu[0], imu[1], rtol=1e-9, atol=1e-12)

    def test_what_is_doubtful_is_said_beside_the_tracks(self):
        def without_gyroscope(text):
            return "\n".join(re.sub(r"^(\d+),[^,]*,[^,]*,[^,]*", r"\1,0.01,-0.02,0.015", line) for line in text.split("\n"))
        for name, change, words in (("dead", edit(MOTION, without_gyroscope), "the gyroscope feels nothing on axis x, y, z all along"),
                                    ("degrees", edit(MOTION, lambda text: scaled(text, 20.0, 1.0)), "the images turn 0.05.* times as far as the gyroscope: is it in rad/s"),
                                    ("rate", replace("imu0/sensor.yaml", "rate_hz: .*", "rate_hz: 500"), r"the IMU measures 200\.00 times a second, and 500\.00 by imu\.rate_hz"),
                                    ("whole", lambda mav0: None, "")):
            with self.subTest(name):
                done = self.program(self.copy(change, name, self.moving), "--out", self.out, "--check")
                self.assertRegex(done.stderr, f"warning: {words}" if words else "^$")

    def test_calibrations_of_kalibr_stand_for_sensor_yaml(self):
        self.solve(self.copy(name="plain"), "--out", self.folder / "expected")
        place = self.copy(with_kalibr, "kalibr")
        done = self.solve(place, "--out", self.out)
        for file in ("imu.csv", "tracks.csv", "groundtruth.csv"):
            self.assertEqual((self.out / file).read_bytes(), (self.folder / "expected" / file).read_bytes(), file)
        for one, other in zip(numbers_of(self.out / "calibration.yaml"), numbers_of(self.folder / "expected" / "calibration.yaml")):
            self.assertAlmostEqual(abs(one), abs(other), 9)  # q and −q are one rotation

        chain = place / "dso" / "camchain.yaml"
        text = chain.read_text()
        for name, places, change in (("as sensor.yaml", ("mav0/cam0/sensor.yaml", "mav0/imu0/sensor.yaml"), None),
                                     ("beside it", ("mav0/cam0/my-camchain.yml", "mav0/imu0/imu.yaml"), None),
                                     ("OpenVINS", ("kalibr_imucam_chain.yaml", "kalibr_imu_chain.yaml"), inverse)):
            other = self.copy(with_kalibr, name)
            for file, to in zip(("camchain.yaml", "imu_config.yaml"), places):
                (other / "dso" / file).rename(other / to)
            if change:
                change(other / places[0])
            self.solve(other, "--out", self.folder / "out" / name)
            self.assertEqual((self.folder / "out" / name / "tracks.csv").read_bytes(), (self.out / "tracks.csv").read_bytes(), name)
        chain.write_text(text.replace("rostopic: /cam0/image_raw", "timeshift_cam_imu: -0.0125"))
        done = self.solve(place, "--out", self.folder / "shifted")
        self.assertIn("1 images before or after", done.stdout)
        stamps = [[int(row["#timestamp [ns]"]) for row in table(folder / "tracks.csv")] for folder in (self.out, self.folder / "shifted")]
        self.assertEqual(max(stamps[0]) - max(stamps[1]), 12_500_000)

        for change, sentence in ((text.replace("intrinsics", "focal"), r"dso/camchain\.yaml: cam0: intrinsics is missing"),
                                 (text.replace("radtan", "mei"), r"dso/camchain\.yaml:\d+: distortion_model: must be .* got \"mei\""),
                                 (text.replace("T_cam_imu", "T_cam"), r"dso/camchain\.yaml: cam0: T_cam_imu is missing")):
            chain.write_text(change)
            done = self.program(place, "--out", self.folder / "none")
            self.assertEqual(done.returncode, 2)
            self.assertRegex(done.stderr, sentence)
        chain.rename(place / "camchain.yaml.txt")
        done = self.program(place, "--out", self.folder / "none")
        self.assertRegex(done.stderr, r"mav0/cam0/sensor\.yaml: there is no such file, nor one of Kalibr's")

    def test_a_gap_in_the_images_is_noted_and_ends_the_tracks(self):
        def without_half_a_second(mav0):
            edit(IMAGES, lambda text: "\n".join(line for i, line in enumerate(text.split("\n")) if not 6 <= i < 15))(mav0)
        done = self.solve(self.copy(without_half_a_second), "--out", self.out)
        self.assertIn("cam0 has no image from 0.20 s to 0.70 s; its tracks end there", done.stdout)
        rows = table(self.out / "tracks.csv")
        ids = {}
        for row in rows:
            ids.setdefault(row["#timestamp [ns]"], set()).add(row["track_id"])
        before, after = sorted(ids)[4:6]
        self.assertFalse(ids[before] & ids[after])

    def test_a_second_camera_that_is_not_what_it_must_be_is_named(self):
        def second(change):
            def apply(mav0):
                shutil.copytree(mav0 / "cam0", mav0 / "cam1")
                change(mav0)
            return apply

        late = edit("cam1/data.csv", lambda text: re.sub(
            r"^\d{19},", lambda stamp: f"{int(stamp[0][:-1]) + 10_000_000},", text, flags=re.MULTILINE))
        done = self.solve(self.copy(second(late), "late"), "--out", self.out)
        self.assertIn("cam1 is not used: it has no image within 1 ms of one of cam0's", done.stdout)
        done = self.solve(self.copy(second(replace("cam1/sensor.yaml", "resolution: .*", "resolution: [640, 480]")), "size"), "--out", self.out)
        self.assertIn("cam1 is not used: its images are of another size than cam0's", done.stdout)
        done = self.solve(self.copy(second(edit("cam1/data.csv", lambda text: "\n".join(text.split("\n")[:11]) + "\n")), "short"),
                          "--out", self.out)
        self.assertIn("11 images of cam0 are without one of cam1 at the same time", done.stdout)
        for name, change, sentence in (
                ("table", lambda mav0: (mav0 / "cam1" / "data.csv").unlink(), r"FOLDER/cam1/data\.csv: cannot be read: .+"),
                ("model", replace("cam1/sensor.yaml", "pinhole", "omni"), r"FOLDER/cam1/sensor\.yaml:12: camera_model: must be "
                 r"pinhole or ds, got \"omni\""),
                ("lens", replace("cam1/sensor.yaml", r"(distortion_coefficients: \[)[^,]*", r"\1-28"),
                 r"FOLDER/cam1/sensor\.yaml:\d+: distortion_coefficients: no lens .+")):
            with self.subTest(name):
                place = self.copy(second(change), name)
                done = self.program(place, "--out", self.folder / "none")
                self.assertEqual(done.returncode, 2)
                self.assertRegex(done.stderr.replace(str(place / "mav0"), "FOLDER"), "^ch5_track: " + sentence + "\n$")
                self.assertEqual(self.program(place, "--out", self.folder / "mono", "--mono").returncode, 0)

    def test_without_ground_truth_it_goes_on(self):
        done = self.solve(self.copy(lambda mav0: shutil.rmtree((mav0 / TRUTH).parent)), "--out", self.out)
        self.assertIn("ground truth: none", done.stdout)
        self.assertFalse((self.out / "groundtruth.csv").exists())

    def test_poses_of_a_motion_capture_system_are_taken_where_there_is_nothing_better(self):
        def only_mocap(mav0):
            (mav0 / "state_groundtruth_estimate0").rename(mav0 / "mocap0")
            edit("mocap0/data.csv", lambda text: "\n".join(",".join(line.split(",")[:8]) for line in text.split("\n")))(mav0)
        done = self.solve(self.copy(only_mocap), "--out", self.out)
        self.assertIn("ground truth: mocap0", done.stdout)
        self.assertEqual(len(table(self.out / "groundtruth.csv")), 201)

    def test_truth_in_tums_format_is_the_same_truth(self):
        self.solve(self.copy(name="plain"), "--out", self.folder / "expected")
        expected = table(self.folder / "expected" / "groundtruth.csv")
        rows = [line.split(",") for line in (self.flight / "mav0" / TRUTH).read_text().splitlines()[1:]]
        tum = "# timestamp tx ty tz qx qy qz qw\n" + "".join(
            " ".join([f"{row[0][:-9]}.{row[0][-9:]}", *row[1:4], *row[5:8], row[4]]) + "\n" for row in rows)
        for name in (TRUTH, "gt.txt", "../groundtruth.txt"):
            def instead(mav0):
                shutil.rmtree((mav0 / TRUTH).parent)
                (mav0 / TRUTH).parent.mkdir()
                (mav0 / name).write_text(tum)
            done = self.solve(self.copy(instead, Path(name).parent.name + Path(name).name), "--out", self.out)
            self.assertIn(f"ground truth: {Path(name).parent.name if name == TRUTH else Path(name).name}\n", done.stdout)
            for one, other in zip(table(self.out / "groundtruth.csv"), expected, strict=True):
                self.assertEqual([one[key] for key in list(one)[1:8]], [other[key] for key in list(one)[1:8]])
                self.assertLess(abs(int(one["#timestamp [ns]"]) - int(other["#timestamp [ns]"])), 1000)

    def test_truth_without_rotations_is_none(self):
        done = self.solve(self.copy(edit(TRUTH, lambda text: "\n".join(",".join(line.split(",")[:4]) for line in text.split("\n")))),
                          "--out", self.out)
        self.assertIn("ground truth: none, since state_groundtruth_estimate0 has no rotations (columns q_w, q_x, q_y, q_z)\n", done.stdout)

    def test_a_folder_of_two_cameras_is_tracked(self):
        for mav0 in self.at_rest:
            with self.subTest(mav0):
                done = self.solve(mav0, "--out", self.out)
                self.assertRegex(done.stdout, "cam1 sees [5-9][0-9] % of them")
                self.assertIn("20 images of 752 × 480 pixels", done.stdout)
                both = table(self.out / "tracks.csv")
                tracks = [row for row in both if row["camera"] == "0"]
                self.assertGreater(len(both) - len(tracks), 20 * 70)
                self.solve(mav0, "--out", self.folder / "one", "--mono")
                one = table(self.folder / "one" / "tracks.csv")
                self.assertEqual([{**row, "camera": "0"} for row in one], tracks, "camera 0 is followed the same without cam1")
                self.assertGreater(len(tracks), 20 * 80)
                # It stands still: what is followed through all images hardly moves. 1 px is 0.0022.
                places = {}
                for row in tracks:
                    places.setdefault(row["track_id"], []).append((float(row["x [normalized]"]), float(row["y [normalized]"])))
                whole = [place for place in places.values() if len(place) == 20]
                self.assertGreater(len(whole), 60)
                moved = sorted(max(abs(place[-1][0] - place[0][0]), abs(place[-1][1] - place[0][1])) for place in whole)
                self.assertLess(moved[len(moved) // 2], 0.0022)

    def test_a_vehicle_that_stands_still_starts_with_two_cameras(self):
        for mav0 in self.at_rest:
            with self.subTest(mav0):
                recording, out, is_real = self.folder / "tracked", self.out, self.flight.parent not in mav0.parents
                self.solve(mav0, "--out", recording)
                done = run(BUILD / "bin" / "ch5_recording", recording, "--out", out)
                self.assertEqual(done.returncode, 0, done.stderr)
                for policy in table(out / "csv" / "odometry_policies.csv"):
                    self.assertEqual(policy["frames"], "13", "the first ones are the start")
                    if is_real:
                        self.assertLess(float(policy["ate_m"]), 0.002)
                    speeds = [float(row["v_x [m/s]"]) for row in table(out / f"{policy['policy']}.csv")]
                    self.assertLess(max(map(abs, speeds)), 0.05)
                self.assertEqual([row["warning"] for row in table(out / "csv" / "odometry_warnings.csv")], [] if is_real else ["no_comparison"],
                                 "nothing can be said of a second at rest")

    def test_run_on_a_vehicle_that_stands_still_says_so_with_one_camera(self):
        for mav0 in self.at_rest:
            done = run(ROOT / "course", "run", mav0, "--out", self.out, "--mono")
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn("no policy found a start", done.stderr)
            self.assertNotIn("Traceback", done.stderr)

    def test_track_writes_a_folder_that_run_reads(self):
        done = run(ROOT / "course", "track", self.copy(), "--out", self.out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue((self.out / "copy" / "tracks.csv").exists())
        refused = run(ROOT / "course", "track", self.out, "--out", self.out)
        self.assertIn("neither this folder nor its mav0 holds cam0, nor is it", refused.stderr)
        self.assertEqual(refused.returncode, 2)
