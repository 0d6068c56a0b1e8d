"""./course plots: the table of figures is true, the same tables give the same bytes, and no finished trial is lost."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tests.folder import FolderTest
from tests.experiments.programs_under_test import contents
from tests.project import BUILD, OUT, ROOT, run

HERE = Path(__file__).resolve().parent
from ch5_backend.course.experiments import figure_sets

FAKE = [sys.executable, "-m", "tests.experiments.fake_course", "plots"]
TRIALS = 14  # of the fake set


class PlotsTest(FolderTest):
    def setUp(self):
        super().setUp()
        self.out, self.log = self.folder / "out", self.folder / "log"

    def environment(self, **more) -> dict:
        return {**os.environ, "CH5_BUILD_DIR": str(BUILD), "FAKE_LOG": str(self.log), **more}

    def fake(self, *words, **environment):
        return run(*FAKE, *words, env=self.environment(**environment))

    def succeed(self, *words, **environment):
        done = self.fake("--out", self.out, *words, **environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def runs(self) -> int:
        return len(self.log.read_text(encoding="utf-8").splitlines()) if self.log.exists() else 0

    def results(self) -> dict:
        """What no trial may change by when and where it ran."""
        return {path.relative_to(self.out): text for path, text in contents(self.out).items()}


class Command(PlotsTest):
    def refuses(self, *words, naming):
        done = run(ROOT / "course", "plots", *words)
        self.assertEqual((done.returncode, done.stdout), (2, ""), done)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        for word in naming:
            self.assertIn(word, done.stderr)

    def test_a_name_that_no_set_has_lists_those_there_are(self):
        self.refuses("frobnicate", naming=["'frobnicate'", "chapter", "bench", "pose_graph/sphere2500"])

    def test_a_share_must_be_one_of_its_number(self):
        for text in ("0/4", "5/4", "4", "1/0", "a/b", "1/2/3", "", "1/9999999"):
            self.refuses("--shard", text, naming=["--shard must be I/N", f"got '{text}'"])

    def test_a_place_that_cannot_be_written_is_named(self):
        blocker = self.folder / "file"
        blocker.write_text("keep me", encoding="utf-8")
        self.refuses("window/vio_S", "--out", str(blocker), naming=[f"cannot write into {blocker}"])
        self.assertEqual(blocker.read_text(encoding="utf-8"), "keep me")

    def test_list_says_what_there_is_and_writes_nothing(self):
        done = run(ROOT / "course", "plots", "--list", "--out", self.out)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual([line.split()[0] for line in done.stdout.splitlines()[1:]],
                         [one.name for one in figure_sets.SETS])
        self.assertFalse(self.out.exists())

    def test_data_that_are_not_there_are_said(self):
        done = run(ROOT / "course", "plots", "recording/tango", "--out", self.out, env=self.environment(CH5_DATA_DIR=str(self.folder)))
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertEqual(done.stderr, f"course: left out: recording/tango_walk; their data are not in {self.folder}\n"
                         "course: nothing is left to draw\n")


class TableOfFigures(PlotsTest):
    def test_names_are_unique_and_everything_that_is_named_exists(self):
        names = [one.name for one in figure_sets.SETS]
        self.assertEqual(len(set(names)), len(names))
        for one in figure_sets.SETS:
            for module in (words.split()[0] for words in (one.made_by, one.drawn_by) if words):
                place = module.replace(".", "/") if "." in module else f"ch5_backend/experiments/{module}"
                self.assertTrue(any((ROOT / (place + end)).exists() for end in (".py", ".cc", "/__main__.py")), module)
            self.assertLessEqual(set(one.beside.split()), set(names))
            self.assertEqual(bool(one.made_by), bool(one.tables), one.name)
            if one.trials:
                self.assertEqual(one.tables, figure_sets.csv(" ".join(one.trials)))

    def test_the_chapter_drawn_twice_is_the_same_to_the_byte(self):
        (self.out / "csv").mkdir(parents=True)
        for name in figure_sets.SETS[0].tables:
            shutil.copy(OUT / name, self.out / name)
        drawn = []
        for _ in range(2):
            done = run(ROOT / "course", "plots", "chapter", "slides/1", "--out", self.out)
            self.assertEqual((done.returncode, done.stdout), (0, f"The figures: {self.out}\n"), done.stderr)
            self.assertNotRegex(done.stderr, "[\r\033]|missing", "quiet in a pipe, and nothing is made anew")
            drawn.append(self.results())
            for path in self.out.rglob("figures/*"):
                path.unlink()
        self.assertEqual(drawn[0], drawn[1])
        pictures = {path.as_posix() for path in drawn[0] if path.parent.name == "figures"}
        self.assertLessEqual({"figures/prior_sweep.png", "figures/consistency.svg", "slides/figures/overview.zh.svg"}, pictures)
        csv = {path.as_posix() for path in drawn[0] if path.suffix == ".csv"}
        self.assertEqual(csv, set(figure_sets.SETS[0].tables))
        self.assertLessEqual({Path("report.html"), Path("report.zh.html")}, set(drawn[0]))

    def test_quick_makes_every_table_and_draws_every_set(self):
        done = run(ROOT / "course", "plots", "--quick", "--out", self.out)
        self.assertEqual(done.returncode, 0, done.stderr)
        for one in figure_sets.SETS:
            if one.quick is not None and one.has_data():
                self.assertFalse(one.lacks_tables(self.out / "quick"), one.name)
                folder = one.folder if not one.name.startswith("slides/") else "slides"
                self.assertTrue(any((self.out / "quick" / folder / "figures").iterdir()), one.name)


class Trials(PlotsTest):
    def test_a_table_has_the_rows_of_its_trials_in_their_order(self):
        self.succeed()
        lines = (self.out / "fake/csv/squares.csv").read_text(encoding="utf-8").splitlines()
        self.assertEqual(lines, ["study,trial,square"] + [f"squares,{k},{k * k + i}" for k in range(10) for i in range(2)])
        self.assertEqual(self.runs(), TRIALS)
        self.assertFalse((self.out / "jobs").exists(), "the tables hold all that they held")

    def test_tables_that_are_there_are_drawn_and_not_made(self):
        self.succeed()
        before = self.results()
        self.succeed()
        self.assertEqual((self.runs(), self.results()), (TRIALS, before))
        self.succeed("--rerun")
        self.assertEqual((self.runs(), self.results()), (2 * TRIALS, before))

    def test_quick_takes_fewer_trials_and_a_place_of_its_own(self):
        self.succeed("--quick")
        self.assertEqual(self.runs(), 5)
        self.assertEqual({path.parts[0] for path in self.results()}, {"quick"})

    def test_shares_make_the_same_bytes_as_one_run(self):
        self.succeed()
        whole = self.results()
        shutil.rmtree(self.out)
        with ThreadPoolExecutor() as pool:
            said = [done.stdout for done in pool.map(lambda i: self.succeed("--shard", f"{i}/3"), (1, 2, 3))]
        self.assertEqual(re.findall(r"Share (\d) of 3 is done", "".join(said)), ["1", "2", "3"])
        self.assertFalse((self.out / "fake" / "figures").exists())
        self.assertEqual(self.runs(), 2 * TRIALS, "each trial in one share")
        self.succeed()
        self.assertEqual((self.runs(), self.results()), (2 * TRIALS, whole))

    def test_a_kill_loses_only_the_running_trials(self):
        self.succeed()
        whole, before = self.results(), self.runs()
        shutil.rmtree(self.out)
        with subprocess.Popen([*FAKE, "--out", str(self.out)], env=self.environment(FAKE_SECONDS="0.1"),
                              stderr=subprocess.PIPE, text=True) as process:
            while len(list(self.out.glob("jobs/fake/*/[0-9]*.csv"))) < 5:
                time.sleep(0.01)
            process.send_signal(signal.SIGTERM)
            self.assertIn("course: stopped", process.stderr.read())
        self.assertEqual(process.returncode, 128 + signal.SIGTERM)
        self.assertEqual([path for path in self.out.rglob("*") if path.name.startswith(".")], [], "no half a file")
        begun = self.runs() - before
        done = len(list(self.out.glob("jobs/fake/*/[0-9]*.csv")))
        self.assertLessEqual(begun - done, os.cpu_count())
        self.succeed()
        self.assertEqual(self.runs() - before - begun, TRIALS - done, "the finished ones are not repeated")
        self.assertEqual(self.results(), whole)

    def test_a_failed_trial_is_named_and_the_others_stay(self):
        done = self.fake("--out", self.out, FAKE_FAILS="7")
        self.assertEqual(done.returncode, 1)
        self.assertIn("trial 7 fails, as it was told to", done.stderr)
        self.assertIn("fake, squares 8 of 10", done.stderr)
        begun = self.runs()
        self.assertFalse((self.out / "fake").exists())
        self.succeed()
        self.assertLess(self.runs(), begun + TRIALS)

    def test_results_of_another_program_are_not_reused(self):
        program = self.folder / "trials.py"
        shutil.copy(HERE / "fake_trials.py", program)
        self.succeed("--shard", "1/1", FAKE_PROGRAM=str(program))
        self.succeed("--shard", "1/1", FAKE_PROGRAM=str(program))
        self.assertEqual(self.runs(), TRIALS)
        program.write_text(program.read_text(encoding="utf-8").replace("k * k", "k * k * k"), encoding="utf-8")
        self.succeed(FAKE_PROGRAM=str(program))
        self.assertEqual(self.runs(), 2 * TRIALS)
        self.assertIn("squares,3,27\n", (self.out / "fake/csv/squares.csv").read_text(encoding="utf-8"))
