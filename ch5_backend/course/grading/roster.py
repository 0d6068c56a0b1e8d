"""The table of a class, as a teacher or a platform has written it: in any usual encoding, with any usual separator.

    a sheet of one's own          id (学号), name (姓名), and what a human has decided, see classbook.py
    Canvas, the gradebook         Student (or LastName, FirstName), ID, SIS User ID, SIS Login ID, Section, …
    Moodle, the grading worksheet Identifier ("Participant 657693"), Full name, …, Grade, …; anonymous without names
    Moodle, the gradebook         First name, Last name (Surname), ID number, Email address, …
    Gradescope, the roster        First Name, Last Name, SID, Email, Role

The worksheet is known in every language of Moodle by its first column, where all cells are one word and a number.
"""

import codecs
import csv
import io
import re
from dataclasses import dataclass
from pathlib import Path

from ..base.errors import CourseError

# The names of columns, without regard to case.
IDS = ("id", "id number", "学号", "sid", "student id", "username", "用户名", "sis user id", "sis login id", "email address",
       "email", "电子邮件", "邮箱", "identifier")
NAMES = ("name", "student", "full name", "姓名", "全名")
FIRST, LAST = ("first name", "firstname", "名", "名字"), ("last name", "lastname", "surname", "姓", "姓氏")
GRADES = ("grade", "成绩", "分数", "评分", "得分", "成績", "評点", "評定", "bewertung", "note", "calificación", "nota")
PARTICIPANT = re.compile(r"([^\W\d][^\d]*?) ?(\d+)")
EATEN = re.compile(r"\d([.,]\d+)?E\+\d+|\d+[.,]0+", re.IGNORECASE)  # 2.02101E+09: what spreadsheets make of a long number
WORKBOOKS = (b"PK\3\4", b"\xd0\xcf\x11\xe0")  # .xlsx and .ods, .xls
MARKS_OF_ORDER = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))


@dataclass
class Table:
    path: Path
    encoding: str
    delimiter: str
    header: list        # as it is written
    rows: list          # [(line, cells)], as many cells as the header has
    platform: str = ""  # canvas, worksheet, moodle, gradescope, or "" of a sheet of one's own

    def place(self, *names) -> int:
        """The column of the first of these names that is there, without regard to case; -1 if none is."""
        lower = [column.strip().lower() for column in self.header]
        return next((lower.index(name) for name in names if name in lower), -1)

    def cell(self, cells: list, *names) -> str:
        """The first that is there and not empty."""
        places = [self.place(name) for name in names]
        return next((cells[place].strip() for place in places if place >= 0 and cells[place].strip()), "")


def read_table(path: Path) -> Table:
    """Raises CourseError that names file, line and value."""
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise CourseError(f"{path}: cannot be read as a table: {error}") from error
    if raw.startswith(WORKBOOKS):
        raise CourseError(f"{path}: is a workbook of a spreadsheet program; save it there as CSV and name that file")
    text, encoding = decoded(path, raw)
    lines = text.splitlines()
    told = re.fullmatch(r'"?sep=(.)"?', lines[0].strip()) if lines else None  # what Excel may write on top
    skipped = 1 if told else 0
    first = next((line for line in lines[skipped:] if line.strip()), "")
    delimiter = told[1] if told else max(",;\t", key=lambda one: len(next(csv.reader([first], delimiter=one), [])))
    reader = csv.reader(io.StringIO("".join(text.splitlines(keepends=True)[skipped:]), newline=""), delimiter=delimiter, strict=True)
    read, line = [], skipped
    try:
        for cells in reader:
            line = reader.line_num + skipped
            read += [(line, cells)] if any(cell.strip() for cell in cells) else []
    except csv.Error as error:  # such as a quotation mark that nothing closes: all below it would be one cell
        raise CourseError(f"{path}:{line + 1}: cannot be read as a table: {error}") from error
    header = read[0][1] if read else []
    for line, cells in read[1:]:
        if len(cells) > len(header):
            raise CourseError(f"{path}:{line}: more cells than the header has, got '{cells[len(header)]}'")
    rows = [(line, cells + [""] * (len(header) - len(cells))) for line, cells in read[1:]]
    table = Table(path, encoding, delimiter, header, rows)
    table.platform = platform_of(table)
    return table


