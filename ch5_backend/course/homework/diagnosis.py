"""Why a stage has failed, as data, and in words.

A diagnosis is a dict: its "cause" is something said (see base/language). That of a test has more, as
ch5_homework/judge/diagnosis.h writes it: "stage", "check", "expected", "got", "places" and "todo".
"""

from typing import NamedTuple

from ..base.language import Speaker, pad, sentence

LABEL_WIDTH = 10
MORE = "\n" + " " * (LABEL_WIDTH + 2)  # where a text of several lines goes on
SHOWN_LINES = 15  # of a diagnosis, of the compiler's words, of what the student's file prints

# Causes that give no answer away, nor say which mistake it is.
SYMPTOMS = ("matrix.none_typical", "matrix.none_typical_not_symmetric", "7.none_typical")
# Slips of which a formula has many, so that one may fit by coincidence: what else may stand for a block, and where else it may be read.
ONE_OF_MANY = ("formula.stands_for", "formula.starts_at", "formula.starts_at_entry", "formula.from_another_source")
UNSET = ("matrix.still_empty", "matrix.still_zero", "matrix.never_set", "1.2.landmark_step_unset")


class Verdict(NamedTuple):
    state: str
    diagnosis: dict = {}  # of the first failure
    output: str = ""      # the compiler's own words, or GoogleTest's
    printed: str = ""     # what the student's own code has printed in the test that failed
    printed_bytes: int = 0  # all of it, of which `printed` holds the beginning and the end
    tests: tuple = ()     # what GoogleTest reports of each test that was run
    todos: dict = {}      # {todo: its mark}, see ticks.py


def because(name: str, /, **arguments) -> dict:
    """The diagnosis of what ended before a test could compare anything."""
    return {"cause": sentence(name, **arguments)}


def said_in(diagnosis: dict) -> list:
    """What a diagnosis says, piece by piece."""
    places = [piece for place in diagnosis.get("places", ()) for piece in place]
    return [diagnosis[key] for key in ("check", "expected", "got", "cause") if key in diagnosis] + places


def cause_of(diagnosis: dict) -> str:
    """The id of the cause, or ""."""
    cause = diagnosis.get("cause", "")
    return cause.get("id", "") if isinstance(cause, dict) else ""


def is_only_seen(diagnosis: dict) -> bool:
    """Whether a diagnosis says what is seen of a matrix, not what has made it so."""
    return cause_of(diagnosis) in SYMPTOMS or (cause_of(diagnosis).startswith("matrix.") and cause_of(diagnosis) not in UNSET)


def what_of(diagnosis: dict, say: Speaker) -> str:
    return say("diagnosis.what", stage=diagnosis["stage"], what=diagnosis["check"])


def in_short(diagnosis: dict, say: Speaker) -> str:
    """One or two sentences."""
    if "check" not in diagnosis:
        return say.text(diagnosis.get("cause", ""))
    if "cause" not in diagnosis:
        return say("diagnosis.without_cause", what=what_of(diagnosis, say))
    return say("diagnosis.in_short", what=what_of(diagnosis, say), cause=diagnosis["cause"])


def describe(diagnosis: dict, say: Speaker) -> str:
    """All of a test's diagnosis: what it is about, then labels, each with its text."""
    todo = diagnosis.get("todo", "").split()[-1:]
    lines = [(say(label), diagnosis[key]) for key, label in (("expected", "diagnosis.expected"), ("got", "diagnosis.got"))
             if key in diagnosis]
    lines += [(say.text(place), name) for place, name in diagnosis.get("places", ())]
    if cause := diagnosis.get("cause") or diagnosis.get("held_back"):
        lines.append((say("diagnosis.cause"), cause))
    lines.append((say("diagnosis.read"), sentence("diagnosis.handout_todo" if todo else "diagnosis.handout",
                                                  stage=diagnosis["stage"], **({"todo": todo[0]} if todo else {}))))
    labeled = ["  " + (pad(label, LABEL_WIDTH) if len(label) < LABEL_WIDTH else label + " ") +
                say.text(text).replace("\n", MORE) for label, text in lines]
    return "\n".join([what_of(diagnosis, say), *labeled])


def in_full(diagnosis: dict, output: str, say: Speaker) -> str:
    """The whole verdict; above the compiler's own words, what they mean."""
    if "check" in diagnosis:
        return describe(diagnosis, say)
    short = in_short(diagnosis, say)
    return output if short and output.startswith(short) else f"{short}\n\n{output}".strip()
