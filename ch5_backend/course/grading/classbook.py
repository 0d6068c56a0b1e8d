"""A class: who is in it, what of theirs counts, and what a human has decided. class.csv and the records give one row a student.

class.csv is a sheet, or an export of Canvas's or Moodle's gradebook; its header names the columns, in any order:

    id, or ID, or ID number     whatever the platform writes into the name of a submission
    name, or Student, or First name and Last name
    submissions                 names of theirs that do not hold the id, parted by ;
    handed_in                   2026-12-01T18:30, by ; in the order of the names; without it the time of the file counts
    excused                     days that are not late
    override                    1.2=10; 4=8.5: the points of a stage; needs a reason
    reason                      of the override
    read WHAT /10               any number of these: points of 10 for what no machine reads

All other columns are left alone, and come back in the platform's tables.
"""

import csv
import math
import re
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

from ..base.errors import CourseError

ID, NAME = ("id", "ID", "ID number"), ("name", "Student", "Full name")
READ = re.compile(r"read (?P<what>.+?) */ *(?P<points>\d+(\.\d+)?)")


@dataclass
class Student:
    id: str
    name: str
    cells: dict                                     # the row as it was read
    submissions: list = field(default_factory=list)
    handed_in: list = field(default_factory=list)   # times, in the order of the submissions
    excused: float = 0.0
    override: dict = field(default_factory=dict)    # {stage: points}
    reason: str = ""
    read: dict = field(default_factory=dict)        # {what: points, or None if nobody has read it}


@dataclass
class Class:
    students: list
    columns: list            # of the sheet
    read: dict               # {what: points at most}
    due: datetime = None
    percent_a_day: float = 10.0
    keep: str = "last"       # or "best"


@dataclass
class Mark:
    """A student's row; `record` is the submission that counts, None where there is none."""
    student: Student
    record: dict = None
    stages: dict = field(default_factory=dict)  # {stage: points}, overridden where a human has said so
    days_late: int = 0
    lost: float = 0.0       # points, for lateness
    handed_in: datetime = None

    @property
    def judged(self) -> float:
        return sum(self.stages.values()) - self.lost

    @property
    def total(self):
        """None where a fault of ours has prevented a mark."""
        failed = self.record and self.record["status"] != "graded" and not self.student.override
        return None if failed else round(self.judged + sum(points or 0.0 for points in self.student.read.values()), 2)


# ---- Reading --------------------------------------------------------------------------------------------------------

def read_class(path: Path, points: dict) -> Class:
    """`points` is {stage: its points}. Raises CourseError that names file, line and value."""
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file)
            rows = []
            for row in reader:
                if None in row:
                    refuse(path, reader.line_num, "more cells than the header has", row[None][0])
                rows.append((reader.line_num, {key.strip(): (value or "").strip() for key, value in row.items()}))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise CourseError(f"{path}: cannot be read as a table: {error}") from error
    columns = [column.strip() for column in reader.fieldnames or []]
    id_column = next((column for column in ID if column in columns), None)
    if id_column is None or not ({"First name", "Last name"} <= set(columns) or set(NAME) & set(columns)):
        raise CourseError(f"{path}:1: needs the columns id and name, got '{', '.join(columns)}'")
    read = {found["what"]: float(found["points"]) for column in columns if (found := READ.fullmatch(column))}
    students, seen = [], {}
    for line, cells in rows:
        if not cells[id_column]:
            continue  # Canvas's line of possible points
        if cells[id_column] in seen:
            refuse(path, line, f"this id stands in line {seen[cells[id_column]]} too", cells[id_column])
        seen[cells[id_column]] = line
        students.append(read_student(path, line, cells, cells[id_column], points, columns))
    if not students:
        raise CourseError(f"{path}: nobody is in it")
    return Class(students, columns, read)


def read_student(path: Path, line: int, cells: dict, id: str, points: dict, columns: list) -> Student:
    name = next((cells[column] for column in NAME if column in cells), None)
    student = Student(id, name if name is not None else f"{cells['First name']} {cells['Last name']}", cells)
    student.submissions = parts(cells.get("submissions", ""))
    student.handed_in = [read_time(f"{path}:{line}", text) for text in parts(cells.get("handed_in", ""))]
    student.excused = number(path, line, "excused", cells.get("excused") or "0", 0, 1000)
    for part in parts(cells.get("override", "")):
        stage, _, value = (piece.strip() for piece in part.partition("="))
        if stage not in points:
            refuse(path, line, "override: such as 1.2=10; there are the stages " + ", ".join(points), part)
        student.override[stage] = number(path, line, f"override of {stage}", value, 0, points[stage])
    student.reason = cells.get("reason", "")
    if student.override and not student.reason:
        refuse(path, line, "an override needs its reason", cells["override"])
    for column in columns:
        if found := READ.fullmatch(column):
            text = cells[column]
            student.read[found["what"]] = number(path, line, column, text, 0, float(found["points"])) if text else None
    return student


def parts(text: str) -> list:
    return [part.strip() for part in text.split(";") if part.strip()]


