"""./course grade: the solutions get every point and the skeleton none, nothing is graded twice or lost, and whatever a
submission holds, its folder, its neighbors and the class's tables stay whole."""

import csv
import errno
import io
import json
import os
import re
import shutil
import signal
import subprocess
import time
import unittest
from concurrent.futures import ThreadPoolExecutor
from contextlib import redirect_stdout
import zipfile
from pathlib import Path
from unittest import mock
from xml.etree import ElementTree

from tests.folder import FolderTest
from tests.project import BUILD, ROOT, run
from ch5_backend.course.base.errors import CourseError
from ch5_backend.course.grading import job
from ch5_backend.course.grading.grade import share, tell
from ch5_backend.course.grading.handed_in import named
from ch5_backend.course.grading.outputs import gradescope
from ch5_backend.course.grading.rubric import read_rubric
from ch5_backend.course.grading.engines import choose
from ch5_backend.course.grading.sandbox import Outcome, Unguarded
from ch5_backend.course.grading.submission import Submission
from ch5_backend.course.grading.summary import notes
from ch5_backend.course.grading.toolchain import Built, Clock, Infrastructure, Toolchain
from ch5_backend.course.base.language import speaker
from ch5_backend.course.homework.diagnosis import Verdict, cause_of, in_short
from ch5_backend.figures.atomic_write import atomic_write

BIN = BUILD / "bin"
GRADER = BIN.parent / "grader" / "toolchain.json"


def grade(out: Path, *words, **options) -> subprocess.CompletedProcess:
    return run(ROOT / "course", "grade", *words, "--out", out, **options)


def environment() -> dict:
    return {**os.environ, "CH5_BUILD_DIR": str(BIN.parent)}


def hint_of(record: dict) -> str:
    """What the first stage's verdict says."""
    return in_short(record["stages"][0]["diagnosis"], speaker("en"))


def records(out: Path) -> dict:
    return {path.parent.name: json.loads(path.read_text(encoding="utf-8")) for path in out.glob("*/record.json")}


class Rubric(unittest.TestCase):
    def test_it_gives_points_to_every_check_and_a_hundred_in_all(self):
        rubric, stages = read_rubric(), json.loads((ROOT / "ch5_homework" / "stages.json").read_text())["stages"]
        printed = run(BIN / "homework_judge", "--gtest_list_tests", check=True)
        checks, suite = {}, ""
        for line in printed.stdout.splitlines():
            if line.startswith("  "):
                checks.setdefault(suite, []).append(line.strip())
            else:
                suite = line.strip(". ")
        self.assertEqual({stage["id"]: sorted(checks[stage["tests"].rstrip(".*")]) for stage in stages},
                         {stage: sorted(row) for stage, row in rubric.items()})
        self.assertEqual(sum(sum(row.values()) for row in rubric.values()), 100)


