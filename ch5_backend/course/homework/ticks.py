"""A mark for each TODO of a stage: right, wrong, empty, or not judged yet.

ch5_homework/exercised.csv has the TODOs whose lines each check runs; `cmake --build build/release --target answers` makes it from
the reference with one blank at a time. A TODO is right if a check that runs its lines passes and none blames it, and wrong if a
check that fails names it, by more than what is seen; it waits as long as those that run its lines end in others' or say nothing.
"""

import csv
import json
from functools import lru_cache

from .blanks import asks_deep, is_empty, own_todo
from .diagnosis import is_only_seen
from .judge import NOT_STARTED
from .regions import ROOT, todos_of

TABLE = ROOT / "ch5_homework" / "exercised.csv"
RIGHT, WRONG, EMPTY, WAITS = ("✓", "✗", "·", "?")


@lru_cache
def exercised() -> dict:
    """{(stage, check): the TODOs whose lines it runs}"""
    with open(TABLE, newline="", encoding="utf-8") as file:
        return {(row["stage"], row["check"]): set(row["todos"].split()) for row in csv.DictReader(file)}


def write_table(rows: dict) -> None:
    with open(TABLE, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("stage", "check", "todos"))
        writer.writerows([stage, check, " ".join(sorted(todos))] for (stage, check), todos in sorted(rows.items()))


def ticks(stage: dict, tests, content: bytes, first: str = "") -> dict:
    """{todo: mark} of the blanks that this file has, from what GoogleTest reports of all checks of a stage; `first` is the TODO
    that the verdict blames for the first one that fails, by more than that check can see."""
    asked = todos_of(stage) if asks_deep(content) else stage["todos"]
    lines_of = [(test, exercised().get((stage["id"], test["name"]), set()) & {*asked}) for test in tests]
    passed = set().union(*(lines for test, lines in lines_of if not test.get("failures")))
    blamed, doubted = set(), set()
    for test, lines in lines_of:
        if not test.get("failures") or ends_in_a_blank(test) or lines & (blamed | doubted):  # wrong lines say nothing of the others
            continue
        named, first = first or blamed_by(json.loads(test.get("diagnosis", "{}")), content), ""
        left = lines if len(lines) == 1 else lines - passed
        if named or len(left) == 1:  # where all lines but one's are right, it is that one
            blamed |= {named} if named else left
        else:
            doubted |= lines
    return {todo: EMPTY if is_empty(todo, content) else WRONG if todo in blamed else RIGHT if todo in passed - doubted else WAITS for todo in asked}


def blamed_by(diagnosis: dict, content: bytes) -> str:
    """The TODO that a diagnosis blames; "" if it says only what is seen, or the slip may be written where a block is read or used."""
    return "" if is_only_seen(diagnosis) or diagnosis.get("elsewhere") else own_todo(diagnosis.get("todo", ""), content)


def ends_in_a_blank(test: dict) -> bool:
    return bool(NOT_STARTED.search(test["failures"][0]["failure"]))
