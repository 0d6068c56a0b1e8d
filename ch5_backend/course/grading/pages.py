"""The page of a grade that a student reads."""

import re
from pathlib import Path

from markupsafe import Markup, escape

from ch5_backend.figures import page

from ..homework import hint
from ..homework.check import MARKS
from ..homework.regions import check_in_words, title_of
from ..base.language import Speaker
from . import outputs

NO_BREAK = "\N{NO-BREAK SPACE}"
PICTURE = 320  # pixels, of a picture of H
COLORS = {".": "var(--pale)", "o": "#999", "x": "#d55e00"}


def element(tag: str, text) -> Markup:
    """<tag>text</tag>, escaped unless it is Markup, without what would steer a terminal or a browser."""
    return Markup("<{0}>{1}</{0}>").format(tag, text if isinstance(text, Markup) else outputs.plain(text))


def inline(markdown: str) -> Markup:
    """What the handout's hints have of Markdown: `code` and *emphasis*."""
    return Markup(re.sub(r"`([^`]+)`|(?<!\*)\*([^*`]+)\*",
                         lambda found: f"<code>{found[1]}</code>" if found[1] else f"<em>{found[2]}</em>",
                         escape(outputs.plain(markdown))))


# ---- For a student --------------------------------------------------------------------------------------------------

def write_feedback(folder: Path, record: dict, say: Speaker, marks=()) -> None:
    """`marks` are those of a class for which this submission counts."""
    body = [element("h1", record["name"])]
    if record["status"] not in ("graded", "not-read"):
        body.append(paragraph(say("grade.partly_judged" if record["status"] == "not-judged" else "grade.grader_failed_page")))
    else:
        replay = say("grade.replay", n=record["seed"])
        points = say("grade.points_in_all", n=f"{record['score']:g}", m=f"{record['points']:g}")
        if record["status"] == "not-read":
            points = say("grade.not_read_page")
        body += [element("p", element("strong", points) + " " + replay),
                 *(piece for one in marks for piece in final(one, say)),
                 *(paragraph(say("grade.fault", fault=fault)) for fault in record["faults"]),
                 page.table([say("grade.stage"), say("grade.state"), say("grade.points")],
                            [[f"{row['id']} {title_of(row['id'], say)}", state_of(row, say),
                              "–" if row["state"] == "unread" else points_of(row, say).replace(" ", NO_BREAK)]
                             for row in record["stages"]], "words")]
        for row in record["stages"]:
            body += feedback_on(row, say)
    page.write(folder / "feedback.html", say("grade.feedback_for", name=outputs.plain(record["name"])), body, say.language)


def final(mark, say: Speaker) -> list:
    """What the class's table makes of it: lateness, a human's word, the figure that counts."""
    number, stages = lambda value: f"{value:g}", mark.stages.items()
    rows = [[say("grade.judged"), number(sum(points for stage, points in stages if points is not None and stage not in mark.student.override))]]
    rows += [[say("grade.overridden_stage", stage=stage, reason={"quoted": mark.student.reason}), number(points)]
             for stage, points in mark.student.override.items()]
    late = {days: [stage for stage in mark.days if mark.days[stage] == days and mark.losses[stage]] for days in sorted(set(mark.days.values()))}
    rows += [[say("grade.late_by", days=days, stages=say("grade.list").join(late[days])), "−" + number(sum(mark.losses[stage] for stage in late[days]))]
             for days in late if late[days]]
    rows += [[say("grade.read_by_hand", what={"quoted": what}), say("grade.not_yet") if points is None else number(points)]
             for what, points in mark.student.read.items()]
    total = say("grade.no_mark") if mark.total is None else number(mark.total)
    return [page.table([say("grade.student"), outputs.plain(mark.student.name)], [*rows, [say("grade.total"), total]], "words")]


def points_of(record: dict, say: Speaker) -> str:
    return say("grade.points_of", n=f"{record['score']:g}", m=f"{record['points']:g}")


def untouched(row: dict) -> bool:
    """Whether nothing of a stage was begun."""
    return row["state"] in ("missing", "unread") or (row["state"] == "not-started" and not row["diagnosis"].get("begun"))


def state_of(row: dict, say: Speaker) -> str:
    """In words; says half-done if a stage has been begun."""
    return say("state.half-done" if row["diagnosis"].get("begun") else f"state.{row['state']}")


def paragraph(text: str) -> Markup:
    return element("p", text)


def unfolds(title: str, kind: str, text) -> Markup:
    return element("details", element("summary", title) + element(kind, text))


def feedback_on(row: dict, say: Speaker) -> list:
    """A stage: the diagnosis, a picture of the wrong entries, what was printed, and the handout's hints to unfold."""
    body = [element("h2", f"{MARKS.get(row['state'], '✗')} {row['id']} {title_of(row['id'], say)}")]
    if row["state"] == "right":
        return body + [paragraph(say("grade.all_passed"))]
    body.append(element("pre", outputs.words_on(row, say)))
    if row["picture"]:
        body.append(picture(row["picture"], say))
    if row["printed"].strip():
        body.append(unfolds(say("grade.printed"), "pre", row["printed"]))
    if row.get("followed"):
        body.append(paragraph(followed(row, say)))
    if not untouched(row):
        checks = [[check_in_words(row["id"], check["name"], say), "✓" if check["passed"] else "✗", points_of(check, say).replace(" ", NO_BREAK)]
                  for check in row["checks"]]
        body.append(page.table([say("grade.check"), say("grade.state"), say("grade.points")], checks, "words"))
    sections = hint.handout(say.language)
    section = sections[hint.section_of(row["id"], row["diagnosis"].get("todo", ""), sections)]
    body += [unfolds(title, "p", inline(text)) for title, text in hint.hints_of(section).values()]
    return body


def followed(row: dict, say: Speaker) -> str:
    """Why a stage that is not right has more points than its checks."""
    return say("grade.followed", replaced=say("grade.list").join(row["replaced"]), n=row["blanks"] - len(row["replaced"]), m=row["blanks"],
               points=f"{row['score']:g}")


def picture(pattern: str, say: Speaker) -> Markup:
    """A matrix, entry by entry: zero, not zero, or wrong. See Picture in ch5_homework/judge/diagnosis.cc."""
    rows = pattern.split("/")
    cell = min(16, max(4, PICTURE // max(len(rows), *map(len, rows))))
    square = Markup('<rect x="{}" y="{}" width="{}" height="{}" fill="{}"/>')
    cells = Markup("").join(square.format(cell * j, cell * i, cell - 1, cell - 1, COLORS[entry])
                            for i, row in enumerate(rows) for j, entry in enumerate(row) if entry in COLORS)
    width, height = cell * max(map(len, rows)), cell * len(rows)
    caption = say("grade.picture")
    return Markup('<figure><svg role="img" aria-label="{0}" width="{1}" height="{2}" viewBox="0 0 {1} {2}">{3}</svg>'
                  "<figcaption>{0}</figcaption></figure>").format(caption, width, height, cells)
