"""The preset homework: what a grader without ./course sees of the skeleton, the solutions, and a file that is broken."""

import unittest
import xml.etree.ElementTree as xml

from ch5_backend.course.homework.regions import STAGES
from tests.homework.hand_in import SKELETONS, hand_in
from tests.project import BUILD, run

FOLDER = BUILD / "tests" / "homework" / "trial"


class PlainCTest(unittest.TestCase):
    def verdicts(self, label="homework"):
        """{name: (status, output)} of all tests with this label, and CTest's exit code."""
        report = BUILD / "trial_ctest" / "marks.xml"
        done = run("ctest", "--test-dir", BUILD / "trial_ctest", "-L", label, "-j2", "--output-junit", report)
        cases = xml.parse(report).getroot().iter("testcase")
        return {case.get("name"): (case.get("status"), case.findtext("system-out") or "") for case in cases}, done.returncode

    def test_what_the_preset_builds_is_there(self):
        done = run("cmake", "--build", BUILD, "--target", "homework_ready")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_skeleton_solutions_and_a_broken_file(self):
        hand_in(FOLDER, **SKELETONS)
        found, code = self.verdicts()
        checks = {name: words for name, (_, words) in found.items() if not name.endswith(".compiles")}
        self.assertNotEqual(code, 0)
        self.assertGreater(len(checks), 50)
        for stage in STAGES:
            self.assertTrue(any(name.startswith(f"stage_{stage['id']}.{stage['name']}.") for name in checks), stage["id"])
        for name, words in checks.items():
            self.assertEqual(found[name][0], "fail", name)
            self.assertIn("not-started", words, name)

        hand_in(FOLDER)
        found, code = self.verdicts()
        self.assertEqual((code, {status for status, _ in found.values()}), (0, {"run"}))

        (FOLDER / "gauge_prior.cc").write_text("nonsense\n", encoding="utf-8")
        found, code = self.verdicts("stage_[34]")
        self.assertNotEqual(code, 0)
        failed = {name for name, (status, _) in found.items() if status != "run"}
        self.assertEqual(failed, {name for name in found if name.startswith("stage_3.")})
        self.assertLess(len(failed), len(found), "stage 4 goes on")
        self.assertIn("gauge_prior.cc:1", found["stage_3.PriorWeight.compiles"][1])
