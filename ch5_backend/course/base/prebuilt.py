"""The lab and the decks as PDF are built once and given to many: whether they are still what their sources would give.

Beside out/lab.html lies lab.sources.json, {file: hash of what it was made of}; a deck's record is slides/build.py's own, which
compares words, numbers and figures.
"""

import hashlib
import json
import re
import subprocess
import sys
from pathlib import Path

from ch5_backend.figures.atomic_write import write_whole

from .cmake_build import ROOT

RECORD = "lab.sources.json"
OF_THE_LAB = ("ch5_backend/**/*.h", "ch5_backend/**/*.cc", "ch5_backend/lab/page/*", "solutions/*.cc")
NOT_OF_THE_LAB = ("ch5_backend/examples/", "ch5_backend/python/")


def lab_sources() -> dict:
    """{file: hash}"""
    names = {str(path.relative_to(ROOT)): path for pattern in OF_THE_LAB for path in ROOT.glob(pattern)}
    return {name: digest(path) for name, path in sorted(names.items()) if not name.startswith(NOT_OF_THE_LAB)}


def record_lab(folder: Path, sources: dict) -> None:
    """Says beside FOLDER/lab.html what it was made of."""
    write_whole(folder / RECORD, json.dumps({"lab.html": digest(folder / "lab.html"), **sources}, indent=1) + "\n")


def why_not_lab(folder: Path) -> str:
    """What is wrong with FOLDER/lab.html, in words; "" if it is as its sources would give it.

    The students' archive has the solutions as objects: there they are not compared.
    """
    if not (folder / "lab.html").exists():
        return "it is not there"
    if not (folder / RECORD).exists():
        return "nothing says what it was made of"
    record, now = json.loads((folder / RECORD).read_text(encoding="utf-8")), lab_sources()
    if record.pop("lab.html") != digest(folder / "lab.html"):
        return "it is not as it was built"
    if not any(name.startswith("solutions/") for name in now):
        record = {name: its for name, its in record.items() if not name.startswith("solutions/")}
    changed = sorted(name for name in {*record, *now} if record.get(name) != now.get(name))
    return f"{changed[0]} has changed since" + (f", and {len(changed) - 1} more" if changed[1:] else "") if changed else ""


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


def stale_decks(out: Path) -> dict:
    """{deck, such as "1-back-end.en": what is wrong with OUT/slides/DECK.pdf}, of those where anything is."""
    done = subprocess.run([sys.executable, "-B", "-m", "slides.build", "--check", "--csv", out / "csv", "--out", out / "slides"],
                          cwd=ROOT, capture_output=True, text=True, check=False)
    said = re.findall(r"^slides: (\d-[\w.-]+): (.*)$", done.stderr, re.MULTILINE)
    found = {deck: words for deck, words in reversed(said)}  # the first of each
    if done.returncode and not found:  # as when tables are missing
        words = done.stderr.strip().rpartition("\n")[2].removeprefix("slides: ")
        return {path.stem: words for path in (ROOT / "slides").glob("[0-9]-*.md")}
    for path in sorted((ROOT / "slides").glob("[0-9]-*.md")):
        pdf = out / "slides" / f"{path.stem}.pdf"
        if path.stem not in found and not pdf.exists():
            found[path.stem] = "there is no PDF"
    return found
