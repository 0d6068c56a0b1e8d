"""Puts the numbers of the gauge experiments into the model answer of stage 4, in both languages.

In solutions/gauge_freedom*.md a number stands between two comments, of which the first says where it comes from:
<!-- methods; sine planes free; mean iterations; .2f -->5.05<!-- -->.
"""
import argparse
import re
import sys
from pathlib import Path

from .digits import power_of_ten
from .tables import TableError, read_table

ROOT = Path(__file__).resolve().parents[2]
ANSWERS = tuple(ROOT / "solutions" / f"gauge_freedom{language}.md" for language in ("", ".zh"))
NUMBER = re.compile(r"<!-- ([^;>]+); ([^;>]+); ([^;>]+); (\S+) -->([^<]*)<!-- -->")


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
    return f"{digits}·{power_of_ten(int(exponent))}"


def main(arguments):
    parser = argparse.ArgumentParser(prog="gauge_answer.py", description=__doc__.partition("\n")[0])
    parser.add_argument("summary", metavar="SUMMARY.csv", help="what gauge_report.py has written")
    parser.add_argument("--check", action="store_true", help="write nothing, and exit with 1 if a number differs")
    given = parser.parse_args(arguments)
    try:
        numbers = {(row["study"], row["of"], row["what"]): row["value"] for row in read_table(given.summary).rows()}
        for answer in ANSWERS:
            old = answer.read_text(encoding="utf-8")
            new = filled(old, numbers, answer.name)
            if given.check and new != old:
                print(f"{answer.name}: a number is not that of {given.summary}; run gauge_answer.py {given.summary}")
                return 1
            if new != old:
                answer.write_text(new, encoding="utf-8")
    except (OSError, TableError, KeyError) as error:
        print(f"{parser.prog}: {error.args[0]}" if isinstance(error, KeyError) else f"{parser.prog}: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
