"""What the tests of both programs share: where they are, and how ./course is called."""

import csv
import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("CH5_BUILD", ROOT / "build" / "release"))
DATA = Path(os.environ.get("CH5_DATA_DIR", ROOT.parent / "shared" / "data"))


def run(program, *words):
    return subprocess.run([program, *map(str, words)], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=280, env={**os.environ, "CH5_BUILD_DIR": str(BUILD)})


def table(path) -> list:
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def contents(folder) -> dict:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def needs(path) -> Path:
    if not path.exists():
        raise unittest.SkipTest(f"{path} is missing")
    return path


class AppTest(unittest.TestCase):
    app = ""  # the program's name

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.out = self.folder / "out"

    def program(self, *words):
        return run(BUILD / "bin" / self.app, *words)

    def course_run(self, data, *words) -> dict:
        """The JSON object of ./course run DATA --json: alone on standard output, no living lines beside it."""
        done = run(ROOT / "course", "run", data, "--out", self.out, "--json", *words)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout.count("\n"), 1, "one object and nothing else")
        for sign in ("\r", "\033"):
            self.assertNotIn(sign, done.stderr, "no living lines in a pipe")
        result = json.loads(done.stdout)
        self.assertEqual(result["problem"], Path(data).stem)
        self.assertEqual(Path(result["out"]), self.out / Path(data).stem)
        return result
