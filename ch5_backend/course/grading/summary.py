"""The page of a class: the distribution of points, the most frequent mistakes, and each student's marks."""

import json
import statistics
from collections import Counter
from datetime import datetime
from pathlib import Path

from markupsafe import Markup

from ch5_backend.figures import page

from ..base.language import Speaker
from ..homework.check import MARKS
from ..homework.diagnosis import SYMPTOMS, cause_of
from ..homework.regions import check_in_words, title_of
from . import outputs, unnamed
from .job import OUT_OF_TIME
from .likeness import alike_once, as_solution
from .pages import element, paragraph, state_of, untouched

NEAR = 10.0  # times its tolerance: so near a wrong number may be rounding
BINS = 10
STYLE = Markup("<style>.bar { display: inline-block; height: .9em; background: var(--c0); margin-right: .5em; vertical-align: middle }"
               " .histogram th, .histogram td { text-align: left } .histogram td { width: 80%; white-space: nowrap }"
               " th button { all: unset; cursor: pointer } th button:focus-visible { outline: 3px solid var(--c1) }"
               " th[aria-sort] button::after { content: ' ↑' } th[aria-sort=descending] button::after { content: ' ↓' }</style>")
SORT = Markup("<script>") + Markup((Path(__file__).parent / "sort.js").read_text(encoding="utf-8")) + Markup("</script>")


def write(out: Path, records: list, points: dict, book, marks: list, looked_at: list, say: Speaker, earlier: list = ()) -> None:
    """summary.html, and unnamed.csv; `book` and `marks` are of a class, None and [] where none was named. `looked_at` comes first: who has no mark,
    and why."""
    graded = [record for record in records if record["status"] == "graded"]
    counted = [mark.record for mark in marks if mark.record and mark.record["status"] == "graded"] if book else graded
    pairs = ([(mark.record, mark.total) for mark in marks if mark.record and mark.total is not None] if book else
             [(record, record["score"]) for record in graded])
    totals = [total for _, total in pairs]
    most = sum(points.values()) + (sum(book.read.values()) if book else 0)
    body = [STYLE, element("h1", say("grade.grades"))]
    if looked_at:
        body += [element("h2", say("grade.look_first")), paragraph(say("grade.look_first_why")), page.table(
            [say("grade.who"), say("grade.why")], [[outputs.plain(who), outputs.plain(why)] for who, why in looked_at], "words")]
    if totals:
        body.append(paragraph(say("grade.head", date=datetime.now().strftime("%Y-%m-%d"), n=len(graded), m=f"{most:g}",
                                  seed=say("grade.list").join(sorted({str(record["seed"]) for record in graded})),
                                  mean=f"{statistics.mean(totals):.1f}", median=f"{statistics.median(totals):.1f}")))
    body += list(map(paragraph, notes(records, book, marks, say)))
    if totals:
        body += [histogram(pairs, most, marks, say)]
    if book:
        body += students(book, marks, say)
    groups = unnamed.groups_of(counted, say)
    unnamed.write(out, groups, say)
    if counted:
        rows = [row for record in counted for row in record["stages"] if not untouched(row)]
        body += [of_stages(counted, say), *counts("grade.most_failed_checks", Counter(
            f"{row['id']} {check_in_words(row['id'], check['name'], say)}" for row in rows for check in row["checks"]
            if not check["passed"] and row["state"] != "not-started"), say),  # an empty blank has failed nothing
            *counts("grade.misconceptions", Counter(what for row in rows if (what := misconception(row, say))), say),
            *unnamed.table(groups, say)]
    if graded:
        body += [near_misses(graded, say), likeness(out, graded, earlier, say), *([] if book else submissions(graded, say))]
    page.write(out / "summary.html", say("grade.grades"), [*body, SORT], say.language)


