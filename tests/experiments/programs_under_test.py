"""What the tests of the programs share: how they and ./course are called, and what is looked at then."""

import csv
import json
import subprocess
import sys
from pathlib import Path

from tests.folder import FolderTest
from tests.project import BUILD, DATA, ROOT, run


def table(path) -> list:
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def make_trials(program, study, trials, path) -> None:
    """The table of a study: the rows of the trials 0, 1, … one below the other."""
    text = ""
    path.parent.mkdir(parents=True, exist_ok=True)
    for trial in range(trials):
        done = run(program, study, "--trial", trial, "--out", path, "--data", DATA)
        assert (done.returncode, done.stderr) == (0, ""), done
        rows = path.read_text(encoding="utf-8")
        text += rows if trial == 0 else rows.partition("\n")[2]
    path.write_text(text, encoding="utf-8")


def contents(folder) -> dict:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def real(name: str, *instead) -> list:
    """What stands in for the real data of this name, and these where they are."""
    return [*instead, *([DATA / name] if (DATA / name).exists() else [])]


class AppTest(FolderTest):
    app = ""  # the program's name

    def setUp(self):
        super().setUp()
        self.out = self.folder / "out"

    def write(self, name, text) -> Path:
        path = self.folder / name
        path.write_text(text, encoding="utf-8")
        return path

    def program(self, *words, **options):
        return run(BUILD / "bin" / self.app, *words, **options)

    def solve(self, *words) -> subprocess.CompletedProcess:
        done = self.program(*words)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done

    def draw(self) -> None:
        """Draws the results, without a warning."""
        done = run(sys.executable, "-m", f"ch5_backend.figures.{self.app[4:]}", self.out)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def refuses(self, *words, message, **options):
        """Exit 2, exactly this message on standard error, no file but the old ones."""
        before = contents(self.folder)
        done = self.program(*words, **options)
        self.assertEqual((done.returncode, done.stderr), (2, f"{self.app}: {message}\n"))
        self.assertEqual(contents(self.folder), before)

    def summary(self) -> dict:
        return {row["key"]: row["value"] for row in table(self.out / "summary.csv")}

    def course_run(self, data, *words, course=(ROOT / "course",)) -> dict:
        """The JSON object of ./course run DATA --json: alone on standard output, no living lines beside it."""
        done = run(*course, "run", data, "--out", self.out, "--json", *words)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout.count("\n"), 1, "one object and nothing else")
        for sign in ("\r", "\033"):
            self.assertNotIn(sign, done.stderr, "no living lines in a pipe")
        result = json.loads(done.stdout)
        self.assertEqual(result["problem"], Path(data).stem)
        self.assertEqual(Path(result["out"]), self.out / Path(data).stem)
        return result

    def course_solve(self, file) -> dict:
        """The same of a file that is solved: its summary, in numbers."""
        result = self.course_run(file, "--iterations", "30", "--threads", "2")
        for key, kind in (("initial_cost", float), ("final_cost", float), ("iterations", int), ("seconds", float)):
            self.assertIsInstance(result[key], kind, key)
        return result
