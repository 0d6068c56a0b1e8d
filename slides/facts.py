"""What a page writes between double braces: the name of a fact, or a question to the tables, see figures/queries.py, whose names are
`table`, `kept` and the facts of its deck.
"""

import re
from pathlib import Path

from ch5_backend.figures.numbers.windows import KEPT
from ch5_backend.figures.queries import evaluator

from .tex import power, scientific, short

ROOT = Path(__file__).resolve().parents[1]
EVALUATE = evaluator(sci=scientific, power=power, short=short)


def written(expression, facts, tables):
    """The text of a placeholder. Raises NameError for a name that nothing has."""
    if isinstance(facts.get(expression), str):
        return facts[expression]
    return EVALUATE(expression, {"table": tables, "kept": KEPT, **{name: value for name, value in facts.items() if name.isidentifier()}})


def gathered(*parts):
    """facts(tables) of a deck, {name: text, or what an expression can name}: those of all its parts."""
    return lambda tables: {name: text for part in parts for name, text in part(tables).items()}


def typed_in(path, pattern):
    """What the groups of a pattern are in a file of the project: words, or one word for one group."""
    found = re.search(pattern, (ROOT / path).read_text(encoding="utf-8"), re.DOTALL).groups()
    return found if len(found) > 1 else found[0]
