"""Questions for a talk of ten minutes with each student, out of their own lines: what was wrong in them, and which change would
bring a mistake that the judge knows. The same seed asks the same."""

import random
from functools import lru_cache
from pathlib import Path

from ch5_backend.figures import page

from ..base.language import Speaker
from ..homework.diagnosis import in_short
from ..homework.mended import blanks_of
from ..homework.regions import FILES
from ..homework.samples import read_mistakes
from .pages import element, paragraph, unfolds

QUESTIONS = 3  # to each student


def lines_of(files: dict) -> dict:
    """{TODO: the student's lines}, of the blanks that hold any."""
    found = {}
    for file in FILES:
        text = files.get(file, b"").decode("utf-8", "replace")
        lines = text.splitlines()
        for todo, (begin, end) in blanks_of(file, text).items():
            if any(line.strip() and not line.strip().startswith(("//", "throw HomeworkMissing(")) for line in lines[begin:end]):
                found[todo] = "\n".join(lines[begin:end])
    return found


@lru_cache
def mistakes() -> dict:
    """{TODO: its mistakes}, of those that one blank holds and that have a sentence."""
    found = {}
    for one in read_mistakes():
        if one.state == "wrong" and one.cause and list(one.code) == [f"REGION {one.todo}"] and one.code[f"REGION {one.todo}"].strip():
            found.setdefault(one.todo, []).append(one)
    return found


def questions(record: dict, lines: dict, say: Speaker) -> list:
    """[(question, the student's lines, an answer)]: the first wrong stage, then blanks of right ones, drawn by seed and name."""
    draw = random.Random(f"{record['seed']} {record['name']}")
    wrong = next((row for row in record["stages"] if row["state"] == "wrong" and row["diagnosis"].get("todo", "").split()), None)
    found = []
    if wrong:
        todo = wrong["diagnosis"]["todo"].split()[-1]
        found.append((say("grade.talk_wrong", stage=wrong["id"], todo=todo), lines.get(todo, ""), in_short(wrong["diagnosis"], say)))
    right = {row["id"] for row in record["stages"] if row["state"] == "right"}
    ready = [todo for todo in lines if any(one.stages[0]["id"] in right for one in mistakes().get(todo, ()))]
    for todo in draw.sample(ready, min(QUESTIONS - len(found), len(ready))):
        mistake = draw.choice(mistakes()[todo])
        found.append((say("grade.talk_right", todo=todo, what=mistake.cause), lines[todo], mistake.code[f"REGION {todo}"].rstrip()))
    return found


def write(path: Path, submissions: list, say: Speaker) -> None:
    """`submissions` are [(record, files)]: a record holds no line of a student's."""
    body = [element("h1", say("grade.talk")), paragraph(say("grade.talk_why"))]
    for record, files in submissions:
        if asked := questions(record, lines_of(files), say):
            body.append(element("h2", record["name"]))
            for question, lines, answer in asked:
                body += [paragraph(question), element("pre", lines), unfolds(say("grade.talk_answer"), "pre", answer)]
    page.write(path, say("grade.talk"), body, say.language)
