"""Numbers in place of names, for those who read by hand; OUT/numbers.csv tells whose they are, until the marks are out."""

import csv
import random
from dataclasses import replace
from pathlib import Path

from ..base.language import Speaker
from . import outputs, pages, summary


def write(folder: Path, out: Path, records: list, points: dict, book, marks: list, say: Speaker) -> None:
    """The pages of `out` once more, into `folder`. What could not be read is left to who sees names: file names hold them."""
    numbers = numbers_of(out, [record["name"] for record in records])
    hidden = {record["name"]: {**record, "name": numbers[record["name"]], "faults": [], "unread": []} for record in records}
    theirs = [replace(mark, student=replace(mark.student, id="", name=numbers[mark.record["name"]] if mark.record else "–"),
                      records={stage: hidden[record["name"]] for stage, record in mark.records.items()})
              for mark in marks]
    folder.mkdir(parents=True, exist_ok=True)
    for record in hidden.values():
        (folder / record["name"]).mkdir(exist_ok=True)
        pages.write_feedback(folder / record["name"], record, say,
                             [mark for mark in theirs if record["name"] in {one["name"] for one in mark.records.values()}])
    summary.write(folder, sorted(hidden.values(), key=lambda record: record["name"]), points, book and replace(book, students=[]),
                  sorted(theirs, key=lambda mark: mark.student.name), [], say)


def numbers_of(out: Path, names: list) -> dict:
    """{name: number}: those of numbers.csv, and for new names numbers drawn at random, whose order tells nothing."""
    path = out / "numbers.csv"
    known = {}
    if path.exists():
        with open(path, newline="", encoding="utf-8") as file:
            known = {row["name"]: row["number"] for row in csv.DictReader(file)}
    cells = {name: outputs.harmless(name) for name in names}
    new = [cell for cell in cells.values() if cell not in known]
    first = 10 ** max(3, len(str(10 * (len(known) + len(new)))))
    drawn = map(str, random.SystemRandom().sample(range(first, 10 * first), len(known) + len(new)))  # so that enough are new
    used = set(known.values())
    known.update(zip(new, [number for number in drawn if number not in used]))
    outputs.write_table(path, [("name", "number"), *known.items()])
    return {name: known[cell] for name, cell in cells.items()}
