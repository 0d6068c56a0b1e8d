"""What deck 2, solvers, shows."""

from . import blocks, losses, plots
from .facts import facts  # noqa: F401

FIGURES = {**blocks.ALL, **plots.ALL, **losses.ALL}
