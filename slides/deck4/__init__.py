"""What deck 4, gauge freedom, shows."""

from . import blocks, plots
from .facts import all_facts as facts

# The block pictures need no table.
FIGURES = {**{name: lambda tables, lang, draw=draw: draw(lang) for name, draw in blocks.ALL.items()}, **plots.ALL}
