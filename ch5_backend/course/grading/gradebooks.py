"""The tables of a class: students.csv with everything, and the platform's own table with the column of grades filled in.

    Canvas     the columns of the student as they came, the grades under the assignment's own heading; an id of a sheet is an
               SIS User ID there, never Canvas's number
    Moodle     the worksheet as it came, with Grade and Feedback comments; or of a gradebook the student's columns and the
               grades. "Participant 657693" and Last modified (grade) are what the import looks for.

Who has no mark has an empty cell: both platforms then change nothing.
"""

from ..base.language import Speaker
from .classbook import Class, Mark
from .roster import GRADES, Table

CANVAS_STUDENT = ("student", "lastname", "firstname", "id", "sis user id", "sis login id", "integration id", "root account", "section")
MOODLE_STUDENT = ("first name", "last name", "surname", "id number", "institution", "department", "email address", "名", "姓", "姓氏", "名字",
                  "学号", "电子邮件")
FEEDBACK = ("feedback comments", "反馈评论", "反馈意见")
MOST = ("maximum grade", "最高成绩", "最高分")


def shown(value) -> str:
    return "" if value is None else f"{value:g}"


def tables(book: Class, marks: list, points: dict, say: Speaker) -> dict:
    """{file: (rows, delimiter, encoding)}."""
    most = sum(points.values()) + sum(book.read.values())
    table, made = book.table, {"students.csv": (students(book, marks, points, most, say), ",", "utf-8-sig")}
    theirs = (table.delimiter, "utf-8-sig" if table.encoding == "utf-8-sig" else "utf-8")
    if table.platform == "canvas":
        made["canvas.csv"] = (canvas(book, marks, most), *theirs)
    elif table.platform == "worksheet":
        made["moodle.csv"] = (worksheet(table, marks), *theirs)
    elif table.platform == "moodle":
        made["moodle.csv"] = (moodle(book, marks), *theirs)
    else:
        made["canvas.csv"] = ([["Student", "ID", "SIS User ID", "SIS Login ID", "Section", book.column],
                               ["    Points Possible", "", "", "", "", shown(most)],
                               *([mark.student.name, "", mark.student.id, "", "", shown(mark.total)] for mark in marks)], ",", "utf-8")
        address = [table.place("email address", "email", "邮箱", "电子邮件")]
        made["moodle.csv"] = ([["ID number", "Full name", *["Email address"] * (address[0] >= 0), book.column, "Feedback comments"],
                               *([mark.student.id, mark.student.name, *(mark.student.row[k] for k in address if k >= 0), shown(mark.total),
                                  mark.student.reason] for mark in marks)], ",", "utf-8")
    return made


def students(book: Class, marks: list, points: dict, most: float, say: Speaker) -> list:
    head = ["id", "name", "status", "submission", "handed_in", "time_from", "days_late", *(f"stage {stage}" for stage in points), "lost_late",
            *(f"read {what}" for what in book.read), "total", "of", "override", "reason"]
    time = lambda mark: mark.handed_in.astimezone().isoformat(timespec="seconds") if mark.handed_in else ""
    return [head, *([mark.student.id, mark.student.name, status(mark, say), "; ".join(sorted({record["name"] for record in mark.records.values()})),
                     time(mark), mark.time_from, shown(mark.days_late if mark.handed_in else None), *map(shown, mark.stages.values()),
                     shown(mark.lost if mark.handed_in else None),
                     *map(shown, mark.student.read.values()), shown(mark.total), shown(most),
                     "; ".join(f"{stage}={value:g}" for stage, value in mark.student.override.items()), mark.student.reason] for mark in marks)]


def status(mark: Mark, say: Speaker) -> str:
    """Why a row is as it is."""
    if mark.doubts:
        return say("grade.no_mark") + " " + " ".join(map(say.text, mark.doubts))
    if not mark.records:
        return say("grade.decided") if mark.total is not None else say("grade.nothing")
    return say("grade.marked")


def canvas(book: Class, marks: list, most: float) -> list:
    table, total = book.table, {id(mark.student.row): shown(mark.total) for mark in marks}
    kept = [k for k, column in enumerate(table.header) if column.strip().lower() in CANVAS_STUDENT]
    place = column_of(table, book.column)
    heading = table.header[place] if place >= 0 else book.column
    possible = lambda cells: [cells[k] for k in kept] + [cells[place] if place >= 0 and cells[place].strip() else shown(most)]
    return [[*(table.header[k] for k in kept), heading],
            *([*(cells[k] for k in kept), total[id(cells)]] if id(cells) in total else possible(cells)
              for _, cells in table.rows if id(cells) in total or cells[0].strip() == "Points Possible")]


def column_of(table: Table, name: str) -> int:
    """The assignment's column: "Homework 5" is "Homework 5 (87568490)" in Canvas and "Assignment: Homework 5 (Real)" in Moodle."""
    plain = lambda column: column.strip().lower().removeprefix("assignment: ").rpartition(" (")[0] or column.strip().lower()
    exact = [k for k, column in enumerate(table.header) if column.strip().lower() == name.strip().lower()]
    alike = [k for k, column in enumerate(table.header) if plain(column) == name.strip().lower()]
    return (exact + alike + [-1])[0]


def worksheet(table: Table, marks: list) -> list:
    grade, feedback = table.place(*GRADES), table.place(*FEEDBACK)
    by_row = {id(mark.student.row): mark for mark in marks}
    rows = [table.header]
    for _, cells in table.rows:
        cells, mark = list(cells), by_row[id(cells)]
        cells[grade] = shown(mark.total)
        if feedback >= 0 and mark.student.reason:
            cells[feedback] = mark.student.reason
        rows.append(cells)
    return rows


def moodle(book: Class, marks: list) -> list:
    table, place = book.table, column_of(book.table, book.column)
    kept = [k for k, column in enumerate(table.header) if column.strip().lower() in MOODLE_STUDENT]
    return [[*(table.header[k] for k in kept), table.header[place] if place >= 0 else book.column, "Feedback comments"],
            *([*(mark.student.row[k] for k in kept), shown(mark.total), mark.student.reason] for mark in marks)]


def refused_there(book: Class, most: float) -> str:
    """Moodle passes over every grade above its own maximum without a word: that maximum, where it is less than ours."""
    place = book.table.place(*MOST) if book.table.platform == "worksheet" else -1
    theirs = {cells[place].strip().replace(",", ".") for _, cells in book.table.rows} if place >= 0 else ()
    return next((text for text in theirs if text.replace(".", "", 1).isdigit() and float(text) < most), "")
