"""What deck 3, marginalization and sliding windows, shows."""

from . import blocks, plots
from .facts import all_facts as facts  # noqa: F401

FIGURES = blocks.FIGURES | plots.FIGURES
