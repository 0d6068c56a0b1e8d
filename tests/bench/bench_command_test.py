"""./course bench --json on a tiny problem: the shape of the answer, never a time."""

import csv
import json
import os
import subprocess
from pathlib import Path

from tests.project import ROOT
from tests.folder import FolderTest

FIELDS = ["problem", "threads", "ours_ms", "peer", "peer_ms", "ratio", "ours_cost", "peer_cost", "ours_peak_mb",
          "peer_peak_mb", "ours_bytes", "peer_bytes"]


class BenchCommand(FolderTest):
    def test_json_has_a_row_for_each_question(self):
        if Path(os.environ["CH5_BUILD"]).resolve() != ROOT / "build" / "release":
            self.skipTest("./course builds in build/release, and these tests run in another folder")
        done = subprocess.run([ROOT / "course", "bench", "scene/3x20", "scene/10x200", "--quick", "--json", "--out",
                               self.folder], stdin=subprocess.DEVNULL, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout.count("\n"), 1, "one object and nothing else")
        rows = json.loads(done.stdout)["rows"]
        names = [row["problem"] for row in rows]
        for scene in ("3x20", "10x200"):
            for question in ("iteration", "total", "to 1 %", "to 0.1 %"):
                self.assertEqual(names.count(f"scene/{scene} {question}"), 1)
        for row in rows:
            self.assertEqual(list(row), FIELDS)
            self.assertEqual(row["threads"], 1)
            self.assertGreater(row["ours_ms"], 0.0)
            self.assertGreater(row["ours_cost"], 0.0)
            self.assertGreater(row["ours_peak_mb"], 1.0)
            if row["peer"]:
                self.assertAlmostEqual(row["ratio"], row["peer_ms"] / row["ours_ms"])
                self.assertLess(abs(row["ours_cost"] / row["peer_cost"] - 1.0), 1e-4, "the same problem")
            else:
                self.assertIsNone(row["ratio"])
        out = self.folder / "bench"
        with open(out / "rows.csv", newline="", encoding="utf-8") as file:
            self.assertEqual([row["problem"] for row in csv.DictReader(file)], names)
        for name in ("bench_cost", "bench_size"):
            self.assertTrue((out / "figures" / f"{name}.png").exists())
