"""The grader elsewhere: as Gradescope's zip in that platform's folders, and as GitHub Classroom's workflow."""

import json
import os
import shutil
import subprocess
import tarfile
import unittest
import zipfile
from pathlib import Path
from unittest import mock

try:
    import yaml
except ImportError:
    yaml = None

from ch5_backend.course.base.errors import CourseError
from ch5_backend.course.grading import pack
from ch5_backend.course.grading.rubric import read_rubric
from ch5_backend.course.grading.student import tracked_files
from tests.folder import FolderTest
from tests.grading.grade_test import GRADER, environment
from tests.project import ROOT, run


class Packs(FolderTest):
    def pack(self, what: str, name: str, language: str = "en") -> Path:
        subprocess.run([ROOT / "course", "pack", what, "--out", self.folder / name, "--language", language], check=True,
                       capture_output=True)
        return self.folder / name

    def test_the_same_files_give_the_same_bytes(self):
        one, other = self.pack("gradescope", "one.zip"), self.pack("gradescope", "other.zip")
        self.assertEqual(one.read_bytes(), other.read_bytes())
        with zipfile.ZipFile(one) as archive:
            names = archive.namelist()
            self.assertTrue({"setup.sh", "run_autograder", "course", "CMakeLists.txt", "solutions/problem.cc"} <= set(names))
            self.assertEqual([name for name in names if name.startswith(("build", "out/", ".git/"))], [])
            self.assertTrue(archive.getinfo("run_autograder").external_attr >> 16 & 0o111)
            self.assertIn(b"--language en ", archive.read("run_autograder"))

    def test_the_containers_context_is_the_project_and_a_dockerfile(self):
        with tarfile.open(self.pack("container", "c.tar.gz", "zh")) as archive:
            names = set(archive.getnames())
            self.assertEqual(names, {*pack.project_files(), "Dockerfile"})
            self.assertEqual(archive.getmember("course").mode, 0o755)
            self.assertIn(b'"grade", "--language", "zh"', archive.extractfile("Dockerfile").read())

    def test_without_git_it_packs_what_is_not_built(self):
        listed = set(pack.project_files())
        with mock.patch("ch5_backend.course.grading.student.shutil.which", return_value=None):
            found = set(pack.project_files())
            self.assertLessEqual(listed, found)
            self.assertEqual([name for name in found if name.startswith(("build/", "out/", ".git/"))], [])
            self.assertRaisesRegex(CourseError, "only git knows", tracked_files)

    def workflow(self, what: str) -> dict:
        self.text = self.pack(what, f"{what}.yml", "zh").read_text(encoding="utf-8")
        self.assertNotIn("\t", self.text)
        return yaml.safe_load(self.text)

    @unittest.skipIf(yaml is None, "no python3-yaml")
    def test_the_students_workflow_has_no_key_and_reports_the_rubrics_points(self):
        job = self.workflow("classroom")["jobs"]["run-autograding-tests"]
        self.assertNotIn("secrets", self.text)
        self.assertNotIn("course grade", self.text)
        steps = {step["id"]: step["with"] for step in job["steps"] if "id" in step}
        points = {stage: sum(checks.values()) for stage, checks in read_rubric().items()}
        self.assertEqual({one["command"]: one["max-score"] for one in steps.values()},
                         {f"./course check {stage}": n for stage, n in points.items() if n})
        reporter = job["steps"][-1]
        self.assertEqual(reporter["with"]["runners"].split(","), list(steps))
        self.assertEqual(reporter["env"], {f"{own.upper()}_RESULTS": "${{ steps.%s.outputs.result }}" % own for own in steps})

    @unittest.skipIf(yaml is None, "no python3-yaml")
    def test_the_courses_workflow_shows_its_token_to_one_step(self):
        job = self.workflow("classroom-grading")["jobs"]["grade"]
        with_token = [step for step in job["steps"] if "secrets." in str(step)]
        self.assertEqual(len(with_token), 1)
        self.assertNotIn("course grade", with_token[0]["run"])
        self.assertIn("--out grades --language zh\n", self.text)

    @unittest.skipUnless(GRADER.exists(), "no Clang: without ./course grade")
    def test_gradescope_s_entry_point_in_gradescope_s_folders(self):
        """With CH5_LONG, built from the zip alone, in ten minutes; otherwise with this project in the zip's place."""
        platform, whole = self.folder / "autograder", "CH5_LONG" in os.environ
        for name in ("submission", "results", "unpacked"):
            (platform / name).mkdir(parents=True)
        unpacked = platform / "unpacked"
        subprocess.run(["unzip", "-q", self.pack("gradescope", "g.zip"), "-d", unpacked], check=True)
        (platform / "source").symlink_to(unpacked if whole else ROOT)
        shutil.copy(unpacked / "run_autograder", platform)
        shutil.copy(ROOT / "solutions" / "gauge_prior.cc", platform / "submission")
        self.folder.chmod(0o755)
        used = {key: value for key, value in os.environ.items() if not key.startswith("CH5_")} if whole else environment()
        used["AUTOGRADER"] = str(platform)
        for program in (unpacked / "setup.sh", platform / "run_autograder"):
            done = run(program, env=used)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        results = json.loads((platform / "results" / "results.json").read_text(encoding="utf-8"))
        earned = [test for test in results["tests"] if test["number"] == "3"]
        self.assertEqual(results["score"], sum(test["max_score"] for test in earned), results)
