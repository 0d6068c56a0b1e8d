"""Wrong answers that no cause names, put together where they are equal: the misconceptions that a class has and the course does
not know. unnamed.csv and a table of summary.html; ch5_homework/GRADING.md tells how one gets its name."""

import re
from dataclasses import dataclass, field
from pathlib import Path

from markupsafe import Markup

from ch5_backend.figures import page

from ..base.language import Speaker
from ..homework import answers
from ..homework.blanks import own_todo
from ..homework.diagnosis import SYMPTOMS, cause_of, said_in
from ..homework.mended import blanks_of
from . import outputs

LONGEST, WIDEST = 25, 160  # lines of an excerpt, and letters of a line
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)


@dataclass
class Group:
    """Equal answers, of as many submissions."""
    row: dict                                    # of the first one's record
    answer: dict                                 # as answers.answer_of gives it
    names: list = field(default_factory=list)


def is_unnamed(row: dict) -> bool:
    """Whether a stage is wrong, and its cause is unknown or true of many mistakes."""
    cause = cause_of(row["diagnosis"])
    return row["state"] == "wrong" and (not cause or cause.startswith("matrix.") or cause in SYMPTOMS)


def groups_of(records: list, say: Speaker) -> list:
    """The groups of two and more, the largest first."""
    groups = []
    for record in records:
        for row in filter(is_unnamed, record["stages"]):
            answer = answers.answer_of(row["diagnosis"])
            if "fingerprint" not in answer or not all(map(say.knows, said_in(answer))):
                continue
            group = next((one for one in groups if answers.same(one.answer, answer)), None)
            if not group:
                groups.append(group := Group(row, answer))
            group.names.append(record["name"])
    return sorted((group for group in groups if len(group.names) > 1), key=lambda group: -len(group.names))


def cells_of(group: Group, say: Speaker) -> list:
    """A group's row without its size and the excerpt."""
    answer = group.answer
    place = say("grade.list").join(say.text(name) for _, name in answer.get("places", ()))
    return [group.row["id"], say.text(answer["check"]), place, *(say.text(answer.get(key, "")) for key in ("expected", "got")),
            say.text(group.row["diagnosis"].get("cause", ""))]


def rows_of(groups: list, say: Speaker) -> list:
    """unnamed.csv"""
    head = ["students", "stage", "check", "entry", "expected", "got", "told", "todo", "lines"]
    return [head, *([len(group.names), *cells_of(group, say), group.row["diagnosis"].get("todo", ""), group.row.get("lines", "")]
                    for group in groups)]


def table(groups: list, say: Speaker) -> list:
    """The part of summary.html; nothing where all wrong answers have names, or each its own."""
    if not groups:
        return []
    code = Markup("<pre>{}</pre>")
    head = ["grade.students", "grade.stage", "grade.check", "grade.entry", "grade.expected", "grade.got", "grade.told", "grade.lines"]
    rows = [[len(group.names), *map(outputs.plain, cells_of(group, say)), code.format(outputs.plain(group.row.get("lines", "")))]
            for group in groups]
    return [Markup("<h2>{}</h2><p>{}</p>").format(say("grade.unnamed"), say("grade.unnamed_means")),
            page.table(list(map(say, head)), rows, "words")]


def write(out: Path, groups: list, say: Speaker) -> None:
    outputs.write_table(out / "unnamed.csv", rows_of(groups, say))


def excerpt(stage: dict, content: bytes, todo: str) -> str:
    """What a student has written in this blank, or in all of the stage if the blank is not known: without comments, which may
    contain a name."""
    text = content.decode("utf-8", "replace")
    spans, lines = blanks_of(stage["file"], text), text.splitlines()
    wanted = [todo] if (todo := own_todo(todo, content)) in spans else [one for one in stage["todos"] if one in spans]
    written = COMMENT.sub("", "\n".join("\n".join(lines[slice(*spans[one])]) for one in wanted)).splitlines()
    return "\n".join(line.rstrip()[:WIDEST] for line in written if line.strip())[:LONGEST * WIDEST]
