"""What deck 2, solvers, shows."""

from . import blocks, plots
from .facts import facts  # noqa: F401

FIGURES = blocks.FIGURES | plots.FIGURES
