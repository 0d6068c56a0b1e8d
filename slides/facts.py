"""What a page writes between double braces: the name of a fact, or an expression of Jinja2 such as {{large.points | f0}}, with the
tables and facts of its deck as its names and the filters below.
"""

import re
from pathlib import Path

from jinja2 import Environment, StrictUndefined, TemplateError

from ch5_backend.figures.numbers.windows import KEPT
from ch5_backend.figures.style import percent
from ch5_backend.figures.tables import dense

from .tex import power, scientific, short

ROOT = Path(__file__).resolve().parents[1]
PLACEHOLDER = re.compile(r"\{\{([^{}\n]+)\}\}")
FILTERS = {**{f"f{digits}": f"{{:.{digits}f}}".format for digits in range(5)}, "g": "{:g}".format, "sci": scientific, "percent": percent, "power": power, "short": short,
           "centi": lambda value: 100 * value, "milli": lambda value: 1e3 * value, "dense": dense}
PAGES = Environment(undefined=StrictUndefined)
PAGES.filters |= FILTERS


def written(expression, facts, tables):
    """The text of a placeholder. Raises NameError for a name that nothing has."""
    if isinstance(facts.get(expression), str):
        return facts[expression]
    names = {"table": tables, "kept": KEPT, **{name: value for name, value in facts.items() if name.isidentifier()}}
    try:
        return str(PAGES.compile_expression(expression, undefined_to_none=False)(names))
    except (TemplateError, TypeError) as error:
        raise NameError(error) from error


def gathered(*parts):
    """facts(tables) of a deck, {name: text, or what an expression can name}: those of all its parts."""
    return lambda tables: {name: text for part in parts for name, text in part(tables).items()}


def typed_in(path, pattern):
    """What the groups of a pattern are in a file of the project: words, or one word for one group."""
    found = re.search(pattern, (ROOT / path).read_text(encoding="utf-8"), re.DOTALL).groups()
    return found if len(found) > 1 else found[0]
