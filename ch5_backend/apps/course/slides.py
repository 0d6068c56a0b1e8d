"""./course slides: hands over to the builder of the decks."""

import sys

from .build import ROOT
from .children import running
from .errors import CourseError


def slides(extra: list) -> int:
    """Runs slides/build.py and returns its exit code."""
    builder = ROOT / "slides" / "build.py"
    if not builder.exists():
        raise CourseError("there are no slides yet: slides/build.py is missing")
    with running([sys.executable, str(builder), *extra]) as process:
        return process.wait()