@unittest.skipUnless(GRADER.exists(), "no Clang: without ./course grade")
class Grades(FolderTest):
    def setUp(self):
        super().setUp()
        self.out = self.folder / "out"

    def submission(self, name: str, file: str = "gauge_prior.cc", change=lambda text: text, base="solutions") -> Path:
        path = self.folder / "submitted" / name
        path.mkdir(parents=True, exist_ok=True)
        text = (ROOT / base / file).read_text(encoding="utf-8")
        (path / file).write_text(change(text), encoding="utf-8")
        return path

    def test_the_solutions_get_every_point_and_the_skeleton_none(self):
        archive = self.folder / "skeleton.zip"
        with zipfile.ZipFile(archive, "w") as file:
            for path in (ROOT / "ch5_homework").glob("*.cc"):
                file.write(path, f"my homework/{path.name}")
        done = grade(self.out, ROOT / "solutions", archive, "--seed", "7", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        told = {record["name"]: record for record in json.loads(done.stdout)["records"]}
        self.assertEqual({name: (record["score"], record["points"]) for name, record in told.items()},
                         {"solutions": (100, 100), "skeleton.zip": (0, 100)})
        found = records(self.out)
        self.assertEqual({row["state"] for row in found["solutions"]["stages"]}, {"right"})
        self.assertEqual({row["state"] for row in found["skeleton.zip"]["stages"]}, {"not-started"})
        self.assertLess(max(margin for row in found["solutions"]["stages"] for margin in row["margins"].values()), 0.1,
                        "a right answer lies within ten times its tolerance")
        results = json.loads((self.out / "solutions" / "results.json").read_text(encoding="utf-8"))
        self.assertEqual((results["score"], sum(test["max_score"] for test in results["tests"])), (100, 100))
        suites = ElementTree.parse(self.out / "skeleton.zip" / "junit.xml").getroot()
        self.assertEqual({suite.get("tests") == suite.get("failures") for suite in suites}, {True})
        scores = json.loads((self.out / "solutions" / "autolab.json").read_text())["scores"]
        self.assertEqual(sum(scores.values()), 100)
        with open(self.out / "grades.csv", encoding="utf-8", newline="") as file:
            self.assertEqual([(row["name"], row["score"]) for row in csv.DictReader(file)],
                             [("skeleton.zip", "0"), ("solutions", "100")])
        self.assertIn("100 of 100 points", (self.out / "solutions" / "feedback.html").read_text(encoding="utf-8"))

    def test_who_only_deletes_the_throws_gets_nothing(self):
        paths = [self.submission(path.stem, path.name, lambda text: re.sub(r".*throw HomeworkMissing.*\n", "", text), "ch5_homework")
                 for path in (ROOT / "ch5_homework").glob("*.cc")]
        done = grade(self.out, *paths)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual({name: record["score"] for name, record in records(self.out).items()}, {path.name: 0 for path in paths})

    def test_a_wrong_stage_keeps_its_denominator_and_the_others_their_points(self):
        wrong = self.submission("wrong", change=lambda text: text.replace("i < 2", "i < 1"))
        broken = self.submission("broken", change=lambda text: text + "\nint x = ;\n")
        crash = self.submission("crash", change=lambda text: text.replace("i < 2; ++i) {", "i < 2; ++i) { *(volatile int*)0 = 0;"))
        call = "  AddMonoBaEdges(scene, pixel_information, prior_weight, problem);\n"
        endless = self.submission("endless", change=lambda text: text.replace("  for (", call + "  for (", 1))
        killed = self.submission("killed", change=lambda text: "#include <csignal>\n" + text.replace("  for (", "raise(SIGKILL); for (", 1))
        own = ("  const int n[]{problem->poses.size()};  // to Clang an error\n"
               "  Eigen::SelfAdjointEigenSolver<MatXX> eigen(MatXX::Identity(n[0], n[0]));\n")
        usual = self.submission("usual", change=lambda text: text.replace("  if (prior_weight", own + "  if (prior_weight", 1))
        many = "[[maybe_unused]] std::future<void> own[12]; for (auto& one : own) one = std::async(std::launch::async, [] { usleep(100000); });\n"
        threads = self.submission("threads", change=lambda text: "#include <unistd.h>\n#include <future>\n" + text.replace("  for (", many + "  for (", 1))
        done = grade(self.out, wrong, broken, crash, endless, killed, usual, threads, "--stages", "3,4")
        self.assertEqual(done.returncode, 0, done.stderr)
        found, points = records(self.out), sum(read_rubric()["3"].values())
        self.assertEqual({name: (record["stages"][0]["state"], record["stages"][0]["points"]) for name, record in found.items()},
                         {"wrong": ("wrong", points), "broken": ("does-not-compile", points), "crash": ("crashes", points),
                          "endless": ("crashes", points), "killed": ("crashes", points), "usual": ("right", points), "threads": ("right", points)})
        for name, words in (("endless", r"The stack is full at gauge_prior\.cc:\d+"), ("killed", r"Crash \(Killed\)")):
            self.assertRegex(hint_of(found[name]), words)
        self.assertTrue(0 < found["wrong"]["score"] < points and found["broken"]["score"] == 0)
        self.assertIn("broken", (self.out / "summary.html").read_text(encoding="utf-8"))
        self.assertRegex(hint_of(found["broken"]), r"gauge_prior\.cc:\d+:\d+: error: expected expression|error:")
        self.assertEqual(found["wrong"]["stages"][1]["state"], "missing")
        grade(self.folder / "trusted", broken, "--stages", "3", "--trust")
        self.assertRegex(hint_of(records(self.folder / "trusted")["broken"]), r"(?m)^gauge_prior\.cc:\d+", "no folder of ours")

    def test_killed_in_the_middle_it_goes_on_and_grades_nothing_twice(self):
        paths = [self.submission(f"s{k}", change=lambda text, k=k: text + f"\n// {k}\n") for k in range(4)]
        temporary = self.folder / "tmp"
        temporary.mkdir()
        self.folder.chmod(0o755)  # the sandbox's user comes in
        own = {**environment(), "TMPDIR": str(temporary)}
        process = subprocess.Popen([ROOT / "course", "grade", *paths, "--stages", "3", "--jobs", "1", "--out", self.out],
                                   stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                   env=own, start_new_session=True)
        for _ in range(6000):
            if records(self.out):
                break
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        before = {name: (self.out / name / "record.json").stat().st_mtime_ns for name in records(self.out)}
        self.assertTrue(0 < len(before) < 4, before)
        self.assertNotEqual(list(temporary.iterdir()), [])
        done = grade(self.out, *paths, "--stages", "3", env=own)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(list(temporary.iterdir()), [], "what the killed one has left")
        found = records(self.out)
        self.assertEqual([record["score"] for record in found.values()], [sum(read_rubric()["3"].values())] * 4)
        self.assertEqual(before, {name: (self.out / name / "record.json").stat().st_mtime_ns for name in before})
        self.assertEqual(len({record["seed"] for record in found.values()}), 1)

    def test_two_shards_and_a_last_run_are_one_run(self):
        paths = [self.submission(name, change=lambda text, k=k: text + f"\n// {k % 2}\n")
                 for k, name in enumerate(("s0", os.fsdecode(b"m\xfcller"), "s2"))]
        share = lambda part: grade(self.out, *paths, "--stages", "3", "--seed", "5", "--shard", part).returncode
        with ThreadPoolExecutor() as pool:
            self.assertEqual(list(pool.map(share, ("1/2", "2/2"))), [0, 0])
        whole = self.folder / "whole"
        self.assertEqual(grade(whole, *paths, "--stages", "3", "--seed", "5").returncode, 0)
        strip = lambda out: {name: (record["score"], record["key"], record["stages"][0]["checks"])
                             for name, record in records(out).items()}
        self.assertEqual(strip(self.out), strip(whole))
        self.assertEqual(set(strip(whole)), {"s0", "m_FCller", "s2"})  # read as UTF-8, as the table
        self.assertIn("m_FCller", (whole / "grades.csv").read_text(encoding="utf-8"))
        self.assertIn("equal", (whole / "summary.html").read_text(encoding="utf-8"), "s0 and s2 are one text")

    def test_a_fault_of_ours_is_no_mark_and_replaces_none(self):
        path = self.submission("one")
        self.assertEqual(grade(self.out, path, "--stages", "3", "--seed", "1").returncode, 0)
        mark = records(self.out)["one"]["score"]
        tools = self.folder / "tools"
        tools.mkdir()
        self.folder.chmod(0o755)  # nobody starts it
        (tools / "bwrap").write_text("#!/bin/sh\necho no namespace for you >&2\nexit 1\n")
        (tools / "bwrap").chmod(0o755)
        done = run(ROOT / "course", "grade", path, "--stages", "3", "--seed", "2", "--out", self.out, "--sandbox", "bubblewrap",
                   env={**environment(), "PATH": f"{tools}:{os.environ['PATH']}"})
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("no namespace for you", done.stderr)
        self.assertEqual(records(self.out)["one"]["score"], mark)

    def test_wrong_calls_are_refused(self):
        for words, told in ((["/nowhere/at/all"], "/nowhere/at/all: there is no such submission"),
                            ([ROOT / "solutions", "--stages", "9"], "unknown stage '9'"),
                            ([], "which submissions?")):
            done = grade(self.out, *words)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(told, done.stderr)


@unittest.skipUnless(GRADER.exists(), "no Clang: without ./course grade")
class Place(unittest.TestCase):
    def test_where_no_program_can_be_run_nobody_is_blamed(self):
        """As where TMPDIR is mounted as noexec: each worker would crash at once."""
        no_program = mock.patch("ch5_backend.course.grading.toolchain.shutil.which", return_value="/etc/passwd")
        with no_program, self.assertRaisesRegex(Infrastructure, "no program can be run in .*Permission denied"):
            Toolchain(choose()).prepare()


class FullDisk(FolderTest):
    def test_it_is_no_mark_and_is_told_with_its_place(self):
        with mock.patch.object(shutil, "disk_usage", return_value=mock.Mock(free=0)), \
                mock.patch.object(job, "judge", return_value=Verdict("crashes", {})):
            for judged in (lambda: job.run_stage(mock.Mock(box=Unguarded), Path("worker"), {}, 1, Clock()),
                           lambda: Toolchain._verdict(mock.Mock(), "problem.cc", Outcome(1, "error: ld", True, 1.0, 1.0), b"", Path("x"))):
                with self.assertRaisesRegex(Infrastructure, "0 MB left"):
                    judged()
        with self.assertRaises(OSError) as caught, atomic_write(self.folder / "table"):
            raise OSError(errno.ENOSPC, "No space left")
        self.assertEqual(caught.exception.filename, str(self.folder / "table"))
        with redirect_stdout(io.StringIO()) as told:
            failed = [{"name": "anna", "status": "infrastructure-error", "error": "full", "score": 0, "points": 7, "stages": []}]
            tell(self.folder, failed, [], mock.Mock(json=False, shard=None), speaker("en"))
        self.assertNotIn("anna", told.getvalue(), "no points, not even 0 of 7")


class TotalTime(FolderTest):
    def test_what_sleeps_is_not_judged_to_the_end_and_the_grader_is_told(self):
        """Each stage sleeps a little less than a check may; the next submission brings one of the files and has all its time."""
        allowed, known, judged = [], {}, Verdict("right", tests=({"name": "x", "result": "COMPLETED"},))

        def judge(executable, stage, time_limit, *_words, **_options):
            allowed.append(time_limit)
            time.sleep(min(time_limit, 0.4))
            return judged if time_limit >= 0.4 else Verdict("times-out")

        def cached(file, _stages, _content, make):
            result = known.get(file) or make()
            return known.setdefault(file, result) if result["complete"] else result
        stages = [{"id": name, "name": name, "file": f"{name}.cc", "todos": []} for name in "abc"]
        rubric = {stage["id"]: {"x": 1} for stage in stages}
        toolchain = mock.Mock(box=Unguarded, **{"compile.return_value": Built(Path("worker"), None, 1.0, 100.0), "solved.return_value": {}})
        with mock.patch.object(job, "judge", judge), mock.patch.object(job, "SECONDS_A_SUBMISSION", 0.6):
            asleep = job.grade(Submission("asleep", {f"{name}.cc": b"" for name in "abc"}), toolchain, stages, rubric, 1, cached)
            other = job.grade(Submission("other", {"b.cc": b""}), toolchain, stages, rubric, 1, cached)
        self.assertEqual([row["state"] for row in asleep["stages"]], ["right", "times-out", "times-out"], asleep)
        self.assertEqual([cause_of(row["diagnosis"]) for row in asleep["stages"]], ["", job.OUT_OF_TIME, job.OUT_OF_TIME])
        self.assertEqual((asleep["score"], other["stages"][1]["state"], list(known)), (1, "right", ["a.cc", "b.cc"]))
        self.assertEqual([round(seconds, 1) for seconds in allowed], [0.6, 0.2, 0.0, 0.6])
        told = notes([{**asleep, "name": "asleep"}, {**other, "name": "other"}], None, [], speaker("en"))
        self.assertEqual(told, ["Their checks took longer than 0.6 s altogether, so some stages were not judged: asleep"])


class Names(FolderTest):
    def test_submissions_of_one_name_are_told_apart_by_their_folders(self):
        paths = [self.folder / student / "homework.zip" for student in ("ada", "bob")] + [self.folder / "a\nb.zip"]
        for path in paths:
            path.parent.mkdir(exist_ok=True)
            path.touch()
        nowhere = self.folder / "nowhere"
        nowhere.symlink_to(nowhere)  # does not stop the class
        self.assertEqual(list(named([*paths, nowhere])), ["homework.zip", "bob-homework.zip", "a_b.zip", "nowhere"])

    def test_none_is_called_as_a_table_of_the_class_or_too_long(self):
        paths = [self.folder / "a" / "summary.html", self.folder / "a" / "grades.csv", self.folder / "a" / (250 * "b"),
                 self.folder / ".cache"]
        for path in paths:
            path.mkdir(parents=True)
        self.assertEqual(list(named(paths)), ["a-summary.html", "a-grades.csv", 200 * "b", "cache"])

    def test_names_keep_the_letters_of_any_language_and_differ(self):
        raw = [os.fsdecode(os.fsencode(self.folder) + b"/a/" + name) for name in (b"m\xfcller.zip", b"m\xf6ller.zip")]
        paths = [self.folder / "a" / name for name in ("张三.zip", "李四.zip", "a?.zip", "a*.zip", 70 * "王")] + [*map(Path, raw)]
        for path in paths:
            path.parent.mkdir(exist_ok=True)
            path.touch()
        self.assertEqual(list(named(paths)), ["张三.zip", "李四.zip", "a_.zip", "a-a_.zip", 66 * "王", "m_FCller.zip",
                                              "m_F6ller.zip"])
        with self.assertRaisesRegex(CourseError, "named twice"):
            named(2 * paths[:1])
        both = [Path("/same?"), Path("/same*")]  # no folder tells them apart
        self.assertEqual(len(named(both)), 2)

    def test_shares_are_all_of_it(self):
        names = {str(k): k for k in range(7)}
        parts = [share(names, (i, 3)) for i in (1, 2, 3)]
        self.assertEqual(sorted(name for part in parts for name in part), sorted(names))

    def test_gradescope_gets_no_score_from_a_fault_of_ours(self):
        self.assertNotIn("score", gradescope({"status": "infrastructure-error", "key": "", "seed": 1}))
