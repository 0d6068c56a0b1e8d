"""Formatting."""

import re
import shutil
import unittest

from tests.project import ROOT, run, tracked_files


class Style(unittest.TestCase):
    def test_sources_are_formatted(self):
        if not shutil.which("clang-format"):
            self.skipTest("clang-format is not installed")
        # The skeleton is generated: its form follows from the solutions'.
        sources = [str(path) for path in tracked_files(".h", ".cc") if path.parts[0] != "ch5_homework"]
        self.assertGreater(len(sources), 20, "the walk must have found the sources")
        done = run("clang-format", "--dry-run", "--Werror", *sources, cwd=ROOT)
        first = [line for line in done.stderr.splitlines() if "error:" in line]
        self.assertEqual(done.returncode, 0, "\n".join(["", *first[:20], "mend with: clang-format -i FILE"]))

    def test_clang_tidy_configuration_is_valid(self):
        if not shutil.which("clang-tidy"):
            self.skipTest("clang-tidy is not installed")
        done = run("clang-tidy", "--dump-config", "ch5_backend/graph/edge.cc", "--", cwd=ROOT)
        self.assertEqual(done.stderr, "")
        self.assertIn("readability-identifier-naming.ClassCase", done.stdout)

    def test_a_shell_takes_values_as_arguments(self):
        """Written into the script, a path with a blank would be two words."""
        written_in = re.compile(r"\bsh['\"], ['\"]-c['\"], f['\"]|shell=(?=True)")
        faults = [f"{path}:{number}" for path in tracked_files(".py")
                  for number, line in enumerate((ROOT / path).read_text(encoding="utf-8").split("\n"), 1) if written_in.search(line)]
        self.assertEqual(faults, [], "\n".join(["", *faults, 'use sh -c \'… "$0"\' VALUE']))

    def test_text_has_no_trailing_blanks_or_tabs(self):
        faults = [f"{path}:{number}" for path in tracked_files(".h", ".cc", ".py", ".txt")
                  for number, line in enumerate((ROOT / path).read_text(encoding="utf-8").split("\n"), 1)
                  if "\t" in line or line != line.rstrip()]
        self.assertEqual(faults, [], "\n".join(["", *faults]))