def refuse(path: Path, line: int, what: str, value: str):
    raise CourseError(f"{path}:{line}: {what}, got '{value}'")


def number(path: Path, line: int, what: str, text: str, low: float, high: float) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not low <= value <= high:
        refuse(path, line, f"{what}: must be a number from {low:g} to {high:g}", text)
    return value


def read_time(place: str, text: str) -> datetime:
    """A time with its zone, or the machine's."""
    try:
        return datetime.fromisoformat(text).astimezone()
    except ValueError as error:
        raise CourseError(f"{place}: a time is written 2026-12-01T18:30, got '{text}'") from error


# ---- Settling -------------------------------------------------------------------------------------------------------

def settle(book: Class, records: list, points: dict) -> tuple:
    """(a mark for each student, the names of submissions that are nobody's). Raises CourseError if one has two owners."""
    owned, nobodys = {student.id: [] for student in book.students}, []
    for record in records:
        owners = owners_of(book.students, record)
        if len(owners) > 1:
            raise CourseError(f"{record['name']}: is it {' or '.join(f'{owner.id} ({owner.name})' for owner in owners)}? "
                              "Name it in the column submissions of one of them")
        for owner in owners:
            owned[owner.id].append(record)
        nobodys += [] if owners else [record["name"]]
    return [mark_of(book, student, owned[student.id], points) for student in book.students], nobodys


def owners_of(students: list, record: dict) -> list:
    """Who names it; else whose id stands in its name, as a word; else in that of its folder."""
    named = [student for student in students if record["name"] in student.submissions]
    for text in [record["name"], Path(record["path"]).parent.name]:
        named = named or [student for student in students
                          if re.search(rf"(?<![^\W_]){re.escape(student.id)}(?![^\W_])", text, re.IGNORECASE)]
    return named


def mark_of(book: Class, student: Student, records: list, points: dict) -> Mark:
    if len(student.handed_in) > max(1, len(student.submissions)):
        raise CourseError(f"{student.id}: {len(student.handed_in)} times in the column handed_in for "
                          f"{len(student.submissions)} submissions")
    marks = [mark_with(book, student, record, points) for record in records]
    if not marks:
        return mark_with(book, student, None, points)
    by = (lambda mark: (mark.judged, mark.handed_in)) if book.keep == "best" else (lambda mark: mark.handed_in)
    return max(marks, key=by)


def mark_with(book: Class, student: Student, record, points: dict) -> Mark:
    """The mark if this is the submission that counts."""
    mark = Mark(student, record)
    judged = {row["id"]: row["score"] for row in record["stages"]} if record else {}
    mark.stages = {stage: student.override.get(stage, judged.get(stage, 0.0)) for stage in points}
    if record:
        mark.handed_in = time_of(student, record)
        if book.due:
            late = (mark.handed_in - book.due).total_seconds() / 86400.0 - student.excused
            mark.days_late = max(0, math.ceil(late))
            mark.lost = round(min(1.0, mark.days_late * book.percent_a_day / 100.0) * sum(mark.stages.values()), 2)
    return mark


def time_of(student: Student, record: dict) -> datetime:
    place = student.submissions.index(record["name"]) if record["name"] in student.submissions else 0
    if place < len(student.handed_in):
        return student.handed_in[place]
    return datetime.fromisoformat(record["handed_in"])


# ---- Tables ---------------------------------------------------------------------------------------------------------

def tables(book: Class, marks: list, points: dict, assignment: str) -> dict:
    """{file: rows}: students.csv with everything, and what Canvas and Moodle take."""
    most = sum(points.values()) + sum(book.read.values())
    shown = lambda value: "" if value is None else f"{value:g}"
    head = ["id", "name", "submission", "handed_in", "days_late", *(f"stage {stage}" for stage in points), "lost_late",
            *(f"read {what}" for what in book.read), "total", "of", "override", "reason"]
    rows = [[mark.student.id, mark.student.name, mark.record["name"] if mark.record else "",
             mark.handed_in.isoformat(timespec="minutes") if mark.record else "", mark.days_late,
             *(shown(score) for score in mark.stages.values()), shown(mark.lost),
             *(shown(score) for score in mark.student.read.values()), shown(mark.total), shown(most),
             mark.student.cells.get("override", ""), mark.student.reason] for mark in marks]
    kept = ["Student", "ID", "SIS User ID", "SIS Login ID", "Section"]
    own = lambda student: {key: student.cells[key] for key in kept if key in student.cells}
    ours = lambda student: {"Student": student.name, "ID": student.id, **own(student)}
    canvas = [[*kept, assignment], ["    Points Possible", "", "", "", "", shown(most)],
              *([ours(mark.student).get(column, "") for column in kept] + [shown(mark.total)] for mark in marks)]
    email = [column for column in ("Email address",) if column in book.columns]
    moodle = [["ID number", "Full name", *email, assignment, "Feedback comments"],
              *([mark.student.id, mark.student.name, *(mark.student.cells[column] for column in email), shown(mark.total),
                 mark.student.reason] for mark in marks)]
    return {"students.csv": [head, *rows], "canvas.csv": canvas, "moodle.csv": moodle}
