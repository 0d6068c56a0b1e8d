"""A class: what of a student's submissions counts, and what a human has decided. The class's table and the records give one
row a student. Beside id and name (see roster), a sheet may have these columns, in any order:

    submissions                 their submissions whose name does not say so, separated by ;
    handed_in                   2026-12-01T18:30, by ; in the order of the names; without it the platform's time counts, else the file's
    excused                     days that are not late
    override                    1.2=10; 4=8.5: the points of a stage, late or not; needs a reason
    reason                      of the override
    read WHAT /10               any number of these: points of 10 for what no machine reads

A number that is not known is None and an empty cell, never 0: of a stage in a file that could not be read, of a submission
that two may claim, of a student who has handed in nothing.
"""

import math
import re
import unicodedata
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from pathlib import Path

from ..base.errors import CourseError
from ..base.language import sentence
from .owners import CANVAS, folded, look_alike, owners_of, squeezed
from .roster import FIRST, IDS, LAST, Table, id_of, name_of, participant, read_table

READ = re.compile(r"read (?P<what>.+?) */ *(?P<points>\d+(\.\d+)?)", re.IGNORECASE)
DECIDED = ("submissions", "handed_in", "excused", "override", "reason")
SENT = ("last modified (submission)", "最后修改（学生）", "最后修改（提交）")
SENT_AS = ("%A, %d %B %Y, %I:%M %p", "%A, %B %d, %Y, %I:%M %p", "%Y-%m-%d %H:%M", "%Y-%m-%d %H:%M:%S")
CHINESE_TIME = re.compile(r"(\d{4})年(\d+)月(\d+)日\D*?(上午|下午)?\s*(\d+):(\d+)\D*")


@dataclass
class Student:
    id: str
    name: str
    row: list                                       # of the table, as it was read
    keys: set = field(default_factory=set)          # all that they are called by, folded
    names: set = field(default_factory=set)         # squeezed, in either order
    numbers: dict = field(default_factory=dict)     # {platform: its number of this student}
    submissions: list = field(default_factory=list)
    handed_in: list = field(default_factory=list)   # times, in the order of the submissions
    sent: datetime = None                           # when the platform has got the last one
    excused: float = 0.0
    override: dict = field(default_factory=dict)    # {stage: points}
    reason: str = ""
    read: dict = field(default_factory=dict)        # {what: points, or None if nobody has read it}


@dataclass
class Class:
    students: list
    table: Table
    read: dict                                      # {what: points at most}
    due: dict = field(default_factory=dict)         # {stage: the end of its time}
    percent_a_day: float = 10.0
    keep: str = "last"                              # or "best"
    column: str = "Chapter 5"                       # in the gradebook


@dataclass
class Mark:
    """A student's row."""
    student: Student
    records: dict = field(default_factory=dict)     # {stage: the submission that counts}
    stages: dict = field(default_factory=dict)      # {stage: points, overridden where a human has said so; None if unknown}
    days: dict = field(default_factory=dict)        # {stage: days late}
    losses: dict = field(default_factory=dict)      # {stage: points, for lateness}
    handed_in: datetime = None                      # of the last that counts
    time_from: str = ""                             # sheet, platform or file
    doubts: list = field(default_factory=list)      # sentences: why there is no mark

    @property
    def record(self):
        """The last submission that counts, or None."""
        return max(self.records.values(), key=lambda record: record["handed_in"], default=None)

    @property
    def days_late(self) -> int:
        return max(self.days.values(), default=0)

    @property
    def lost(self) -> float:
        return round(sum(self.losses.values()), 2)

    @property
    def total(self):
        """None where it is not known."""
        decided = self.student.override or any(points is not None for points in self.student.read.values())
        if None in self.stages.values() or not (self.records or decided):
            return None
        return round(sum(self.stages.values()) - self.lost + sum(points or 0.0 for points in self.student.read.values()), 2)


# ---- Reading --------------------------------------------------------------------------------------------------------

def read_class(path: Path, points: dict) -> Class:
    """`points` is {stage: its points}. Raises CourseError that names file, line and value."""
    table = read_table(path)
    named = table.platform or (table.place(*IDS) >= 0 and (table.place("name", "姓名", "student", "full name") >= 0 or
                                                           table.place(*FIRST) >= 0 <= table.place(*LAST)))
    if not named:
        raise CourseError(f"{path}:1: needs the columns id and name (学号, 姓名), or is an export of Canvas, Moodle or Gradescope, "
                          f"got '{', '.join(column.strip() for column in table.header)}'")
    columns = [column.strip().lower() for column in table.header]
    if twice := [column for column in columns if columns.count(column) > 1 and (column in DECIDED or READ.fullmatch(column))]:
        refuse(path, 1, "this column is there twice", twice[0])
    read = {found["what"]: float(found["points"]) for column in table.header if (found := READ.fullmatch(column.strip()))}
    students, seen = [], {}
    for line, cells in table.rows:
        id = id_of(table, line, cells)
        if not id:
            continue
        if folded(id) in seen:
            refuse(path, line, f"this id is also in line {seen[folded(id)]}", id)
        seen[folded(id)] = line
        students.append(read_student(table, line, cells, id, points))
    if not students:
        raise CourseError(f"{path}: nobody is in it")
    return Class(students, table, read)


