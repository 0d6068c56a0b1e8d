"""Points: each check of a stage has some, in its row of ch5_homework/stages.json. What is missing or crashes keeps its points
in the denominator."""

import math

from ..base.errors import CourseError
from ..homework.regions import STAGES, STAGE_TABLE


def read_rubric() -> dict:
    """{stage: {check: points}}. Raises CourseError if the table does not say that."""
    rubric = {stage["id"]: {name: check.get("points") for name, check in stage["checks"].items()} for stage in STAGES if "checks" in stage}
    for stage, checks in rubric.items():
        for check, points in checks.items():
            if isinstance(points, bool) or not isinstance(points, (int, float)) or not 0 <= points <= 1000:
                raise CourseError(f"{STAGE_TABLE}: stage {stage}, check {check}: points must be a number from 0 to 1000, got {points!r}")
    return rubric


def marks(checks: dict, passed: set) -> list:
    """[{"name", "points", "score", "passed"}], a row for each check of the rubric whether it was run or not."""
    return [{"name": name, "points": points, "score": points if name in passed else 0, "passed": name in passed}
            for name, points in checks.items()]


def mark(record: dict, rubric: dict) -> dict:
    """The record with the points of this rubric. What was judged, which checks pass and which blanks are right, is not touched:
    points are made of it at any time, and nothing is compiled for them."""
    for row in record["stages"]:
        row["checks"] = marks(rubric[row["id"]], {check["name"] for check in row["checks"] if check["passed"]})
        row["points"], passed = sum(check["points"] for check in row["checks"]), sum(check["score"] for check in row["checks"])
        row["score"] = max(passed, share(row))
        row["followed"] = row["score"] > passed
    record.update(score=round(sum(row["score"] for row in record["stages"]), 6), points=sum(row["points"] for row in record["stages"]))
    return record


def share(row: dict) -> float:
    """Of the points of a stage that is right with some of its blanks replaced: that of the others, rounded down to half a
    point."""
    if not row.get("replaced"):
        return 0.0
    return math.floor(2.0 * row["points"] * (row["blanks"] - len(row["replaced"])) / row["blanks"]) / 2.0
