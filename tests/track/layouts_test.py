"""./course track and run on other layouts than EuRoC's: the same flight, written as phones, KITTI and ROS write it."""

import contextlib
import io
import shutil
import subprocess
import unittest
from pathlib import Path

import numpy as np

from ch5_backend.course.base.errors import CourseError
from ch5_backend.course.experiments.data import kind_of
from ch5_backend.course.experiments.layouts.convert import as_euroc
from tests.folder import FolderTest
from tests.project import BUILD, run
from tests.track.track_app_test import rendered


def seconds(stamp: int) -> str:
    return f"{stamp // 10**9}.{stamp % 10**9:09d}"


class Layouts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = rendered(cls, ("flight", 1))
        cls.mav0 = cls.folder / "flight" / "mav0"
        rows = [line.split(",") for line in (cls.mav0 / "imu0" / "data.csv").read_text().splitlines()[1:]]
        cls.stamps = [int(row[0]) for row in rows]
        cls.w, cls.a = (np.array([row[k:k + 3] for row in rows], dtype=float) for k in (1, 4))
        cls.tracks = cls.tracked(cls.mav0.parent)

    @classmethod
    def tracked(cls, folder) -> bytes:
        done = run(BUILD / "bin" / "ch5_track", folder, "--out", cls.folder / "recording")
        assert done.returncode == 0, done.stderr
        return (cls.folder / "recording" / "tracks.csv").read_bytes()

    def phone(self, gyroscope: str, accelerometer: str, name="phone") -> Path:
        """A folder with these two tables and the flight's images and calibration."""
        place = self.folder / name
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir()
        (place / "images").symlink_to(self.mav0 / "cam0" / "data")
        shutil.copy(self.mav0 / "cam0" / "sensor.yaml", place / "cam.yaml")
        for file, text in (("Gyroscope.csv", gyroscope), ("Accelerometer.csv", accelerometer)):
            if text:
                (place / file).write_text(text)
        return place

    def table(self, head, values, time=str, separator=",", stamps=None) -> str:
        rows = [separator.join([time(stamp), *(f"{value:.12g}" for value in row)]) for stamp, row in zip(stamps or self.stamps, values)]
        return "\n".join(([head] if head else []) + rows) + "\n"

    def converted(self, place) -> tuple:
        """The folder in EuRoC's layout, and what was said."""
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            self.assertEqual(kind_of(str(place)), "images")
            return Path(as_euroc(str(place), self.folder / "converted")), said.getvalue()

    def test_tables_of_an_imu_in_any_unit_order_and_clock_are_the_same_recording(self):
        t, w, a = self.table, self.w, self.a
        plain = t("t,x,y,z", w), t("t,x,y,z", a)
        for name, gyroscope, accelerometer, words in (
                ("nanoseconds", *plain, ""),
                ("microseconds and seconds", t("t,x,y,z", w, lambda stamp: str(stamp // 1000)), t("t,x,y,z", a, seconds), ""),
                ("degrees and g", t("t,x (deg/s),y (deg/s),z (deg/s)", np.degrees(w)), t("t,gFx,gFy,gFz", a / 9.81), "are in degrees"),
                ("Apple's sign", plain[0], t("timestamp(s),accelerometerAccelerationX(G),accelerometerAccelerationY(G),accelerometerAccelerationZ(G)", -a / 9.81),
                 "in units of 9.81"),
                ("z, y, x", t("time,z,y,x", w[:, ::-1]), t("time,z,y,x", a[:, ::-1]), ""),
                ("one file, tabs", t("time\tgx\tgy\tgz\tax\tay\taz", np.hstack([w, a]), separator="\t"), "", ""),
                ("no names", t("", np.hstack([a, w]), separator=" "), "", ""),
                ("semicolons and commas", t("t;x;y;z", w, seconds, ";").replace(".", ","), t("t;x;y;z", a, seconds, ";").replace(".", ","), ""),
                ("a cut row", plain[0], plain[1].rsplit(",", 1)[0], "1 of 201 rows lack"),
                ("another clock", t("t,x,y,z", w, stamps=list(range(10**9, 2 * 10**9 + 1, 5 * 10**6))),
                 t("t,x,y,z", a, stamps=list(range(10**9, 2 * 10**9 + 1, 5 * 10**6))), "taken to have begun together")):
            with self.subTest(name):
                place, said = self.converted(self.phone(gyroscope, accelerometer))
                self.assertIn(words, said)
                rows = np.genfromtxt(place / "mav0" / "imu0" / "data.csv", delimiter=",", skip_header=1)
                np.testing.assert_allclose(rows[:, 1:4], w[:len(rows)], atol=1e-7)
                np.testing.assert_allclose(rows[:, 4:7], a[:len(rows)], atol=1e-6)
                if name != "a cut row":
                    self.assertEqual(self.tracked(place), self.tracks)

    def test_what_is_missing_is_named(self):
        gyroscope, accelerometer = self.table("t,x,y,z", self.w), self.table("t,x,y,z", self.a)
        for place, words in ((self.phone("", accelerometer), "no table of a gyroscope is here"),
                             (self.phone("", "", "images"), "no table of a gyroscope and accelerometer is here"),
                             (self.phone(gyroscope, self.table("t,x,y,z", 1e-2 * self.a, ), "linear"), "gravity in no unit"),
                             (self.phone(gyroscope, self.table("t,x,y,z", self.a, stamps=list(range(0, 10**9 + 1, 5 * 10**6))), "clocks"), "its clock differs")):
            with self.subTest(words):
                with self.assertRaisesRegex(CourseError, words):
                    self.converted(place)

    def test_without_a_calibration_a_phones_is_guessed_and_said(self):
        place = self.phone(self.table("t,x,y,z", self.w), self.table("t,x,y,z", self.a))
        (place / "cam.yaml").unlink()
        _, said = self.converted(place)
        self.assertIn("a focal length of 602 px, 0.8 of the image's longer side", said)


def picture(gray) -> bytes:
    """A PGM file."""
    return b"P5 %d %d 255\n" % gray.shape[::-1] + gray.tobytes()


class MadeUp(FolderTest):
    """Recordings of a few rows, whose every number is known."""

    def setUp(self):
        super().setUp()
        self.numbers = np.random.default_rng(59)
        self.stamps = [1_317_046_453_072_943_155 + 10_000_001 * k for k in range(40)]
        self.w, self.a = (self.numbers.integers(-10**6, 10**6, (40, 3)) / 2.0**19 + offset for offset in (0.0, (0.0, 0.0, 9.75)))
        self.gray = self.numbers.integers(0, 256, (8, 12, 16), dtype=np.uint8)  # 8 images

    def read(self, place: Path) -> Path:
        """Its mav0, whose IMU must be ours."""
        with contextlib.redirect_stderr(io.StringIO()):
            self.assertEqual(kind_of(str(place)), "images")
            mav0 = Path(as_euroc(str(place), self.folder / "converted")) / "mav0"
        rows = [line.split(",") for line in (mav0 / "imu0" / "data.csv").read_text().splitlines()[1:]]
        self.assertEqual([int(row[0]) for row in rows], self.stamps)
        np.testing.assert_allclose(np.array([row[1:] for row in rows], dtype=float), np.hstack([self.w, self.a]), rtol=1e-8, atol=1e-9)
        return mav0

    def images(self, mav0: Path, camera="cam0") -> dict:
        """{stamp: file}."""
        rows = [line.split(",") for line in (mav0 / camera / "data.csv").read_text().splitlines()[1:]]
        return {int(stamp): mav0 / camera / "data" / name for stamp, name in rows}

    def test_a_drive_of_kitti(self):
        drive, day = self.folder / "2011_09_26" / "drive_extract", self.folder / "2011_09_26"
        times = lambda stamps: "".join(f"2011-09-26 14:14:{stamp // 10**9 % 60:02d}.{stamp % 10**9:09d}\n" for stamp in stamps)
        degrees = self.numbers.uniform(-0.001, 0.001, (40, 2)) + (49.0, 8.4)
        angles, heights = self.numbers.uniform(-1, 1, (40, 3)), self.numbers.uniform(100, 101, 40)  # roll, pitch, yaw
        for folder in ("oxts", "image_00", "image_01"):
            (drive / folder / "data").mkdir(parents=True)
            (drive / folder / "timestamps.txt").write_text(times(self.stamps if folder == "oxts" else self.stamps[:32:4]))
        for k in range(40):
            row = [*degrees[k], heights[k], *angles[k], *np.zeros(5), *self.a[k], *np.full(3, 77.0), *self.w[k], *np.zeros(10)]
            (drive / "oxts" / "data" / f"{k:010d}.txt").write_text(" ".join(map(repr, map(float, row))))
        for camera, k in ((camera, k) for camera in (0, 1) for k in range(8)):
            (drive / f"image_0{camera}" / "data" / f"{k:010d}.pgm").write_bytes(picture(self.gray[k] ^ camera))
        # Turns by 90° about axes, so that the product can be written down: x forward, y left, z up → x right, y down, z forward.
        line = lambda key, values: f"{key}: {' '.join(map(str, values))}\n"
        (day / "calib_imu_to_velo.txt").write_text("calib_time: 25-May-2012\n" + line("R", (1, 0, 0, 0, 1, 0, 0, 0, 1)) + line("T", (-0.8, 0.3, -0.7)))
        (day / "calib_velo_to_cam.txt").write_text(line("R", (0, -1, 0, 0, 0, -1, 1, 0, 0)) + line("T", (0.1, -0.2, -0.3)))
        cameras = "".join(line(f"S_rect_0{c}", (16, 12)) + line(f"P_rect_0{c}", (20, 0, 8, -10.0 * c, 0, 21, 6, 0, 0, 0, 1, 0)) for c in (0, 1))
        (day / "calib_cam_to_cam.txt").write_text(cameras + line("R_rect_00", (1, 0, 0, 0, 1, 0, 0, 0, 1)))
        mav0 = self.read(drive)
        for c in (0, 1):
            found = self.images(mav0, f"cam{c}")
            self.assertEqual(list(found), self.stamps[:32:4])
            for k, file in enumerate(found.values()):
                self.assertEqual(file.read_bytes(), picture(self.gray[k] ^ c))
            sensor = (mav0 / f"cam{c}" / "sensor.yaml").read_text()
            self.assertIn("intrinsics: [20, 21, 8, 6]\n", sensor)
            # p_C = (−y, −z, x) of p_B + T_imu, and 0.1, −0.2, −0.3 farther; camera 1 is 0.5 m to the right of camera 0.
            T_C_B = np.array([[0, -1, 0, -0.3 + 0.1 - 0.5 * c], [0, 0, -1, 0.7 - 0.2], [1, 0, 0, -0.8 - 0.3], [0, 0, 0, 1]])
            T_B_C = np.array(sensor.split("data: [")[1].split("]")[0].split(","), dtype=float).reshape(4, 4)
            np.testing.assert_allclose(T_B_C @ T_C_B, np.eye(4), atol=1e-10)
        truth = np.loadtxt(mav0 / "groundtruth.txt")
        east, north = np.cos(np.radians(degrees[0, 0])) * 6378137.0 * np.radians(degrees - degrees[0])[:, ::-1].T
        np.testing.assert_allclose(truth[:, 1], east, atol=1e-6)
        np.testing.assert_allclose(truth[:, 2], north / np.cos(np.radians(degrees[0, 0])), rtol=1e-4, atol=1e-6)
        np.testing.assert_allclose(truth[:, 3], heights - heights[0], atol=1e-6)
        for (x, y, z, w), (roll, pitch, yaw) in zip(truth[:, 4:], angles):
            c, s = np.cos, np.sin
            self.assertAlmostEqual(1 - 2 * (y * y + z * z), c(yaw) * c(pitch), 7)
            self.assertAlmostEqual(2 * (x * y + z * w), s(yaw) * c(pitch), 7)
            self.assertAlmostEqual(2 * (y * z + x * w), c(pitch) * s(roll), 7)

    def test_a_bag_of_ros(self):
        try:
            import rosbag
            from genpy import Time
            from sensor_msgs.msg import CompressedImage, Image, Imu
        except ImportError:
            self.skipTest("without python3-rosbag and python3-sensor-msgs")
        place = self.folder / "flight.bag"
        packed = b"\x89PNG as it is"
        with rosbag.Bag(str(place), "w") as bag:
            for k in reversed(range(40)):  # messages may arrive out of order
                imu, late = Imu(), Time(0, self.stamps[k] + 10**8)
                imu.header.stamp = Time(0, self.stamps[k])
                for vector, values in ((imu.angular_velocity, self.w[k]), (imu.linear_acceleration, self.a[k])):
                    vector.x, vector.y, vector.z = map(float, values)
                bag.write("/imu", imu, late)
            for k, gray in enumerate(self.gray):
                image = Image(encoding="mono8", width=13, height=12, step=16, data=gray.tobytes())  # rows have a rest
                if k == 1:
                    image = Image(encoding="bgr8", width=5, height=12, step=16, data=gray.tobytes())
                image.header.stamp = Time(0, self.stamps[4 * k])
                bag.write("/camera/image_raw", image, image.header.stamp)
            for stamp in self.stamps[:3]:
                small = CompressedImage(format="png", data=packed)
                small.header.stamp = Time(0, stamp)
                bag.write("/other", small, small.header.stamp)
        found = self.images(self.read(place))
        self.assertEqual(list(found), self.stamps[:32:4], "the topic with the most images")
        for k, file in enumerate(found.values()):
            rows = self.gray[k][:, :13]
            if k == 1:
                blue, green, red = (self.gray[k][:, channel:15:3].astype(float) for channel in range(3))
                rows = np.rint(0.114 * blue + 0.587 * green + 0.299 * red).astype(np.uint8)
            self.assertEqual(file.read_bytes(), picture(np.ascontiguousarray(rows)))

    def test_a_video_has_its_own_times(self):
        if not shutil.which("ffmpeg"):
            self.skipTest("without ffmpeg")
        place = self.folder / "phone"
        place.mkdir()
        flat = np.repeat(np.arange(20, 240, 20, dtype=np.uint8), 64 * 48)
        done = subprocess.run(["ffmpeg", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "gray", "-s", "64x48", "-r", "100", "-i", "-", "-vf",
                               "setpts=(N+5*gte(N\\,4))*0.02/TB", "-vsync", "vfr", "-c:v", "ffv1", place / "film.mkv"], input=flat.tobytes(), capture_output=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        for name, values in (("gyroscope.csv", self.w), ("accelerometer.csv", self.a)):
            rows = "".join(f"{stamp},{','.join(map(repr, map(float, row)))}\n" for stamp, row in zip(self.stamps, values))
            (place / name).write_text("time,x,y,z\n" + rows)
        found = self.images(self.read(place))
        frames = [k + 5 * (k >= 4) for k in range(11)]
        self.assertEqual(list(found), [self.stamps[0] + 20_000_000 * k for k in frames])
        for k, file in enumerate(found.values()):
            pixels = subprocess.run(["ffmpeg", "-loglevel", "error", "-i", file, "-pix_fmt", "gray", "-f", "rawvideo", "-"], capture_output=True).stdout
            self.assertAlmostEqual(np.mean(np.frombuffer(pixels, np.uint8)), 20 * (k + 1), delta=2)
