"""The pages of a grade: feedback for a student, and the summary of the class."""

import re
import statistics
from collections import Counter
from pathlib import Path

from markupsafe import Markup, escape

from ch5_backend.figures import page

from ..homework import hint
from ..base.build import ROOT
from ..homework.check import MARKS
from ..homework.diagnosis import SYMPTOMS, cause_of
from ..base.language import Speaker
from . import outputs

NEAR = 10.0    # times its tolerance: so near a wrong number may be rounding
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

def write_feedback(folder: Path, record: dict, say: Speaker) -> None:
    body = [element("h1", record["name"])]
    if record["status"] != "graded":
        body.append(paragraph(say("grade.grader_failed_page")))
    else:
        replay = say("grade.replay", n=record["seed"])
        points = say("grade.points_in_all", n=f"{record['score']:g}", m=f"{record['points']:g}")
        body += [element("p", element("strong", points) + " " + replay),
                 *(paragraph(say("grade.fault", fault=fault)) for fault in record["faults"]),
                 page.table([say("grade.stage"), say("grade.state"), say("grade.points")],
                            [[f"{row['id']} {title(row, say)}", say(f"state.{row['state']}"), points_of(row, say)]
                             for row in record["stages"]])]
        for row in record["stages"]:
            body += feedback_on(row, say)
    page.write(folder / "feedback.html", say("grade.feedback_for", name=outputs.plain(record["name"])), body, say.language)


def points_of(record: dict, say: Speaker) -> str:
    return say("grade.points_of", n=f"{record['score']:g}", m=f"{record['points']:g}")


def title(row: dict, say: Speaker) -> str:
    return say(f"title.{row['id']}")


def paragraph(text: str) -> Markup:
    return element("p", text)


def unfolds(title: str, kind: str, text) -> Markup:
    return element("details", element("summary", title) + element(kind, text))


def feedback_on(row: dict, say: Speaker) -> list:
    """A stage: the diagnosis, a picture of the wrong entries, what was printed, and the handout's hints to unfold."""
    body = [element("h2", f"{MARKS.get(row['state'], '✗')} {row['id']} {title(row, say)}")]
    if row["state"] == "right":
        return body + [paragraph(say("grade.all_passed"))]
    body.append(element("pre", outputs.words_on(row, say)))
    if row["picture"]:
        body.append(picture(row["picture"], say))
    if row["printed"].strip():
        body.append(unfolds(say("grade.printed"), "pre", row["printed"]))
    failed = [check["name"] for check in row["checks"] if not check["passed"]]
    body.append(paragraph(say("grade.not_passed", checks=", ".join(failed))))
    sections = hint.handout(say.language)
    section = sections.get(section_of(row, sections), "")
    body += [unfolds(title, "p", inline(text)) for title, text in hint.hints_of(section).values()]
    return body


def section_of(row: dict, sections: dict) -> str:
    """The handout's section: by the TODO that the diagnosis names, or by the stage."""
    try:
        return hint.find(row["diagnosis"].get("todo") or row["id"], sections)
    except hint.CourseError:
        return row["id"]


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


# ---- For a class ----------------------------------------------------------------------------------------------------

def write_summary(out: Path, records: list, say: Speaker) -> None:
    graded = [record for record in records if record["status"] == "graded"]
    rows = [row for record in graded for row in record["stages"]]
    body = [element("h1", say("grade.graded", n=len(graded)))]
    failed = [record["name"] for record in records if record["status"] != "graded"]
    if failed:
        body.append(paragraph(say("grade.not_graded", names=", ".join(failed))))
    if graded:
        body += [marks(graded, say), *counts("grade.most_failed_checks", Counter(
            f"{row['id']} {check['name']}" for row in rows for check in row["checks"] if not check["passed"]), say),
            *counts("grade.misconceptions", Counter(what for row in rows if (what := misconception(row, say))), say),
            near_misses(graded, say), likeness(graded, say), table_of_all(graded, say)]
    page.write(out / "summary.html", say("grade.grades"), body, say.language)