def decoded(path: Path, raw: bytes) -> tuple:
    """(text, encoding). Excel writes UTF-16, or the machine's own letters: GBK in China, Windows-1252 in the West. Bytes of GBK
    come in pairs that are letters of everyday Chinese; in a Western name they would be rare ones."""
    for mark, encoding in MARKS_OF_ORDER:
        if raw.startswith(mark):
            return strictly(path, raw, encoding), encoding
    if b"\0" in raw[:200]:
        encoding = "utf-16-le" if raw[1::2].count(0) > raw[::2].count(0) else "utf-16-be"
        return strictly(path, raw, encoding), encoding
    try:
        return raw.decode("utf-8"), "utf-8"
    except UnicodeDecodeError:
        pass
    try:
        text = raw.decode("gb18030")
        foreign = [letter for letter in text if ord(letter) > 127]
        if 2 * sum(is_everyday(letter) for letter in foreign) >= len(foreign):
            return text, "gb18030"
    except UnicodeDecodeError:
        pass
    return strictly(path, raw, "cp1252"), "cp1252"


def strictly(path: Path, raw: bytes, encoding: str) -> str:
    try:
        return raw.decode(encoding)
    except UnicodeDecodeError as error:
        raise CourseError(f"{path}: cannot be read as a table: neither UTF-8, UTF-16, GBK nor Windows-1252 ({error})") from error


def is_everyday(letter: str) -> bool:
    try:
        return len(letter.encode("gb2312")) == 2
    except UnicodeEncodeError:
        return False


def platform_of(table: Table) -> str:
    first = [cells[0].strip() for _, cells in table.rows]
    found = [PARTICIPANT.fullmatch(cell) for cell in first]
    if first and all(found) and len({one[1] for one in found}) == 1 and len(table.header) > 2 and table.place(*IDS[:4]) != 0:
        if table.place(*GRADES) < 0:
            raise CourseError(f"{table.path}:1: of a grading worksheet, but without the column Grade, "
                              f"got '{', '.join(table.header)}'")
        return "worksheet"
    if table.place("id") >= 0 and table.place("section") >= 0 and table.place("student", "lastname") == 0:
        return "canvas"
    if table.place("sid") >= 0:
        return "gradescope"
    return "moodle" if table.place(*LAST) >= 0 and table.place("id number", "email address") >= 0 else ""


def id_of(table: Table, line: int, cells: list) -> str:
    """What the student is called by; "" in a row of no student, such as Canvas's possible points."""
    name = table.cell(cells, *NAMES, *LAST)
    if table.platform == "canvas" and (not table.cell(cells, "id") or name == "Points Possible"):
        return ""
    if table.platform == "gradescope" and table.cell(cells, "role").lower() not in ("", "student"):
        return ""
    id = table.cell(cells, *IDS)
    if EATEN.fullmatch(id):
        raise CourseError(f"{table.path}:{line}: a spreadsheet has turned this id into a rounded number; take it from the original "
                          f"and import its column as text, got '{id}'")
    if not id:
        raise CourseError(f"{table.path}:{line}: this row has no id, got '{name}'")
    return id


def name_of(table: Table, cells: list) -> str:
    whole = table.cell(cells, *NAMES)
    first, last = table.cell(cells, *FIRST), table.cell(cells, *LAST)
    chinese = re.fullmatch("[\u4e00-\u9fff·]+", last + first)
    return whole or (last + first if chinese else f"{first} {last}".strip())


def participant(table: Table, cells: list) -> str:
    """Moodle's number of a participant, which its files are called by."""
    found = PARTICIPANT.fullmatch(cells[0].strip()) if table.platform == "worksheet" else None
    return found[2] if found else ""
