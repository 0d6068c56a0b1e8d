"""clang-tidy, with .clang-tidy's rules, on the lines that differ from the main branch; `.ci/run tidy` looks at everything."""

import re
import shutil
import tempfile
import unittest
from pathlib import Path

from tests.project import BUILD, ROOT, run

# The Python module is a project of its own, whose commands are not among the build's.
SOURCES = r".*(ch5_backend/(?!python/)|ch5_homework/judge/|solutions/|tests/).*\.(h|cc)"


def git(*words) -> str:
    return run("git", *words, cwd=ROOT, check=True).stdout


def faults_in(diff: str) -> str:
    """What clang-tidy says of the lines that a diff (without context) adds, or ""."""
    commands = (BUILD / "compile_commands.json").read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:  # the build's commands without what is GCC's: headers, collecting garbage
        commands = re.sub(r"-include \S+cmake_pch\.hxx |--param=ggc\S+ ", "", commands)
        Path(folder, "compile_commands.json").write_text(commands, encoding="utf-8")
        done = run("clang-tidy-diff", "-p1", "-quiet", "-path", folder, "-regex", SOURCES, "-j", "2", cwd=ROOT, input=diff)
    return "".join(line for line in done.stdout.splitlines(True) if "error:" in line)


class Tidy(unittest.TestCase):
    def setUp(self):
        if not shutil.which("clang-tidy-diff"):
            self.skipTest("clang-tidy is not installed")
        if not (ROOT / ".git").exists():
            self.skipTest("only a clone knows what has changed")

    def test_what_is_changed_keeps_the_rules(self):
        branches = git("for-each-ref", "--format=%(refname)", "refs/remotes/origin/main", "refs/heads/main").split()
        diff = git("diff", "-U0", "--no-color", git("merge-base", "HEAD", branches[-1] if branches else "HEAD").strip())
        self.assertEqual(faults_in(diff), "")
