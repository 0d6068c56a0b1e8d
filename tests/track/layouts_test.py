"""./course track and run on other layouts than EuRoC's: the same flight, written as phones, KITTI and ROS write it."""

import contextlib
import io
import shutil
import unittest
from pathlib import Path

import numpy as np

from ch5_backend.course.base.errors import CourseError
from ch5_backend.course.experiments.data import has_images, kind_of
from ch5_backend.course.experiments.layouts.convert import as_euroc
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
            self.assertEqual((kind_of(str(place)), has_images(str(place))), ("recording", True))
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


if __name__ == "__main__":
    unittest.main()
