"""What deck 5, g2o's structure and a fast block solver, shows. Its measured tables are kept here: measure.py makes them."""

from . import blocks, plots
from .facts import facts  # noqa: F401

FIGURES = blocks.FIGURES | plots.FIGURES
