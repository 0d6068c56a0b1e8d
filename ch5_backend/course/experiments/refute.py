"""./course refute: plausible explanations of what this project measures, each with the switches that test it.

The flights are run, the student compares them in pairs, and writes the mean difference, its standard error and what can be
said of its sign. Those are checked here; the sentence beside them, kept in refuted.csv, is for an instructor to read.
"""

import csv
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ch5_backend.figures.tables import read_table

from ..base.language import Speaker, fitted, speaker
from ..homework.check import folder
from ..homework.predict import numbers_in, read_row, shown
from . import plots
from .figure_sets import FigureSet

NAME = "refuted.csv"  # exercise, comparison, mean, its standard error, sign; and with an empty comparison the sentence
TOLERANCE = 8e-3      # three digits are asked for
SIGNS = ("-", "0", "+")


@dataclass(frozen=True)
class Comparison:
    """`value` in the rows of `one` less that in those of `other`, a pair a trial, both where `both` holds."""
    name: str  # of its sentence
    value: str
    both: dict
    one: dict
    other: dict

    def sides(self, table) -> tuple:
        """Both values of each trial that has both."""
        rows = [table.where(**self.both, **side) for side in (self.one, self.other)]
        one, other = (side[self.value][np.argsort(side["trial"])] for side in rows)
        pairs = np.isfinite(one) & np.isfinite(other)
        return one[pairs], other[pairs]


@dataclass(frozen=True)
class Exercise:
    claim: str  # its sentence's name, as of each comparison
    program: str
    study: str
    trials: int
    seconds: float  # that the trials take, with two cores
    comparisons: tuple

    def tables(self) -> FigureSet:
        return FigureSet(f"refute/{self.study}", "refute", (f"csv/{self.study}.csv",), self.program, "", (self.seconds, 0),
                         trials={self.study: (self.trials, self.trials)})


def iterations_at_peak(name: str, start: str) -> Comparison:
    return Comparison(name, "iterations", {"start": start}, {"weight": 10}, {"weight": 1e8})


def gain_of_full(name: str, recording: str) -> Comparison:
    return Comparison(name, "ate_m", {"recording": recording}, {"setting": "full"}, {"setting": "none"})


EXERCISES = {
    "1": Exercise("refute.claim_1", "ch5_systems", "certainty", 20, 20, (
        Comparison("refute.second_use", "nees", {"hosts": "exact", "weights": "as simulated"}, {"observations": "twice"},
                   {"observations": "once"}),
        Comparison("refute.exact_hosts", "nees", {"observations": "once", "weights": "as simulated"}, {"hosts": "exact"},
                   {"hosts": "noisy"}),
        Comparison("refute.weights", "nees", {"observations": "twice", "hosts": "exact"}, {"weights": "as simulated"},
                   {"weights": "published"}))),
    "2": Exercise("refute.claim_2", "ch5_gauge", "near_start", 20, 5, (
        iterations_at_peak("refute.peak_stated", "stated"), iterations_at_peak("refute.peak_less_damping", "less damping"),
        iterations_at_peak("refute.peak_earlier_stop", "earlier stop"))),
    "3": Exercise("refute.claim_3", "ch5_systems", "refuted_estimates", 12, 15, (
        gain_of_full("refute.full_ahead", "ahead"), gain_of_full("refute.full_hand_held", "hand-held"))),
}


def mean_and_error(differences) -> tuple:
    return differences.mean(), differences.std(ddof=1) / np.sqrt(len(differences))


def sign_of(mean: float, error: float) -> str:
    """What can be said of a sign: "0", nothing, within two standard errors."""
    return SIGNS[1] if abs(mean) <= 2 * error else SIGNS[2] if mean > 0 else SIGNS[0]


def slip(one, other, mean: float, error: float) -> str:
    """"" if mean and error are right, else the usual mistake that gives them: its sentence's name."""
    differences, n = one - other, len(one)
    right_mean, right = mean_and_error(differences)

    def near(got, wanted):
        return abs(got - wanted) <= TOLERANCE * max(abs(wanted), right)

    if not near(mean, right_mean):
        return ("refute.slip_other_way_around" if near(mean, -right_mean) else
                "refute.slip_median" if near(mean, np.median(differences)) else "refute.slip_mean")
    if near(error, right):
        return ""
    usual = {"refute.slip_of_one": right * np.sqrt(n), "refute.slip_variance": right ** 2 * n,
             "refute.slip_by_n": right * np.sqrt((n - 1) / n), "refute.slip_of_one_by_n": right * np.sqrt(n - 1),
             "refute.slip_not_paired": np.sqrt((one.var(ddof=1) + other.var(ddof=1)) / n), "refute.slip_twice": 2 * right}
    return next((name for name, wanted in usual.items() if near(error, wanted)), "refute.slip_error")


def refute(number, out, language: str) -> int:
    """Runs an exercise's flights where that has not been done, asks, and keeps what is right; 0 once nothing is left open."""
    say, out = speaker(language), Path(out or "out")
    number = number or next((name for name in EXERCISES if open_of(name)), "1")
    exercise = EXERCISES[number]
    place = out / "refute" / "csv" / f"{exercise.study}.csv"
    if due := plots.due_of([exercise.tables()], out):
        plots.make_tables(due, out)
    text = f"{number} · {say(exercise.claim)}\n\n{say('refute.how', table=place, n=exercise.trials)}\n"
    print(fitted(text, sys.stdout))
    try:
        for comparison in open_of(number):
            if not ask(number, comparison, read_table(place), say):
                return 1
        if "" not in answered(number):
            if not (told := input(f"{say('refute.sentence')}\n  > ").strip()):
                return 1
            keep([number, "", told])
    except EOFError:
        print()
        return 1
    print("\n" + say("refute.kept", file=folder() / NAME))
    return 0


def ask(number: str, comparison: Comparison, table, say: Speaker) -> bool:
    """One comparison, until its numbers are right or nothing is said; keeps what is right."""
    print(say(comparison.name))
    while words := read_row(f"  {say('refute.mean_and_error')} > ", 2, say):
        mean, error = numbers_in(words)
        if wrong := slip(*comparison.sides(table), mean, error):
            print(f"  ✗ {say(wrong)}")
            continue
        while (sign := input(f"  {say('refute.sign')} > ").strip().replace("−", "-")) != sign_of(mean, error):
            if not sign:
                return False
            print(f"  ✗ {say('refute.sign_claims' if abs(mean) <= 2 * error else 'refute.sign_is', times=shown(abs(mean) / max(error, 1e-300)))}")
        print(f"  ✓ {shown(mean)} ± {shown(error)}, {sign}")
        keep([number, comparison.name.removeprefix("refute."), shown(mean), shown(error), sign])
        return True
    return False


def answered(number: str) -> set:
    """What has been kept of an exercise: the comparisons' names, "" for the sentence."""
    path = folder() / NAME
    if not path.exists():
        return set()
    with open(path, newline="", encoding="utf-8", errors="replace") as file:
        return {row[1] for row in csv.reader(file) if len(row) > 2 and row[0] == number}


def open_of(number: str) -> list:
    return [one for one in EXERCISES[number].comparisons if one.name.removeprefix("refute.") not in answered(number)]


def keep(row: list) -> None:
    with open(folder() / NAME, "a", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerow(row)
