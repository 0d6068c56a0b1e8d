"""The names of a file of the homework and of a stage: their own, and those that editors, mail programs and haste make of them."""

import difflib
import re
import unicodedata
from pathlib import Path

from .regions import FILES

WRITTEN_IN = {"cc", "cpp", "cxx", "c++", "c", "hpp", "txt", "doc", "docx", "pdf", "md", "rtf", "htm", "html"}  # in place of .cc


def meant(name: str) -> str:
    """The homework's file of this name, in whatever case and with the .txt that some editors append; "" if there is none."""
    name = name.lower().removesuffix(".txt")
    return name if name in FILES else ""


def resembled(name: str) -> str:
    """The homework's file that a name like "problem_final.cc", "2021_Li_problem.docx" or "gaugeprior.cpp" may stand for; "" if there
    is none."""
    stem, *endings = unicodedata.normalize("NFKC", name[-60:]).lower().strip().rstrip(".").split(".")
    if not endings or not WRITTEN_IN.issuperset(endings):
        return ""
    within = [file for file in FILES if Path(file).stem in stem]
    return (within + difflib.get_close_matches(f"{stem}.cc", FILES, 1, 0.8) + [""])[0]


def plain(name: str) -> str:
    """What is left of a stage's name: "1.1" of "Stage 1.1", "stage_1.1.md" and "1.1.cc", "problem.cc" of "../Problem.cc"."""
    name = Path(name).name
    number = re.fullmatch(r"(?:stage|阶段)?[ _-]*(\d[\d.]*[a-z]?)(?:\.cc|(?:\.zh)?\.md)?", name, re.IGNORECASE)
    return number[1] if number else meant(name) or resembled(f"{name.partition('.')[0]}.cc") or name


def namesake(file: str, folder: Path) -> str:
    """Another file there that may be meant for this one, such as "problem.cc.txt"; "" if there is none."""
    names = sorted(path.name for path in folder.iterdir() if path.name != file) if folder.is_dir() else []
    return next((name for name in names if file in (meant(name), resembled(name))), "")
