"""Where things are, for the tests of the house."""

import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("CH5_BUILD", ROOT / "build" / "release"))
CXX = os.environ.get("CH5_CXX", "g++")


def tracked_files(*suffixes) -> list:
    """Paths relative to ROOT that belong to the project: git's list, or without git all but what git would ignore."""
    listing = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=ROOT,
                             capture_output=True, text=True)
    if listing.returncode == 0:
        paths = [Path(line) for line in listing.stdout.splitlines()]
    else:
        made = ("build", "out", "node_modules", "__pycache__", ".cache", ".git")
        paths = [path.relative_to(ROOT) for path in ROOT.rglob("*")]
        paths = [path for path in paths if not any(part.startswith(made) for part in path.parts)]
    return sorted(path for path in paths if (ROOT / path).is_file() and (not suffixes or path.suffix in suffixes))
