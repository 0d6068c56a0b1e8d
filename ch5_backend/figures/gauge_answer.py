#!/usr/bin/python3
"""Puts the numbers of the gauge experiments into the model answer of stage 4, in both languages.

usage: gauge_answer.py SUMMARY.csv [--check]      SUMMARY.csv is what gauge_report.py has written

In solutions/gauge_freedom*.md a number stands between two comments, of which the first says where it comes from:
<!-- methods; sine planes free; mean iterations; .2f -->5.05<!-- -->. With --check nothing is written; the exit code is 1
if a number differs.
"""
import csv
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ANSWERS = tuple(ROOT / "solutions" / f"gauge_freedom{language}.md" for language in ("", ".zh"))
NUMBER = re.compile(r"<!-- ([^;>]+); ([^;>]+); ([^;>]+); (\S+) -->([^<]*)<!-- -->")


def read_summary(path):
    """{(study, of, what): value}"""
    with open(path, encoding="utf-8", newline="") as file:
        return {(row["study"], row["of"], row["what"]): float(row["value"]) for row in csv.DictReader(file)}


def filled(text, numbers, name):
    """The text with all its numbers anew. Raises KeyError with words for a number that the summary does not have."""
    def put(match):
        key = match.groups()[:3]
        if key not in numbers:
            line = text[:match.start()].count("\n") + 1
            raise KeyError(f"{name}:{line}: the summary has no number '{'; '.join(key)}'")
        shown = power(numbers[key]) if match[4] == "power" else format(numbers[key], match[4])
        return f"<!-- {'; '.join(match.groups()[:4])} -->{shown}<!-- -->"
    return NUMBER.sub(put, text)


def power(value):
    """2e-9 as 2·10⁻⁹."""
    digits, exponent = f"{value:.0e}".split("e")
    return f"{digits}·10" + str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def main(arguments):
    check = "--check" in arguments
    paths = [word for word in arguments if word != "--check"]
    if len(paths) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    try:
        numbers = read_summary(paths[0])
        for answer in ANSWERS:
            old = answer.read_text(encoding="utf-8")
            new = filled(old, numbers, answer.name)
            if check and new != old:
                print(f"{answer.name}: a number is not that of {paths[0]}; run gauge_answer.py {paths[0]}")
                return 1
            if new != old:
                answer.write_text(new, encoding="utf-8")
    except (OSError, KeyError) as error:
        print(f"gauge_answer.py: {error.args[0] if isinstance(error, KeyError) else error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
