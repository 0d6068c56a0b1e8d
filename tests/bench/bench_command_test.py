"""./course bench --json on a tiny problem: the shape of the answer, never a time."""

import csv
import json
import os
from pathlib import Path

from tests.project import ROOT, run
from tests.folder import FolderTest
from ch5_backend.course.base.cmake_build import BIN, BUILD, build_or_fail, cached_entries
from ch5_backend.course.experiments.bench import BEST, FIELDS, SAME


class BenchCommand(FolderTest):
    def test_json_has_a_row_for_each_question(self):
        if Path(os.environ["CH5_BUILD"]).resolve() != ROOT / "build" / "release":
            self.skipTest("./course builds in build/release, and these tests run in another folder")
        done = run(ROOT / "course", "bench", "scene/3x20", "scene/10x200", "--quick", "--json", "--out", self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout.count("\n"), 1, "one object and nothing else")
        rows = json.loads(done.stdout)["rows"]
        names = [row["problem"] for row in rows]
        for scene in ("3x20", "10x200"):
            for question in ("iteration", "total", "to 1 %", "to 0.1 %"):
                self.assertEqual([row["setting"] for row in rows if row["problem"] == f"scene/{scene} {question}"], [SAME, BEST])
        for row in rows:
            self.assertEqual(tuple(row), FIELDS)
            self.assertEqual(row["threads"], 1)
            self.assertGreater(row["ours_ms"], 0.0)
            self.assertGreater(row["ours_cost"], 0.0)
            self.assertGreater(row["ours_peak_mb"], 1.0)
            if row["peer_ms"]:
                self.assertGreater(row["ratio"], 0.0)
                self.assertLess(abs(row["ours_cost"] / row["peer_cost"] - 1.0), 1e-4, "the same problem")
            else:
                self.assertIsNone(row["ratio"])
        out = self.folder / "bench"
        with open(out / "rows.csv", newline="", encoding="utf-8") as file:
            self.assertEqual([row["problem"] for row in csv.DictReader(file)], names)
        for name in ("bench_cost", "bench_size"):
            self.assertTrue((out / "figures" / f"{name}.png").exists())

    def test_both_sides_told_the_same_take_the_same_first_steps(self):
        if Path(os.environ["CH5_BUILD"]).resolve() != ROOT / "build" / "release":
            self.skipTest("./course builds in build/release, and these tests run in another folder")
        build_or_fail(["bench_programs"])
        if not (BIN / "measure_ceres").exists():
            self.skipTest("Ceres is not installed")
        for problem in ("city:30 --way lm,xyz,radius=1e4,whole", "city:30 --way lm,ray,radius=1e4,whole", "scene:10x200 --way lm,radius=1e4,whole"):
            runs = [json.loads(run(BIN / f"measure_{side}", *problem.split(), check=True).stdout) for side in ("ours", "ceres")]
            for step in range(3):
                ours, ceres = (run["trace"][step][1] for run in runs)
                self.assertLess(abs(ours / ceres - 1.0), 1e-9, f"{problem}: step {step}, {ours} and {ceres}")
            for one in runs:
                self.assertLessEqual(one["trace"][-1][0], one["seconds"], f"{problem}: nothing is counted twice")
            self.assertEqual("openblas" in runs[1]["blas"], bool(cached_entries(BUILD).get("OPENBLAS_LIBRARY", "").endswith(".so.0")),
                             "the BLAS that the bench was linked with is the one that serves Ceres")
