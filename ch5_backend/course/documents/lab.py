"""./course lab: hands over to the builder of the page, and records what it was made of; the students' archive has the page."""

import shlex
from pathlib import Path

from ch5_backend.lab import assemble_page

from ..base import prebuilt
from ..base.cmake_build import ROOT
from ..base.errors import CourseError, warn


def lab(folder: str) -> int:
    """Returns the exit code; raises CourseError."""
    if not (ROOT / "solutions" / "problem.cc").exists():  # assembly for one processor is no source for another
        return given()
    sources = prebuilt.lab_sources()  # as they are when the work begins
    code = assemble_page.lab(folder)
    if code == 0:
        prebuilt.record_lab(Path(folder or "out"), sources)
    return code


def given() -> int:
    """The page that came with the students' archive; says so if the library is no longer the one that it was made of.

    Raises CourseError if there is none.
    """
    page = ROOT / "lab.html"
    if not page.exists():
        raise CourseError("this is the students' archive, packed without the lab, which only the project itself can compile")
    if why_not := prebuilt.why_not_lab(ROOT):
        warn(f"the lab shows the library as it was packed: {why_not}")
    print(f"The lab: {page}   to open it: xdg-open {shlex.quote(str(page))}")
    return 0
