"""./course docs: hands over to the builder of the API pages."""

import sys
from pathlib import Path

from ..base.processes import running
from ..base.output_dir import made_dir


def docs(out: str) -> int:
    """Runs api.py and returns its exit code."""
    target = Path(out or "out/api")
    api = [sys.executable, "-B", "-m", "ch5_backend.course.documents.api", "--out", str(target)]
    with made_dir(target.parent), running(api) as process:
        return process.wait()
