"""./course slides: hands over to the builder of the decks."""

import subprocess
import sys

from .build import ROOT
from .errors import CourseError


def slides(extra: list) -> int:
    """Runs slides/build.py and returns its exit code."""
    builder = ROOT / "slides" / "build.py"
    if not builder.exists():
        raise CourseError("there are no slides yet: slides/build.py is missing")
    return subprocess.run([sys.executable, str(builder), *extra]).returncode