def notes(records: list, book, marks: list, say: Speaker) -> list:
    """What a reader must know before the numbers."""
    lines = []
    if failed := [record["name"] for record in records if record["status"] == "infrastructure-error"]:
        lines.append(say("grade.not_graded", names=say("grade.list").join(failed)))
    if late := {record["name"]: row["diagnosis"]["cause"]["n"] for record in records for row in record["stages"]
                if cause_of(row["diagnosis"]) == OUT_OF_TIME}:
        lines.append(say("grade.out_of_time", n=next(iter(late.values())), names=say("grade.list").join(late)))
    if sandboxes := sorted({record["sandbox"] for record in records if "sandbox" in record}):
        lines.append(say("grade.sandboxes", names=say("grade.list").join(sandboxes)))
    if book:
        absent = [mark.student.name for mark in marks if not mark.record and not mark.doubts]
        lines.append(say("grade.of_class", n=len(marks) - len(absent), m=len(marks), names=say("grade.list").join(absent)) if absent else
                     say("grade.all_handed_in", m=len(marks)))
        unread = {what: sum(mark.student.read[what] is None for mark in marks if mark.record) for what in book.read}
        lines += [say("grade.unread", what=what, n=n) for what, n in unread.items() if n]
    return lines


def histogram(pairs: list, most: float, marks: list, say: Speaker) -> Markup:
    """Who handed in nothing, or began nothing, is counted apart: neither says how hard the homework is."""
    begun = [total for record, total in pairs if any(not untouched(row) for row in record["stages"])]
    idle, absent = len(pairs) - len(begun), sum(not mark.record and not mark.doubts for mark in marks)
    bins = Counter(min(BINS - 1, int(BINS * total / most)) for total in begun if most)
    rows = [[f"{100 * k // BINS}–{100 * (k + 1) // BINS}", bins[k]] for k in range(BINS)]
    rows += [[say("grade.started_nothing"), idle]] * bool(idle) + [[say("grade.nothing"), absent]] * bool(absent)
    longest = max(number for _, number in rows) or 1
    bar = Markup('<span class="bar" style="width: {}%"></span>{}')
    return element("h2", say("grade.histogram")) + page.table(
        [say("grade.percent"), say("grade.students")], [[label, bar.format(round(80 * number / longest), number)] for label, number in rows], "histogram")


def link(record: dict, text: str) -> Markup:
    return Markup('<a href="{}/feedback.html">{}</a>').format(outputs.plain(record["name"]), outputs.plain(text))


def students(book, marks: list, say: Speaker) -> list:
    """A row a student, then what was changed by hand."""
    late = bool(book.due)
    head = [say("grade.student"), say("grade.id"), say("grade.total"), *marks[0].stages,
            *([say("grade.handed_in"), say("grade.late"), say("grade.lost")] if late else []), *book.read]
    number = lambda value: "" if value is None else f"{value:g}"
    rows = [[link(mark.record, mark.student.name) if mark.record else mark.student.name, mark.student.id, number(mark.total),
             *(number(score) + "*" * (stage in mark.student.override) for stage, score in mark.stages.items()),
             *([mark.handed_in.astimezone().strftime("%m-%d %H:%M:%S") if mark.record else say("grade.nothing"), mark.days_late or "",
                number(mark.lost or None)] if late else []),
             *map(number, mark.student.read.values())] for mark in marks]
    changed = [[mark.student.name, stage, number(points), mark.student.reason] for mark in marks
               for stage, points in mark.student.override.items()]
    pieces = [element("h2", say("grade.all")), paragraph(say("grade.sorts")), page.table(head, rows, "sortable")]
    if changed:
        pieces += [element("h2", say("grade.overridden") + " *"), page.table(list(map(say, [
            "grade.student", "grade.stage", "grade.points", "grade.reason"])), changed, "words")]
    return pieces


def submissions(graded: list, say: Speaker) -> list:
    head = [say("grade.submission"), say("grade.score"), *(row["id"] for row in graded[0]["stages"])]
    rows = [[link(record, record["name"]), f"{record['score']:g}",
             *(f"{MARKS.get(stage['state'], '✗')} {stage['score']:g}" for stage in record["stages"])] for record in graded]
    return [element("h2", say("grade.all")), paragraph(say("grade.sorts")), page.table(head, rows, "sortable")]


