"""./course slides: makes the tables that are missing, and hands over to the builder of the decks."""

import sys

from slides.browser import BuildError
from slides.decks import choose

from ..base.cmake_build import ROOT
from ..base.errors import CourseError
from ..base.processes import running
from ..experiments.figure_sets import SETS
from ..base.output_dir import made_dir
from ..experiments.plots import make_missing


def refuse(names: list) -> None:
    """Raises CourseError for the name of no deck, before minutes are spent on tables."""
    try:
        choose(names)
    except BuildError as error:
        raise CourseError(str(error)) from error


def slides(arguments, extra: list) -> int:
    """Runs slides/build.py and returns its exit code. With --csv in `extra`, only the tables there are used."""
    refuse(arguments.names)
    words = [f"--{option}" for option in ("html", "check") if getattr(arguments, option)] + arguments.names + extra
    if not arguments.check and (code := build_decks("--tools", *words)):  # before minutes are spent on tables
        return code
    if "--csv" not in extra:
        out = ROOT / "out"
        with made_dir(out):
            decks = tuple(f"slides/{name[:1]}" for name in arguments.names) or "slides/"
            make_missing([one for one in SETS if one.name.startswith(decks)], out)
    return build_decks(*words)


def build_decks(*words) -> int:
    with running([sys.executable, "-B", "-m", "slides.build", *words]) as process:
        return process.wait()
