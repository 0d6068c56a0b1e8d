"""What a page asks its tables: {{expression}} in its text, in Jinja2's language and with the filters below, such as
{{large.points | f0}} or {{table('prior_trials').weight.max() | number}}.
"""
import re
from functools import partial

from jinja2 import Environment, StrictUndefined, TemplateError

from .digits import fixed, minus, number, percent
from .tables import dense

PLACEHOLDER = re.compile(r"\{\{([^{}\n]+)\}\}")
FILTERS = {**{f"f{digits}": partial(fixed, digits=digits) for digits in range(5)}, "g": lambda value: minus(f"{value:g}"), "number": number, "percent": percent,
           "centi": lambda value: 100 * value, "milli": lambda value: 1e3 * value, "dense": dense}


def evaluator(**filters):
    """evaluate(expression, names) is its text; it raises NameError for what no name or filter is. `filters` are more of them."""
    pages = Environment(undefined=StrictUndefined)
    pages.filters |= FILTERS | filters

    def evaluate(expression, names):
        try:
            return str(pages.compile_expression(expression, undefined_to_none=False)(names))
        except (TemplateError, TypeError) as error:
            raise NameError(f"{{{{{expression}}}}}: {error}") from error
    return evaluate


EVALUATE = evaluator()


def fill(text, names):
    return PLACEHOLDER.sub(lambda found: EVALUATE(found[1], names), text)
