"""Names a wrong answer by what is known of answers: ch5_homework/mistakes/answers.csv has what each mistake there gives.

An answer is known by its check, its fingerprint (ch5_homework/judge/fingerprint.h) and what the judge itself says of it, if
it is sure: it compares more digits. All are those of the judge's usual random numbers.
Its name is the cause that is shown instead of the judge's own diagnosis, and the TODO that has the mistake.
"""

import csv
import hashlib
import json
from functools import lru_cache
from typing import NamedTuple

from .diagnosis import ONE_OF_MANY, SYMPTOMS, cause_of
from .regions import ROOT

TABLE = ROOT / "ch5_homework" / "mistakes" / "answers.csv"
NEAR = 1e-5      # of a fingerprint's largest number: two compilers differ by less, two mistakes by more
SIZES, DIGITS = 2, 8  # the first numbers of a fingerprint are rows and columns; digits of the others in the table
ANSWER = ("stage", "check", "expected", "got", "places", "fingerprint", "cause")  # of a diagnosis, what is about the answer


class Row(NamedTuple):
    mistake: str       # its name
    code: str          # a hash of the submission that has given this answer
    todo: str          # "1.2b", or "1.2d 1.2b" of both depths; "" if it is no particular one
    cause: dict
    judged: dict       # the judge's own cause, as sure_of has it
    stage: str
    check: object      # as said, see base/language
    fingerprint: list  # empty if the answer is not finite


# ---- The table ------------------------------------------------------------------------------------------------------

def read_table() -> list:
    if not TABLE.exists():
        return []
    with open(TABLE, newline="", encoding="utf-8") as file:
        return [Row(row["mistake"], row["code"], row["todo"], json.loads(row["cause"]), json.loads(row["judged"]), row["stage"],
                    json.loads(row["check"]), list(map(float, row["fingerprint"].split()))) for row in csv.DictReader(file)]


def write_table(rows: list) -> None:
    with open(TABLE, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(Row._fields)
        writer.writerows([one.mistake, one.code, one.todo, as_text(one.cause), as_text(one.judged), one.stage, as_text(one.check),
                          " ".join(f"{number:.{DIGITS}g}" for number in one.fingerprint)] for one in rows)


def as_text(data) -> str:
    return json.dumps(data, ensure_ascii=False)


def row_of(mistake, diagnosis: dict) -> Row:
    """The row of a mistake of samples.py whose answer has this diagnosis."""
    judged, answer = diagnosis.get("judged", diagnosis), answer_of(diagnosis)
    return Row(mistake.name, hash_of(mistake.code), todo_of(mistake, judged.get("todo", "")), mistake.cause, sure_of(judged),
               answer["stage"], answer["check"], answer.get("fingerprint", []))


def sure_of(diagnosis: dict) -> dict:
    """The judge's own cause; {} where it has none, or one that may fit by coincidence."""
    return {} if cause_of(diagnosis) in ("", *SYMPTOMS, *ONE_OF_MANY) else diagnosis["cause"]


def todo_of(mistake, judged: str) -> str:
    """Where the judge says, if the mistake changes something there, otherwise where it begins; of a blank of the second depth also
    where it is at the first, as blanks.own_todo wants it."""
    own = mistake.todo
    if not own or {f"REGION {todo}" for todo in judged.split()} & mistake.code.keys():
        return judged
    deep = judged and own in mistake.stages[0].get("deep", [])
    return f"{own} {judged.split()[-1]}" if deep else own


def hash_of(code: dict) -> str:
    return hashlib.sha256(json.dumps(code).encode()).hexdigest()[:12]


def near(one: list, other: list) -> bool:
    """Whether two fingerprints are of the same answer."""
    largest = max(map(abs, other[SIZES:]), default=0.0)
    return one[:SIZES] == other[:SIZES] and all(abs(a - b) <= NEAR * largest for a, b in zip(one[SIZES:], other[SIZES:]))


@lru_cache
def known() -> dict:
    """{(stage, check): rows}"""
    return by_check(read_table())


def by_check(rows: list) -> dict:
    checks = {}
    for row in rows:
        if row.fingerprint:
            checks.setdefault((row.stage, as_text(row.check)), []).append(row)
    return checks


def ambiguous(rows: list) -> list:
    """Pairs of mistakes with one answer and two causes: neither is named for such an answer."""
    return [(one.mistake, other.mistake) for alike in by_check(rows).values() for k, one in enumerate(alike) for other in alike[:k]
            if one.cause != other.cause and one.judged == other.judged and near(one.fingerprint, other.fingerprint)]


# ---- Naming ---------------------------------------------------------------------------------------------------------

def answer_of(diagnosis: dict) -> dict:
    """What a diagnosis says of the answer to the usual random numbers."""
    return diagnosis.get("usual", diagnosis)


def same(one: dict, other: dict) -> bool:
    """Whether two answers are equal."""
    return one["stage"] == other["stage"] and one["check"] == other["check"] and near(one["fingerprint"], other["fingerprint"])


def name_of(answer: dict) -> dict:
    """{"cause", "todo"} of the mistake that gives this answer; {} if none does, or two that have different causes."""
    rows = known().get((answer["stage"], as_text(answer["check"])), [])
    sure = sure_of(answer)
    rows = [row for row in rows if near(answer["fingerprint"], row.fingerprint) and (not sure or row.judged == sure)]
    if not rows or any(row.cause != rows[0].cause for row in rows):
        return {}
    todos = {row.todo for row in rows}
    return {"cause": rows[0].cause, **({"todo": rows[0].todo} if len(todos) == 1 and rows[0].todo else {})}


def named(diagnosis: dict, usual: dict) -> dict:
    """The diagnosis under the name of the mistake that gives the answer of `usual`, the diagnosis with the usual random numbers.
    It keeps the answer, and the judge's own diagnosis, so that it can be named again."""
    if "fingerprint" not in usual:
        return diagnosis
    answer = {} if usual is diagnosis else {"usual": {key: usual[key] for key in ANSWER if key in usual}}
    name = name_of(usual)
    said = {"judged": {key: diagnosis[key] for key in ("cause", "todo") if key in diagnosis}} if name else {}
    return {**diagnosis, **answer, **said, **name}


def named_anew(diagnosis: dict) -> dict:
    """A recorded diagnosis, named by the table as it is now."""
    before = {key: value for key, value in diagnosis.items() if key not in ("judged", "usual")}
    before.update(diagnosis.get("judged", {}))
    return named(before, diagnosis.get("usual", before))
