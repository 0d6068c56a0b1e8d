"""Points: each check of a stage has some, in ch5_homework/rubric.json. What is missing or crashes keeps its points in the
denominator."""

import json

from ..base.cmake_build import ROOT
from ..base.errors import CourseError

PATH = ROOT / "ch5_homework" / "rubric.json"


def read_rubric() -> dict:
    """{stage: {check: points}}. Raises CourseError if the file does not say that."""
    try:
        stages = json.loads(PATH.read_text(encoding="utf-8"))["stages"]
        for stage, checks in stages.items():
            for check, points in checks.items():
                if isinstance(points, bool) or not isinstance(points, (int, float)) or not 0 <= points <= 1000:
                    raise CourseError(f"{PATH}: stage {stage}, check {check}: points must be a number from 0 to 1000, got {points!r}")
        return stages
    except (OSError, ValueError, KeyError, AttributeError, TypeError) as error:
        raise CourseError(f"{PATH}: this is no rubric: {error}") from error


def marks(checks: dict, passed: set) -> list:
    """[{"name", "points", "score", "passed"}], a row for each check of the rubric whether it was run or not."""
    return [{"name": name, "points": points, "score": points if name in passed else 0, "passed": name in passed}
            for name, points in checks.items()]
