"""./course predict: asks a handout's "Predict before you run", keeps the answers beside the student's files, in predictions.csv,
and gives ./course check what to compare once the stage is right."""

import csv
import re
import shutil
import sys
from fractions import Fraction
from pathlib import Path

from ..base.errors import CourseError, warn
from ..base.language import Speaker, fold, sentence, speaker
from . import hint
from .names import plain
from .regions import STAGES, covers

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


def shown(numbers: list) -> str:
    return " ".join(f"{float(number):.6g}".replace("-", "−") for number in numbers)


def read_row(prompt: str, count: int, say: Speaker) -> str:
    """So many numbers, as they were written; "" for an empty line. Asks again for anything else. Raises EOFError at the end."""
    while True:
        words = input(prompt).strip()
        if not words or len(numbers_in(words) or []) == count:
            return words
        print(say("predict.not_numbers", n=count))


def kept(folder: Path, say: Speaker) -> dict:
    """{question: as it was first predicted}. Lines that cannot be read are named; they stay in the file."""
    path, found, counts = folder / NAME, {}, {name: len(right) for asked in QUESTIONS.values() for name, right in asked.items()}
    if path.exists():
        with open(path, newline="", encoding="utf-8", errors="replace") as file:
            for number, row in enumerate(csv.reader(file), 1):
                question, words = (f"predict.{row[0]}", row[1]) if len(row) == 2 else ("", "")
                if question in counts and len(numbers_in(words) or []) == counts[question]:
                    found.setdefault(question, words)
                elif row:
                    warn(say("predict.unreadable", file=path, line=number, words=",".join(row)))
    return found


def asked_in(stage: dict, language: str) -> str:
    """The question of the stage's handout."""
    return SECTION.search(hint.page(stage, language).read_text(encoding="utf-8"))[1]


def predict(name: str, folder: Path, language: str) -> int:
    """Asks what has not been predicted, of the stage or of the first one with such a question; 0 if nothing is left open, else
    1. Raises CourseError(2)."""
    say = speaker(language)
    known = kept(folder, say)
    named = [stage for stage in STAGES if (covers(plain(name).upper(), stage) if name else QUESTIONS[stage["id"]].keys() - known.keys())]
    if name and not named:
        raise CourseError(sentence("hint.unknown_stage", name=name, stages=", ".join(stage["id"] for stage in STAGES)))
    for stage in named[:1]:
        text = f"{stage['id']} · {say('title.' + stage['id'])}\n\n{asked_in(stage, language)}\n"
        print(fold(text, shutil.get_terminal_size().columns) if sys.stdout.isatty() else text)
        new = {}
        try:
            for question, right in QUESTIONS[stage["id"]].items():
                if question in known:
                    print(f"{say(question)}\n  {known[question]}")
                elif words := read_row(f"{say(question)}\n  > ", len(right), say):
                    new[question] = words
        except EOFError:
            print()
        with open(folder / NAME, "a", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([question.partition(".")[2], words] for question, words in new.items())
        print("\n" + say("predict.kept", file=NAME, command=f"./course check {stage['id']}"))
        return int(bool(QUESTIONS[stage["id"]].keys() - known.keys() - new.keys()))
    print(say("predict.all_kept", file=NAME))
    return 0


def compared(stage: dict, state: str, folder: Path, say: Speaker) -> list:
    """Lines below a verdict: of a stage that is right what was predicted, and of one that is not begun how to predict."""
    known = kept(folder, say)
    if state == "not-started" and not QUESTIONS[stage["id"]].keys() & known.keys():
        return [say("predict.first", command=f"./course predict {stage['id']}")]
    lines = []
    for question, right in QUESTIONS[stage["id"]].items() if state == "right" else ():
        if question in known:
            good = all(map(is_near, numbers_in(known[question]), right))
            told = say("predict.came_true") if good else say("predict.came_otherwise", right=shown(right))
            lines.append(f"{'✓' if good else '✗'} {say(question)} {known[question]}{told}")
    return lines
