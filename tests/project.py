"""Where things are: CTest says it in the environment, else it is where ./course puts it."""

import os
import shutil
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BUILD = Path(os.environ.get("CH5_BUILD", ROOT / "build" / "release"))
DATA = Path(os.environ.get("CH5_DATA_DIR", ROOT.parent / "shared" / "data"))
OUT = Path(os.environ.get("CH5_TABLES", ROOT / "out")).resolve()  # its csv/ has the chapter's tables
TINY_BAL = "1 1 1\n0 0 0.5 0.5\n" + "0\n" * 6 + "1\n0\n0\n" + "0\n0\n-1\n"
CXX = os.environ.get("CH5_CXX", "g++")
EIGEN = next((path for path in ("/usr/include/eigen3", "/usr/local/include/eigen3", "/opt/homebrew/include/eigen3")
              if os.path.isdir(path)), "/usr/include/eigen3")


def run(program, *words, **options) -> subprocess.CompletedProcess:
    """What a program prints that nobody answers; ./course builds where these tests are built."""
    usual = {"capture_output": True, "text": True, "env": {"CH5_BUILD_DIR": str(BUILD), **os.environ}}
    if "input" not in options:
        usual["stdin"] = subprocess.DEVNULL
    return subprocess.run([program, *map(str, words)], **{**usual, **options})


def tracked_files(*suffixes) -> list:
    """Paths relative to ROOT that belong to the project: git's list, or else all but what the build makes."""
    paths = git_files()
    if paths is None:
        made = {"out", "node_modules", "__pycache__", ".cache", ".git"}
        paths = [path.relative_to(ROOT) for path in ROOT.rglob("*")]
        paths = [path for path in paths if not made & set(path.parts) and not path.parts[0].startswith("build")]
    return sorted(path for path in paths if (ROOT / path).is_file() and (not suffixes or path.suffix in suffixes))


def git_files():
    """None in an unpacked archive, without git, and where git refuses the folder, which may be another user's."""
    if not (ROOT / ".git").exists() or not shutil.which("git"):
        return None
    listing = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=ROOT,
                             capture_output=True, text=True)
    return [Path(line) for line in listing.stdout.splitlines()] if listing.returncode == 0 else None
