"""./course lab: hands over to the builder of the page, and records what it was made of; the students' archive has the page."""

import shlex
from pathlib import Path

from ch5_backend.lab import build

from ..base import prebuilt
from ..base.build import ROOT
from ..base.errors import CourseError


def lab(folder: str) -> int:
    """Returns the exit code; raises CourseError."""
    if (ROOT / "lab.html").exists():
        return given()
    sources = prebuilt.lab_sources()  # as they are when the work begins
    code = build.lab(folder)
    if code == 0:
        prebuilt.record_lab(Path(folder or "out"), sources)
    return code


def given() -> int:
    """The page that came with the archive; CourseError(1) if the library is no longer the one that it was made of."""
    page = ROOT / "lab.html"
    if why_not := prebuilt.why_not_lab(ROOT):
        raise CourseError(f"{page} does not show this library: {why_not}; without it, ./course lab compiles another", 1)
    print(f"The lab: {page}   to open it: xdg-open {shlex.quote(str(page))}")
    return 0
