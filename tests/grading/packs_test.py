"""The grader elsewhere: as Gradescope's zip in that platform's folders, and as GitHub Classroom's workflow."""

import json
import os
import shutil
import subprocess
import unittest
import zipfile
from pathlib import Path
from unittest import mock

from ch5_backend.course.base.errors import CourseError
from ch5_backend.course.grading import pack
from ch5_backend.course.grading.student import tracked_files
from tests.folder import FolderTest
from tests.grading.grade_test import GRADER, environment
from tests.project import ROOT


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

    def test_without_git_it_packs_what_is_not_built(self):
        listed = set(pack.project_files())
        with mock.patch("ch5_backend.course.grading.student.shutil.which", return_value=None):
            found = set(pack.project_files())
            self.assertLessEqual(listed, found)
            self.assertEqual([name for name in found if name.startswith(("build/", "out/", ".git/"))], [])
            self.assertRaisesRegex(CourseError, "only git knows", tracked_files)

    def test_the_workflow_is_yaml_that_runs_the_grader(self):
        text = self.pack("classroom", "classroom.yml", "zh").read_text(encoding="utf-8")
        self.assertIn("./course/course grade submission --out grades --language zh\n", text)
        self.assertNotIn("\t", text)

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
            done = subprocess.run([program], env=used, capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        results = json.loads((platform / "results" / "results.json").read_text(encoding="utf-8"))
        earned = [test for test in results["tests"] if test["number"] == "3"]
        self.assertEqual(results["score"], sum(test["max_score"] for test in earned), results)
