"""The pages of a grade: feedback for a student, and the summary of the class."""

import html
import re
import statistics
from collections import Counter
from pathlib import Path

import page

from .. import hint
from ..build import ROOT
from ..check import MARKS
from . import outputs

NEAR = 10.0    # times its tolerance: so near a wrong number may be rounding
PICTURE = 320  # pixels, of a picture of H
COLOURS = {".": "var(--pale)", "o": "#999", "x": "#d55e00"}
CAUSE = re.compile(r"^  cause +(.*)$", re.MULTILINE)


def escape(text: str) -> str:
    return html.escape(outputs.plain(text))


# ---- For a student --------------------------------------------------------------------------------------------------

def write_feedback(folder: Path, record: dict) -> None:
    body = [f"<h1>{escape(record['name'])}</h1>"]
    if record["status"] != "graded":
        body.append("<p>The grader itself has failed; this says nothing about your work. Your instructor has been told.</p>")
    else:
        body += [f"<p><strong>{record['score']:g} of {record['points']:g} points.</strong> Every number below can be had "
                 f"again: <code>./course check --seed {record['seed']}</code> meets the same cases.</p>",
                 *(f"<p>{escape(fault)}.</p>" for fault in record["faults"]),
                 page.table(["stage", "state", "points"], [[f"{row['id']} {row['title']}", row["state"],
                                                           f"{row['score']:g} of {row['points']:g}"]
                                                          for row in record["stages"]])]
        for row in record["stages"]:
            body += feedback_on(row)
    page.write(folder / "feedback.html", f"Feedback for {outputs.plain(record['name'])}", body)


def feedback_on(row: dict) -> list:
    """A stage: the story, a picture of the wrong entries, what was printed, and the handout's hints to unfold."""
    body = [f"<h2>{MARKS.get(row['state'], '✗')} {row['id']} {escape(row['title'])}</h2>"]
    if row["state"] == "right":
        return body + ["<p>All checks are passed.</p>"]
    body.append(f"<pre>{escape(row['story'] or row['hint'])}</pre>")
    if row["picture"]:
        body.append(picture(row["picture"]))
    if row["printed"].strip():
        body.append(f"<details><summary>What your code printed</summary><pre>{escape(row['printed'])}</pre></details>")
    failed = [check["name"] for check in row["checks"] if not check["passed"]]
    body.append(f"<p>Not passed: {escape(', '.join(failed))}.</p>")
    sections = hint.handout("en")
    section = sections.get(section_of(row, sections), "")
    body += [f"<details><summary>{escape(title)}</summary><p>{escape(text)}</p></details>"
             for title, text in hint.hints_of(section).values()]
    return body


def section_of(row: dict, sections: dict) -> str:
    """The handout's section: by the TODO that the story names, or by the stage."""
    todo = re.search(r"TODO (\S+)$", row["story"], re.MULTILINE)
    try:
        return hint.find(todo[1] if todo else row["id"], sections)
    except hint.CourseError:
        return row["id"]