def read_student(table: Table, line: int, cells: list, id: str, points: dict) -> Student:
    path, cell = table.path, lambda *names: table.cell(cells, *names)
    student = Student(id, name_of(table, cells) or id, cells)
    calls = [id, *(cell(name) for name in IDS if name != "identifier")]
    calls += [local for call in calls if len(local := call.partition("@")[0]) > 5 or re.search(r"\d", local)]
    student.keys = set(map(folded, filter(None, calls)))
    first, last = cell(*FIRST), cell(*LAST)
    words = student.name.replace(",", " ").split()
    turned = ("".join(words[k:] + words[:k]) for k in range(len(words)))  # family name first or last, of one word or more
    student.names = set(map(squeezed, (*turned, first + last, last + first))) - {""}
    if table.platform == "worksheet":
        student.numbers["moodle"] = participant(table, cells)
    if table.platform == "canvas":
        student.numbers["canvas"] = cell("id")
    student.submissions = parts(cell("submissions"))
    student.handed_in = [read_time(f"{path}:{line}", text) for text in parts(cell("handed_in"))]
    if len(student.handed_in) > max(1, len(student.submissions)):
        refuse(path, line, f"{len(student.handed_in)} times in the column handed_in for {len(student.submissions)} submissions",
               cell("handed_in"))
    student.sent = platform_time(cell(*SENT))
    student.excused = number(path, line, "excused", cell("excused") or "0", 0, 1000)
    for part in parts(cell("override")):
        stage, _, value = (piece.strip() for piece in part.partition("="))
        if stage not in points:
            refuse(path, line, "override: such as 1.2=10; there are the stages " + ", ".join(points), part)
        if stage in student.override:
            refuse(path, line, f"override of {stage} is there twice", cell("override"))
        student.override[stage] = number(path, line, f"override of {stage}", value, 0, points[stage])
    student.reason = cell("reason")
    if student.override and not student.reason:
        refuse(path, line, "an override needs its reason", cell("override"))
    for column, text in zip(table.header, cells):
        if found := READ.fullmatch(column.strip()):
            text = text.strip()
            student.read[found["what"]] = number(path, line, column.strip(), text, 0, float(found["points"])) if text else None
    return student


def parts(text: str) -> list:
    """A list by ; or the wide ；, as in 4＝8.5；5＝9."""
    return [part.strip() for part in unicodedata.normalize("NFKC", text).split(";") if part.strip()]


def refuse(path: Path, line: int, what: str, value: str):
    raise CourseError(f"{path}:{line}: {what}, got '{value}'")


def number(path: Path, line: int, what: str, text: str, low: float, high: float) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not low <= value <= high:
        refuse(path, line, f"{what}: must be a number from {low:g} to {high:g}", text)
    return value + 0.0  # no -0


def read_time(place: str, text: str, length=timedelta()) -> datetime:
    """A time with its zone, or the machine's, and so much later."""
    try:
        return datetime.fromisoformat(text).astimezone() + length
    except (ValueError, OverflowError) as error:
        raise CourseError(f"{place}: a time is written 2026-12-01T18:30, got '{text}'") from error


def read_due(text: str, stages) -> dict:
    """{stage: the end of its time} of "2026-12-01T23:59; 4=2026-12-08T23:59": a time without a stage is that of all others. Up to
    the end of the minute, the second or the day that is named."""
    due = {}
    for part in parts(text):
        stage, given, time = ("", "", part) if "=" not in part else (piece.strip() for piece in part.partition("="))
        if given and stage not in stages:
            raise CourseError(f"--due: such as 4=2026-12-08T23:59; there are the stages {', '.join(stages)}, got '{part}'")
        colons = re.sub(r"[+-]\d\d:\d\d$", "", time).count(":")
        length = timedelta(days=1) if ":" not in time and "T" not in time else timedelta(minutes=1) if colons < 2 else timedelta(seconds=1)
        if stage in due:
            raise CourseError(f"--due: two times for {stage or 'all others'}, got '{text}'")
        due[stage] = read_time("--due", time, length)
    others = due.get("")
    return {stage: due.get(stage, others) for stage in stages if stage in due or others}


def platform_time(text: str):
    """What Moodle writes into a worksheet, in English or Chinese; None for "-" and all else."""
    if found := CHINESE_TIME.fullmatch(text):
        year, month, day, half, hour, minute = found.groups()
        hour = int(hour) % 12 + 12 * (half == "下午") if half else int(hour)
        return datetime(int(year), int(month), int(day), hour, int(minute)).astimezone()
    for form in SENT_AS:
        try:
            return datetime.strptime(text, form).astimezone()
        except ValueError:
            pass
    return None


# ---- Settling -------------------------------------------------------------------------------------------------------