def of_stages(graded: list, say: Speaker) -> Markup:
    """Marks per stage, those who have not started one apart; then time and memory."""
    table = []
    for stage in dict.fromkeys(row["id"] for record in graded for row in record["stages"]):
        rows = [row for record in graded for row in record["stages"] if row["id"] == stage]
        scores = [row["score"] for row in rows if not untouched(row)]
        states = Counter(state_of(row, say) for row in rows if not untouched(row))
        table.append([f"{stage} {title_of(rows[0]['id'], say)}", f"{statistics.mean(scores):.1f}" if scores else "–",
                      f"{max(row['points'] for row in rows):g}", len(rows) - len(scores),
                      say("grade.list").join(f"{n} {state}" for state, n in states.most_common())])
    cpu = [record["cpu_seconds"] for record in graded]
    head = ["grade.stage", "grade.mean_of_started", "grade.of", "grade.not_started", "grade.states"]
    return (element("h2", say("grade.marks")) + page.table(list(map(say, head)), table, "words") +
            paragraph(say("grade.compiling_took", a=f"{statistics.median(cpu):.1f}", b=f"{max(cpu):.1f}",
                          c=f"{max(record['peak_mib'] for record in graded):.0f}")))


def counts(title_of: str, counted: Counter, say: Speaker) -> list:
    return [element("h2", say(title_of)), page.table([say("grade.what"), say("grade.submissions")], [
        [outputs.plain(what), times] for what, times in counted.most_common(15)], "words")] if counted else []


def misconception(row: dict, say: Speaker) -> str:
    cause = row["diagnosis"].get("cause") if row["state"] == "wrong" else None
    return say("grade.in_stage", stage=row["id"], what=cause) if cause and cause_of(row["diagnosis"]) not in SYMPTOMS else ""


def near_misses(graded: list, say: Speaker) -> Markup:
    """Checks that failed, or passed, within a factor of 10 of their tolerance: to be looked at by a human."""
    table = [[link(record, record["name"]), f"{row['id']} {check_in_words(row['id'], check, say)}", f"{margin:.2g}"]
             for record in graded for row in record["stages"]
             for check, margin in row["margins"].items() if 1.0 / NEAR < margin < NEAR]
    head = list(map(say, ["grade.submission", "grade.check", "grade.deviation"]))
    none = paragraph(say("grade.no_near_misses", n=f"{NEAR:g}"))
    return element("h2", say("grade.near_misses")) + (page.table(head, table, "words") if table else none)


def likeness(out: Path, graded: list, earlier: list, say: Speaker) -> Markup:
    """Equal submissions, and files that are alike, also those of earlier years. A hint for a human, no proof."""
    same = {}
    for record in [*graded, *earlier]:
        if any(not untouched(row) for row in record["stages"]):  # nothing is equal to nothing, nor a skeleton to a skeleton
            same.setdefault(json.dumps(record["content"]), []).append(record["name"])
    table = [[say("grade.list").join(names), say("grade.all_files"), say("grade.equal")] for names in same.values()
             if len(names) > 1 and not {record["name"] for record in earlier}.issuperset(names)]
    table += [[say("grade.list").join((a, b)), file, say("grade.own_lines", n=f"{100 * part:.0f}")] for a, b, file, part in alike_once(graded, earlier, out / ".cache" / "alike.json")]
    table += [[name, file, say("grade.not_compared") if some is None else say("grade.as_solution", n=some, m=of_all)]
              for name, file, some, of_all in as_solution(graded)]
    head = list(map(say, ["grade.submissions", "grade.file", "grade.share"]))
    return element("h2", say("grade.alike")) + (page.table(head, table, "words") if table else paragraph(say("grade.none")))
