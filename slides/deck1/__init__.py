"""What deck 1, the back end, shows."""

from . import blocks, plots
from .facts import all_facts as facts

FIGURES = blocks.FIGURES | plots.FIGURES
