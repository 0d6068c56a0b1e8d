"""What deck 4, gauge freedom, shows."""

import sys
from pathlib import Path

# gauge_paper.py there holds what the paper reports.
sys.path.append(str(Path(__file__).resolve().parents[2] / "ch5_backend/apps/plot"))

from . import blocks, plots  # noqa: E402
from .facts import all_facts as facts  # noqa: E402,F401

# The block pictures need no table.
FIGURES = {**{name: lambda tables, lang, draw=draw: draw(lang) for name, draw in blocks.ALL.items()}, **plots.ALL}
