"""What stands behind ./course: one module per idea."""

import sys
from pathlib import Path

PLOT = Path(__file__).resolve().parents[1] / "plot"
sys.path.insert(0, str(PLOT))  # has what writes pages, and whole files