def marks(graded: list, say: Speaker) -> Markup:
    """Marks per stage, then time and memory."""
    table = []
    for stage in dict.fromkeys(row["id"] for record in graded for row in record["stages"]):
        rows = [row for record in graded for row in record["stages"] if row["id"] == stage]
        scores = [row["score"] for row in rows]
        states = Counter(row["state"] for row in rows)
        table.append([f"{stage} {title(rows[0], say)}", f"{statistics.mean(scores):.1f}", f"{statistics.median(scores):g}",
                      f"{max(row['points'] for row in rows):g}", ", ".join(f"{n} {say(f'state.{state}')}" for state, n in states.most_common())])
    cpu = [record["cpu_seconds"] for record in graded]
    return (element("h2", say("grade.marks")) + page.table(list(map(say, ["grade.stage", "grade.mean", "grade.median", "grade.of", "grade.states"])), table) +
            paragraph(say("grade.compiling_took", a=f"{statistics.median(cpu):.1f}", b=f"{max(cpu):.1f}",
                          c=f"{max(record['peak_mib'] for record in graded):.0f}")))


def counts(title: str, counted: Counter, say: Speaker) -> list:
    return [element("h2", say(title)), page.table([say("grade.what"), say("grade.submissions")], [[outputs.plain(what), str(times)] for what, times in
                                                                      counted.most_common(15)])] if counted else []


def misconception(row: dict, say: Speaker) -> str:
    cause = row["diagnosis"].get("cause") if row["state"] == "wrong" else None
    return f"{row['id']}: {say.text(cause)}" if cause and cause_of(row["diagnosis"]) not in SYMPTOMS else ""


def near_misses(graded: list, say: Speaker) -> Markup:
    """Checks that failed, or passed, within a factor of 10 of their tolerance: to be looked at by a human."""
    table = [[record["name"], f"{row['id']} {check}", f"{margin:.2g}"] for record in graded for row in record["stages"]
             for check, margin in row["margins"].items() if 1.0 / NEAR < margin < NEAR]
    head = list(map(say, ["grade.submission", "grade.check", "grade.deviation"]))
    none = paragraph(say("grade.no_near_misses", n=f"{NEAR:g}"))
    return element("h2", say("grade.near_misses")) + (page.table(head, table) if table else none)


def likeness(graded: list, say: Speaker) -> Markup:
    """Equal submissions, and files that share most of the lines that few others have. A hint for a human, no proof."""
    same = {}
    for record in graded:
        same.setdefault(record["content"], []).append(record["name"])
    table = [[", ".join(names), say("grade.all_files"), say("grade.equal")] for names in same.values() if len(names) > 1]
    table += [[f"{a}, {b}", file, say("grade.own_lines", n=f"{100 * part:.0f}")]
              for a, b, file, part in outputs.alike(graded, known_lines())]
    return element("h2", say("grade.alike")) + (
        page.table(list(map(say, ["grade.submission", "grade.file", "grade.share"])), table) if table else paragraph(say("grade.none")))


def known_lines() -> dict:
    """{file: hashes of the skeleton's and the solution's lines}"""
    known = {}
    for folder in ("ch5_homework", "solutions"):
        for path in (ROOT / folder).glob("*.cc"):
            known.setdefault(path.name, set()).update(outputs.fingerprint({path.name: path.read_bytes()})[path.name])
    return known


def table_of_all(graded: list, say: Speaker) -> Markup:
    head = [say("grade.submission"), say("grade.score"), *(row["id"] for row in graded[0]["stages"])]
    link = Markup('<a href="{0}/feedback.html">{0}</a>')
    row = lambda tag, cells: element("tr", Markup("").join(element(tag, cell) for cell in cells))
    lines = [row("td", [link.format(outputs.plain(record["name"])), f"{record['score']:g}", *(
        f"{MARKS.get(stage['state'], '✗')} {stage['score']:g}" for stage in record["stages"])]) for record in graded]
    table = element("table", row("th", head) + Markup("").join(lines))
    return element("h2", say("grade.all")) + Markup('<div class="scroll">{}</div>').format(table)
