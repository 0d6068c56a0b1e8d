"""./course predict: asks a handout's "Predict before you run", keeps the answers beside the student's files, in predictions.csv,
and gives ./course check what to compare once the stage is right."""

import csv
import re
import sys
from fractions import Fraction
from pathlib import Path

from ..base.errors import warn
from ..base.language import Speaker, fitted, speaker
from . import hint
from .regions import STAGES, title_of

NAME = "predictions.csv"  # question, numbers
SECTION = re.compile(r"^##+ (?:Predict before you run|先预测，再运行)\n\n(.*?)\n\n<details>", re.MULTILINE | re.DOTALL)
TOLERANCE = 2e-3  # three digits are enough
QUESTIONS = {  # of a stage: what is asked for, and the numbers, which are the handout's
    "1.1": {"predict.rows_of_H": [38], "predict.zero_blocks_of_H": [2]},
    "1.2": {"predict.zero_blocks_of_S": [0]},
    "2": {"predict.information_of_the_ends": [10, -10, -10, 10]},
    "3": {"predict.zero_eigenvalues": [7, 1, 0]},
    "4": {"predict.variances_held": [0, 1, 2], "predict.variances_free": [5 / 9, 2 / 9, 5 / 9]},
    "5": {"predict.residual": [-3]},
    "6": {"predict.rows_of_J": [1, 2]},
    "7": {"predict.blocks_of_S": [297]},
    "8": {"predict.damping": [1024 / 3, 2]},
}


def is_near(got: float, right) -> bool:
    return abs(got - float(right)) <= TOLERANCE * max(1.0, abs(float(right)))


def numbers_in(words: str):
    """Numbers, also fractions; None if one is none."""
    try:
        return [float(Fraction(word)) for word in words.replace("−", "-").replace(",", " ").split()]
    except (ValueError, ZeroDivisionError):
        return None


def shown(number) -> str:
    return f"{float(number):.6g}".replace("-", "−")


def read_row(prompt: str, count: int, say: Speaker) -> str:
    """So many numbers, as they were written; "" for an empty line. Asks again for anything else. Raises EOFError at the end."""
    while True:
        words = input(prompt).strip()
        if not words or len(numbers_in(words) or []) == count:
            return words
        print(say("predict.not_numbers", n=count))


def kept(folder: Path) -> tuple:
    """{question: as it was first predicted}, and [(number, text)] of the lines that cannot be read."""
    path, found, unreadable = folder / NAME, {}, []
    counts = {name: len(right) for asked in QUESTIONS.values() for name, right in asked.items()}
    if path.exists():
        with open(path, newline="", encoding="utf-8", errors="replace") as file:
            for number, row in enumerate(csv.reader(file), 1):
                question, words = (f"predict.{row[0]}", row[1]) if len(row) == 2 else ("", "")
                if question in counts and len(numbers_in(words) or []) == counts[question]:
                    found.setdefault(question, words)
                elif row:
                    unreadable.append((number, ",".join(row)))
    return found, unreadable


def asked_in(stage: dict, language: str) -> str:
    """The question of the stage's handout."""
    return SECTION.search(hint.page(stage, language).read_text(encoding="utf-8"))[1]


def predict(stages: list, folder: Path, language: str) -> int:
    """Asks what has not been predicted of the first of these stages that has such a question; 0 if nothing of it is left open,
    else 1."""
    say = speaker(language)
    known, unreadable = kept(folder)
    for number, words in unreadable:
        warn(say("predict.unreadable", file=folder / NAME, line=number, words=words))
    due = [stage for stage in stages if QUESTIONS[stage["id"]].keys() - known.keys()]
    if not due and stages == STAGES:
        print(say("predict.all_kept", file=NAME))
        return 0
    stage, new = (due or stages)[0], {}
    text = f"{stage['id']} · {title_of(stage['id'], say)}\n\n{asked_in(stage, language)}\n"
    print(fitted(text.replace("`", ""), sys.stdout))
    try:
        for question, right in QUESTIONS[stage["id"]].items():
            if question in known:
                print(f"{say(question)}\n  {known[question]}")
            elif words := read_row(f"{say(question)}\n  > ", len(right), say):
                new[question] = words
    except EOFError:
        print()
    if new:
        with open(folder / NAME, "a", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([question.partition(".")[2], words] for question, words in new.items())
        print("\n" + fitted(say("predict.kept", file=NAME, command=f"./course check {stage['id']}"), sys.stdout))
    return int(bool(QUESTIONS[stage["id"]].keys() - known.keys() - new.keys()))


def compared(stage: dict, state: str, folder: Path, say: Speaker) -> list:
    """Lines below a verdict: of a stage that is right what was predicted, and of one that is not begun how to predict."""
    known, _ = kept(folder)
    if state == "not-started" and not QUESTIONS[stage["id"]].keys() & known.keys():
        return [say("predict.first", command=f"./course predict {stage['id']}")]
    lines = []
    for question, right in QUESTIONS.get(stage["id"], {}).items() if state == "right" else ():
        if question in known:
            good = all(map(is_near, numbers_in(known[question]), right))
            told = say("predict.came_true") if good else say("predict.came_otherwise", right=" ".join(map(shown, right)))
            lines.append(f"{'✓' if good else '✗'} {say(question)} {known[question]}{told}")
    return lines
