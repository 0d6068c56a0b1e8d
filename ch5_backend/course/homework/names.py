"""The names under which a file of the homework may lie: its own, and those that editors, mail programs and haste make of it."""

import difflib
from pathlib import Path

from .regions import FILES


def meant(name: str) -> str:
    """The homework's file of this name, in whatever case and with the .txt that some editors append; "" if there is none."""
    name = name.lower().removesuffix(".txt")
    return name if name in FILES else ""


def resembled(name: str) -> str:
    """The homework's file that a name like "problem_final.cc" or "gaugeprior.cpp" may stand for; "" if there is none."""
    stem, _, ending = name[:60].lower().removesuffix(".txt").partition(".")
    if ending not in ("cc", "cpp", "cxx", "c"):
        return ""
    begun = [file for file in FILES if stem.startswith(Path(file).stem)]
    return (begun + difflib.get_close_matches(f"{stem}.cc", FILES, 1, 0.8) + [""])[0]


def namesake(file: str, folder: Path) -> str:
    """Another file there that may be meant for this one, such as "problem.cc.txt"; "" if there is none."""
    names = sorted(path.name for path in folder.iterdir() if path.name != file) if folder.is_dir() else []
    return next((name for name in names if file in (meant(name), resembled(name))), "")
