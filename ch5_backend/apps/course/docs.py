"""./course docs: hands over to the builder of the API pages."""

import sys
from pathlib import Path

from .build import ROOT
from .children import running
from .place import make_writable


def docs(out: str) -> int:
    """Runs apps/docs/build.py and returns its exit code."""
    target = Path(out or "out/api")
    make_writable(target.parent)
    with running([sys.executable, "-B", str(ROOT / "ch5_backend/apps/docs/build.py"), "--out", str(target)]) as process:
        return process.wait()