def settle(book: Class, records: list, points: dict) -> tuple:
    """(a mark for each student, [(a submission without one owner, why)]). Where two may claim one, neither has a mark."""
    owned, claimed, lost = {student.id: [] for student in book.students}, {}, []
    for record in records:
        owners = owners_of(book.students, record)
        given = all(map(names_it(record), owners)) or record.get("submitters")
        if len(owners) > 1 and not given:
            names = ", ".join(f"{owner.id} ({owner.name})" for owner in owners)
            lost.append((record["name"], sentence("grade.whose", names={"quoted": names})))
            for owner in owners:
                claimed.setdefault(owner.id, []).append(record["name"])
            continue
        for owner in owners:
            owned[owner.id].append(record)
        if not owners:
            alike = look_alike(book.students, record)
            lost.append((record["name"], sentence("grade.zeros_eaten", number={"quoted": alike}) if alike else sentence("grade.nobodys")))
    marks = [mark_of(book, student, owned[student.id], claimed.get(student.id, ()), points) for student in book.students]
    return marks, lost


def names_it(record: dict):
    calls = {folded(record["name"]), folded(Path(record["path"]).name)}
    return lambda student: bool(calls & set(map(folded, student.submissions)))


def not_there(book: Class, records: list) -> list:
    """[(student, name)] of what the column submissions gives to somebody, and nobody has handed in."""
    known = {folded(call) for record in records for call in (record["name"], Path(record["path"]).name)}
    return [(student, name) for student in book.students for name in student.submissions if folded(name) not in known]


def mark_of(book: Class, student: Student, records: list, claimed, points: dict) -> Mark:
    """Of several submissions, the last counts for each stage that it has a file of, or the best."""
    mark = Mark(student)
    if records:
        last = max(records, key=lambda record: time_of(student, record)[0])
        mark.handed_in, mark.time_from = time_of(student, last)
    for stage in points:
        tries = [one for record in records if (one := attempt(book, student, record, stage))]
        with_file = [one for one in tries if one[4] != "missing"] or tries
        if not with_file:
            continue
        by = (lambda one: (one[1] is not None, (one[1] or 0.0) - one[3], one[0][0])) if book.keep == "best" else (lambda one: one[0][0])
        best = max(with_file, key=by)
        (_, record), mark.stages[stage], mark.days[stage], mark.losses[stage], _ = best
        mark.records[stage] = record
    for record in {record["name"]: record for record in mark.records.values()}.values():
        mark.doubts += doubts_about(record)
    mark.doubts += [sentence("grade.may_be_theirs", name={"quoted": name}) for name in claimed]
    decided = bool(mark.records or student.override)
    for stage in points:
        unknown = claimed or (not decided)
        mark.stages[stage] = student.override.get(stage, None if unknown else mark.stages.get(stage, 0.0))
        if stage in student.override or mark.stages[stage] is None:
            mark.days[stage], mark.losses[stage] = 0, 0.0  # a human's word knows the hour
    if not any(points is None for points in mark.stages.values()):
        mark.doubts = []
    return mark


def attempt(book: Class, student: Student, record: dict, stage: str):
    """((when, the record), points or None, days late, points lost by it, state) of a stage; None where it was not judged for it."""
    row = next((row for row in record["stages"] if row["id"] == stage), None)
    if row is None and record["status"] == "graded":
        return None
    when, _ = time_of(student, record)
    state = row["state"] if row else "unknown"
    points = row["score"] if row and state != "unread" and record["status"] in ("graded", "not-read") else None
    days = 0
    if stage in book.due and (late := (when - book.due[stage]).total_seconds() / 86400.0 - student.excused) >= 0.0:
        days = math.floor(late) + 1
    loss = round(min(1.0, days * book.percent_a_day / 100.0) * (points or 0.0), 2)
    return (when, record), points, days, loss, state


def doubts_about(record: dict) -> list:
    """Why a submission gives no whole mark."""
    if record["status"] == "graded":
        return []
    return record.get("unread") or [why_not_judged(record)]


def why_not_judged(record: dict) -> dict:
    """A fault of ours, in its own words, or a sentence."""
    why = record.get("error", record["status"])
    return sentence("grade.not_judged", reason=why if isinstance(why, dict) else {"quoted": why})


def time_of(student: Student, record: dict) -> tuple:
    """(when it was handed in, who says so)."""
    names = list(map(folded, student.submissions))
    calls = [name for name in (folded(record["name"]), folded(Path(record["path"]).name)) if name in names]
    place = names.index(calls[0]) if calls else 0
    if place < len(student.handed_in):
        return student.handed_in[place], "sheet"
    if record.get("sent"):
        return datetime.fromisoformat(record["sent"]), "platform"
    if student.sent:
        return student.sent, "platform"
    return datetime.fromisoformat(record["handed_in"]), "file"


def is_late_by_file_time(mark: Mark) -> bool:
    """Whether points are lost by nothing but the time of a file, which every copy changes. Canvas says in a name who is late."""
    found = CANVAS.fullmatch(Path(mark.record["path"]).name) if mark.record else None
    return mark.lost > 0.0 and mark.time_from == "file" and not (found and found["late"])
