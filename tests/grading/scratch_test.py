"""What a killed ./course has left behind goes with the next one; what a living one needs stays."""

import os
import subprocess
import sys
from pathlib import Path

from tests.folder import FolderTest
from tests.project import ROOT

HOLD = "import sys; from ch5_backend.course.base.scratch import scratch; (scratch() / 'file').touch(); print(scratch(), flush=True); sys.stdin.read()"


class Scratch(FolderTest):
    def run_one(self) -> tuple:
        """(process, its folder)"""
        process = subprocess.Popen([sys.executable, "-c", HOLD], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                   env={**os.environ, "TMPDIR": str(self.folder), "PYTHONPATH": str(ROOT)})
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process, Path(process.stdout.readline().strip())

    def test_only_the_dead_ones_folder_is_removed(self):
        (dead, left), (_, needed) = self.run_one(), self.run_one()
        dead.kill()
        dead.wait()
        self.assertTrue(left.exists())
        last, own = self.run_one()
        self.assertEqual(sorted(self.folder.iterdir()), sorted([needed, own]))
        self.assertTrue((needed / "file").exists())
        last.communicate()
        self.assertEqual(list(self.folder.iterdir()), [needed], "who ends takes his folder with him")

    def test_what_only_looks_like_one_stays(self):
        file, link = self.folder / "course-scratch.file", self.folder / "course-scratch.link"
        file.touch()
        (self.folder / "mine").mkdir()
        link.symlink_to(self.folder / "mine")
        self.run_one()
        self.assertTrue(file.exists() and link.exists())
