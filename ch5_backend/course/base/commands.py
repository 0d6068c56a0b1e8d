"""What each sub-command takes, from commands.json: {command: {en, zh: what it does, "arguments": {name: what it is}, "json": its
fields, "speaks": whether students read what it prints}}. An argument without "takes" is a flag; "range", "one_of" or "form" is
what its value must be, and "for" what of DATA an option of run is for.
"""

import argparse
import json
import math
import re
from pathlib import Path

from . import language
from .errors import CourseError

COMMANDS = json.loads(Path(__file__).with_suffix(".json").read_text(encoding="utf-8"))


def number(low, high):
    """A reader of a number in [low, high], whole if these are."""
    whole = isinstance(low, int)
    pattern = r"-?\d{1,18}" if whole else r"-?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?"
    words = f"a whole number from {low} to {high}" if whole else f"a number from {low:g} to {high:g}"

    def read(text: str):
        if not re.fullmatch(pattern, text, re.ASCII | re.IGNORECASE) or not low <= type(low)(text) <= high:
            raise must_be(words, text)
        return type(low)(text)
    return read


def one_of(*names):
    """A reader of one of these words."""
    def read(text: str) -> str:
        if text not in names:
            raise must_be(f"one of {', '.join(names)}", text)
        return text
    return read


def share(text: str) -> tuple:
    """"2/4" as (2, 4)."""
    numbers = re.fullmatch(r"(\d{1,6})/(\d{1,6})", text, re.ASCII)
    index, count = map(int, numbers.groups()) if numbers else (0, 0)
    if not 1 <= index <= count:
        raise must_be("I/N with I from 1 to N", text)
    return index, count


def interval(text: str) -> str:
    """A:B, either of which may be missing."""
    first, colon, last = text.partition(":")
    try:
        is_one = colon and 0.0 <= float(first or 0.0) < float(last or math.inf)
    except ValueError:
        is_one = False
    if not is_one:
        raise must_be("A:B with 0 ≤ A < B, in seconds since the first IMU measurement", text)
    return text


FORMS = {"share": share, "interval": interval, "list": lambda text: text.split(",")}


def must_be(what: str, text: str) -> argparse.ArgumentTypeError:
    return argparse.ArgumentTypeError(f"must be {what}, got '{text}'")


class Folded(argparse.HelpFormatter):
    """Chinese letters are two columns wide, and a line may end behind each of them."""

    def _split_lines(self, text: str, width: int) -> list:
        return language.fold(" ".join(text.split()), width).splitlines()

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return "\n".join(indent + line for line in self._split_lines(text, width))


class Parser(argparse.ArgumentParser):
    """An error becomes a CourseError, so that --json holds for it too."""

    def error(self, message: str):
        message = re.sub(r"^argument (\S+): ", r"\1 ", message)
        raise CourseError(f"{message}; see {self.prog} --help")


def make_parser(command: str, spoken: str = "") -> Parser:
    """One sub-command's grammar. Options are never abbreviated: a typing error must not run something else."""
    spoken, grammar = spoken or language.spoken(), COMMANDS[command]
    say = language.speaker(spoken)
    parser = Parser(prog=f"./course {command}", description=grammar[spoken], allow_abbrev=False, formatter_class=Folded, add_help=False)
    parser._positionals.title, parser._optionals.title = say("command.arguments"), say("command.options")
    parser.add_argument("-h", "--help", action="help", help=say("command.help"))
    for name, one in grammar["arguments"].items():
        parser.add_argument(name, help=one[spoken], **settings(name, one))
    if grammar.get("speaks"):
        parser.add_argument("--language", type=one_of(*language.LANGUAGES), default=spoken, metavar="WORD", help=say("command.language"))
    if fields := grammar.get("json"):
        parser.add_argument("--json", action="store_true", help=say("command.json", fields=fields.get(spoken, fields["en"])))
    return parser


def settings(name: str, one: dict) -> dict:
    """An argument in argparse's words."""
    if "takes" not in one:
        return {"action": "store_true"}
    found = {"metavar": one["takes"]} | {key: one[key] for key in ("dest", "default") if key in one}
    if not name.startswith("-"):
        found["nargs"] = "*" if one.get("many") else "?"
    if "range" in one:
        found["type"] = number(*one["range"])
    elif "one_of" in one:
        found["type"] = one_of(*one["one_of"])
    elif "form" in one:
        found["type"] = FORMS[one["form"]]
    return found