def picture(pattern: str) -> str:
    """A matrix, entry by entry: zero, not zero, or wrong. See Picture in tests/homework/narrate.cc."""
    rows = pattern.split("/")
    cell = min(16, max(4, PICTURE // max(len(rows), *map(len, rows))))
    cells = "".join(f'<rect x="{cell * j}" y="{cell * i}" width="{cell - 1}" height="{cell - 1}" fill="{COLOURS[entry]}"/>'
                    for i, row in enumerate(rows) for j, entry in enumerate(row) if entry in COLOURS)
    width, height = cell * max(map(len, rows)), cell * len(rows)
    return (f'<figure><svg role="img" aria-label="The matrix; wrong entries are orange" width="{width}" height="{height}" '
            f'viewBox="0 0 {width} {height}">{cells}</svg><figcaption>The matrix that this is about: grey entries are not '
            "zero, orange ones are wrong.</figcaption></figure>")


# ---- For a class ----------------------------------------------------------------------------------------------------

def write_summary(out: Path, records: list) -> None:
    graded = [record for record in records if record["status"] == "graded"]
    rows = [row for record in graded for row in record["stages"]]
    body = [f"<h1>{len(graded)} submissions graded</h1>"]
    failed = [record["name"] for record in records if record["status"] != "graded"]
    if failed:
        body.append(f"<p><strong>Not graded, by a fault of the grader or its machine:</strong> {escape(', '.join(failed))}."
                    " Their marks are missing, not zero.</p>")
    if graded:
        body += [marks(graded), *counts("Most failed checks", Counter(
            f"{row['id']} {check['name']}" for row in rows for check in row["checks"] if not check["passed"])),
            *counts("Most frequent misconceptions", Counter(cause_of(row) for row in rows if cause_of(row))),
            near_misses(graded), likeness(graded), table_of_all(graded)]
    page.write(out / "summary.html", "Grades", body)


def marks(graded: list) -> str:
    """Marks per stage, then time and memory."""
    table = []
    for stage in dict.fromkeys(row["id"] for record in graded for row in record["stages"]):
        rows = [row for record in graded for row in record["stages"] if row["id"] == stage]
        scores = [row["score"] for row in rows]
        states = Counter(row["state"] for row in rows)
        table.append([f"{stage} {rows[0]['title']}", f"{statistics.mean(scores):.1f}", f"{statistics.median(scores):g}",
                      f"{max(row['points'] for row in rows):g}", ", ".join(f"{n} {state}" for state, n in states.most_common())])
    cpu = [record["cpu_seconds"] for record in graded]
    return ("<h2>Marks</h2>" + page.table(["stage", "mean", "median", "of", "states"], table) +
            f"<p>Compiling took {statistics.median(cpu):.1f} s of processor time a submission in the median, "
            f"{max(cpu):.1f} s at most, and {max(record['peak_mib'] for record in graded):.0f} MB at most.</p>")


def counts(title: str, counted: Counter) -> list:
    return [f"<h2>{title}</h2>", page.table(["what", "submissions"], [[outputs.plain(what), str(times)] for what, times in
                                                                      counted.most_common(15)])] if counted else []


def cause_of(row: dict) -> str:
    found = CAUSE.search(row["story"])
    return f"{row['id']}: {found[1]}" if found and not found[1].startswith("none of the typical") else ""


def near_misses(graded: list) -> str:
    """Checks that failed, or passed, within a factor of 10 of their tolerance: to be looked at by a human."""
    table = [[record["name"], f"{row['id']} {check}", f"{margin:.2g}"] for record in graded for row in record["stages"]
             for check, margin in row["margins"].items() if 1.0 / NEAR < margin < NEAR]
    return "<h2>Near misses</h2>" + (page.table(["submission", "check", "deviation in tolerances"], table) if table else
                                     "<p>No number lies within a factor of 10 of its tolerance, on either side.</p>")


def likeness(graded: list) -> str:
    """Equal submissions, and files that share most of the lines that few others have. A hint for a human, no proof."""
    same = {}
    for record in graded:
        same.setdefault(record["content"], []).append(record["name"])
    table = [[", ".join(names), "all files", "equal"] for names in same.values() if len(names) > 1]
    table += [[f"{a}, {b}", file, f"{100 * part:.0f} % of their own lines"]
              for a, b, file, part in outputs.alike(graded, known_lines())]
    return "<h2>Alike submissions</h2>" + (page.table(["submissions", "file", "share"], table) if table else
                                           "<p>None.</p>")


def known_lines() -> dict:
    """{file: hashes of the skeleton's and the solution's lines}"""
    known = {}
    for folder in ("ch5_homework", "solutions"):
        for path in (ROOT / folder).glob("*.cc"):
            known.setdefault(path.name, set()).update(outputs.fingerprint({path.name: path.read_bytes()})[path.name])
    return known


def table_of_all(graded: list) -> str:
    head = ["submission", "score", *(row["id"] for row in graded[0]["stages"])]
    link = lambda record: f'<a href="{escape(record["name"])}/feedback.html">{escape(record["name"])}</a>'
    lines = ["<tr><td>" + "</td><td>".join([link(record), f"{record['score']:g}", *(
        f"{MARKS.get(row['state'], '✗')} {row['score']:g}" for row in record["stages"])]) + "</td></tr>" for record in graded]
    return ('<h2>All</h2><div class="scroll"><table><tr>' + "".join(f"<th>{cell}</th>" for cell in head) + "</tr>" +
            "".join(lines) + "</table></div>")
