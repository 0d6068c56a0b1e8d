"""The kept tables are what today's programs write: one trial of each, or a part of its flights, is computed anew. Kernels of
another width round otherwise, and a long flight makes much of it; so all use those of AVX2, which any processor of x86 has."""

import os
import re
import unittest

import numpy as np

from tests.folder import FolderTest
from tests.project import BUILD, DATA, ROOT, run

from ch5_backend.course.documents import measure_speed
from ch5_backend.course.experiments.figure_sets import SYSTEMS
from ch5_backend.figures.numbers.windows import KEPT
from ch5_backend.figures.tables import Tables

CORNERS = BUILD / "tests" / "track" / "image_corners"
TIMED = re.compile(r"milliseconds|microseconds|seconds|seconds_to_start|megabytes")  # other on each machine
ROUNDING = {"back_ends": ("worst_error",)}  # to a factor


@unittest.skipUnless((DATA / "tango_walk").exists(), f"{DATA} has no recordings")
class KeptTables(FolderTest):
    def assert_equal_rows(self, name, fresh, kept, timed=TIMED):
        self.assertEqual(list(fresh.columns), list(kept.columns), name)
        self.assertGreater(len(fresh), 0, name)
        lost = fresh["restarts"] > 0 if "restarts" in fresh.columns else np.zeros(len(fresh), bool)
        for column, values in fresh.columns.items():
            if timed.fullmatch(column):
                continue
            before = kept[column][:len(values)]
            if values.dtype.kind != "f":
                self.assertEqual(values.tolist(), before.tolist(), (name, column))
            elif column in ROUNDING.get(name, ()):
                np.testing.assert_allclose(np.log10(values), np.log10(before), atol=1, err_msg=f"{name}, {column}")
            else:
                for rows, tolerance in ((~lost, 1e-6), (lost, 0.05)):  # what is lost ends by rounding
                    np.testing.assert_allclose(values[rows], before[rows], tolerance, 1e-9, err_msg=f"{name}, {column}")

    def program(self, name, *words):
        done = run(BUILD / "bin" / name, *words, env={**os.environ, "CH5_SIMD": "avx2"})
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_the_first_trial_of_each_study_of_the_systems(self):
        for study, trial in [(name, 0) for name in SYSTEMS if name != "machine"] + [("consistency_recording", 1)]:  # that is Tango's
            with self.subTest(study, trial=trial):
                self.program("ch5_systems", study, "--trial", trial, "--out", self.folder / f"{study}.csv", "--data", DATA)
                self.assert_equal_rows(study, Tables(self.folder)(study), KEPT(study, **({"trial": trial} if trial else {})))

    def test_the_first_two_seconds_of_all_flights_of_the_nees(self):
        runs = int(KEPT("consistency")["runs"].max())
        self.program("ch5_nees", "--runs", runs, "--seconds", 2, "--out", self.folder)
        fresh, kept = Tables(self.folder / "csv")("consistency"), KEPT("consistency")
        cases = ("policy", "observations", "hosts", "mode", "t_s")
        for row in kept.rows():
            if row["t_s"] < 1.95:
                again = fresh.row(**{name: row[name] for name in cases})
                for name in row.keys() - set(cases):
                    tolerance = 1e-2 if name.endswith("leak") else 1e-6  # a small difference of large sums
                    np.testing.assert_allclose(again[name], row[name], tolerance, 1e-6, err_msg=f"{row}: {name}")

    def test_the_ways_of_the_fifth_lecture(self):
        for name, rows in (("speed_reduced", measure_speed.reduced(1)), ("speed_refined", measure_speed.refined(1)), ("speed_rays", measure_speed.rays())):
            kept = Tables(measure_speed.MEASURED)(name)
            self.assertEqual([int(row[1]) for row in rows], kept["iteration"].tolist(), name)
            tolerance = 1e-3 if name == "speed_reduced" else 1e-6  # a processor's own kernels; inexact steps make much of rounding
            np.testing.assert_allclose([float(row[-1]) for row in rows], kept["cost"], tolerance, err_msg=name)

    def test_corners_of_the_photograph(self):
        if not CORNERS.exists():
            self.skipTest("without OpenCV there is no front end")
        run(CORNERS, ROOT / "slides" / "photo.png", self.folder / "corners.csv", check=True)
        self.assert_equal_rows("corners", Tables(self.folder)("corners"), KEPT("corners"))

    def test_hosts_on_recordings(self):
        self.program("ch5_nees", "--recordings", DATA, "--out", self.folder)
        self.assert_equal_rows("host_noise", Tables(self.folder / "csv")("host_noise"), KEPT("host_noise"))
