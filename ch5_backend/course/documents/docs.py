"""./course docs: hands over to the builder of the API pages."""

import sys
from pathlib import Path

from ..base.processes import running
from ..base.output_dir import make_writable


def docs(out: str) -> int:
    """Runs api.py and returns its exit code."""
    target = Path(out or "out/api")
    make_writable(target.parent)
    with running([sys.executable, "-B", "-m", "ch5_backend.course.documents.api", "--out", str(target)]) as process:
        return process.wait()
