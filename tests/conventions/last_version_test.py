"""Programs that were written for the last version compile today, as Semantic Versioning promises."""

import io
import tarfile
import tempfile
import unittest

from tests.conventions.consumer_test import LAUNCHER, call, install
from tests.project import BUILD, CXX, ROOT, run

EXAMPLES = "ch5_backend/examples"
UNRELEASED = "## Unreleased"


def last_version() -> str:
    """The commit before the changelog, or after a release, got its part "Unreleased"; "" in a copy without history."""
    log = run("git", "log", "-1", "--format=%H", f"-S{UNRELEASED}", "--", ".github/CHANGELOG.md", cwd=ROOT)
    commit = log.stdout.strip()
    if not commit or run("git", "rev-parse", "--verify", "--quiet", f"{commit}^", cwd=ROOT).returncode:
        return ""
    is_begun = UNRELEASED in run("git", "show", f"{commit}:.github/CHANGELOG.md", cwd=ROOT, check=True).stdout
    return f"{commit}^" if is_begun else commit


class LastVersion(unittest.TestCase):
    def test_its_examples_compile(self):
        commit = last_version()
        if not commit:
            self.skipTest("no history")
        with tempfile.TemporaryDirectory() as folder:
            archive = run("git", "archive", commit, EXAMPLES, cwd=ROOT, check=True, text=False).stdout
            with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
                names = tar.getnames()
                tar.extractall(folder)
            self.assertIn(f"{EXAMPLES}/own_camera.cc", names)
            build = f"{folder}/build"
            call("cmake", "-G", "Ninja", "-S", f"{folder}/{EXAMPLES}", "-B", build, *LAUNCHER,
                 f"-DCMAKE_PREFIX_PATH={install(BUILD)}", f"-DCMAKE_CXX_COMPILER={CXX}", "-DCMAKE_CXX_FLAGS=-O0")
            call("cmake", "--build", build, "--parallel", "2")
