"""Which submissions there are: named one by one, in a list, or by the folder that a platform's download unpacks to."""

import os
import re
from functools import lru_cache
from pathlib import Path

from ..base.errors import CourseError
from ..homework.names import meant
from . import outputs
from .owners import CANVAS, platform_name
from .submission import ARCHIVES

OWN_FILES = ("grades.csv", "unnamed.csv", "summary.html", "session.json", "students.csv", "canvas.csv", "moodle.csv")  # beside the submissions' folders
NO_SUBMISSIONS = ("submission_metadata.yml", ".ds_store", "thumbs.db", "desktop.ini", "__macosx")  # what lies beside them
TABLES = (".csv", ".xls", ".xlsx", ".yml")  # of the class, kept in the same folder
LONGEST_NAME = 200  # bytes


def listed(paths: list, list_file: str) -> list:
    """The paths of submissions, without other files. A single folder that holds a class's submissions means all of
    them; each line of a list is a submission."""
    paths = [Path(path) for path in paths]
    if len(paths) == 1 and not list_file:
        paths = class_in(paths[0]) or paths
    if list_file:
        try:
            lines = Path(list_file).read_text(encoding="utf-8-sig", errors="surrogateescape").splitlines()
        except OSError as error:
            raise CourseError(f"{list_file}: cannot be read: {error.strerror}") from error
        for number, line in enumerate(lines, 1):
            if line.strip() and not os.path.lexists(line):
                raise CourseError(f"{list_file}:{number}: there is no such submission, got '{line}'")
        paths += [Path(line) for line in lines if line.strip()]
    return [path for path in paths if not is_beside(path)]


def is_beside(path: Path) -> bool:
    """Whether it is no submission, but lies beside them."""
    return path.name.lower() in NO_SUBMISSIONS or (path.suffix.lower() in TABLES and not platform_name(path.name))


def class_in(folder: Path) -> list:
    """The submissions in a folder, or [] of one that is a submission itself: no file of the homework lies in it, but two or more
    archives, files that a platform has named, or folders with one and the same file."""
    if folder.is_symlink() or not folder.is_dir():
        return []
    members = sorted(path for path in folder.iterdir() if not is_beside(path) and not path.name.startswith("."))
    if any(meant(path.name) for path in members):
        return []
    named = [path for path in members if platform_name(path.name)]
    archives = [path for path in members if path.name.lower().endswith(ARCHIVES)]
    held = [meant(file.name) for path in members if path.is_dir() and not path.is_symlink()
            for _, file in zip(range(1000), path.rglob("*")) if meant(file.name)]
    several = max(map(held.count, held), default=0)
    return members if max(len(named), len(archives), several) > 1 or (folder / "submission_metadata.yml").exists() else []


def named(paths: list) -> dict:
    """{name of its folder: its paths}; submissions with the same name are distinguished by their folders. Files that a
    platform has named for one student, such as li_12345_678_problem.cc and li_12345_679_gauge_prior.cc, are one, newest first."""
    groups = {}
    for path in (path.absolute() for path in paths):
        if any(path in group for group in groups.values()):
            raise CourseError(f"{path}: this submission is named twice")
        groups.setdefault(group_of(path) or path, []).append(path)
    names = {}
    for path, group in groups.items():
        parts = [part for part in path.parts if part != path.anchor]
        tries = ["-".join(parts[-depth:]) for depth in range(1, len(parts) + 1)]
        tries.append(f"{tries[0]}-{outputs.short_hash(str(path))}")  # where the letters that differ are none of a name
        name = next(name for name in map(folder_name, tries) if name not in names and name not in OWN_FILES)
        names[name] = sorted(group, key=attachment, reverse=True)
    return names


def group_of(path: Path):
    """Where the files of this student are gathered, or None."""
    found = None if path.is_dir() else platform_name(path.name)
    return path.with_name(path.name[:found.end("number")]) if found else None


def attachment(path: Path) -> int:
    """Canvas's number of the file, which grows."""
    found = CANVAS.fullmatch(path.name)
    return int(found["attachment"]) if found else 0


def folder_name(text: str) -> str:
    """With the letters of any language, and of what is not UTF-8 the bytes."""
    text = re.sub("[\udc80-\udcff]", lambda byte: f"_{ord(byte[0]) - 0xdc00:X}", text)
    name = re.sub(r"[^\w.@ +-]", "_", text).encode()[-LONGEST_NAME:].decode("utf-8", "ignore")
    return name.strip(". ") or "_"


@lru_cache
def gradescope(folder: Path) -> dict:
    """{submission: {"submitters": [{"name", "sid", "email"}], "sent"}} of the submission_metadata.yml there."""
    path, found, section = folder / "submission_metadata.yml", {}, ""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines() if path.is_file() else []
    for line in lines:
        if top := re.fullmatch(r"['\"]?(\w[^:'\"]*)['\"]?:", line):
            entry = found.setdefault(top[1], {"submitters": []})
        elif time := re.fullmatch(r"  :created_at: '?(\d{4}-\d\d-\d\d) (\d\d:\d\d:\d\d)\S* ?(Z|UTC|[+-]\d\d:?\d\d)'?", line):
            zone = "+00:00" if time[3] in ("Z", "UTC") else f"{time[3][:3]}:{time[3][-2:]}"
            entry["sent"] = f"{time[1]}T{time[2]}{zone}"
        elif one := re.fullmatch(r"  (- |  ):(name|sid|email): ['\"]?(.*?)['\"]?", line):
            if section == "submitters":
                if one[1] == "- ":
                    entry["submitters"].append({})
                entry["submitters"][-1][one[2]] = one[3]
        elif under := re.fullmatch(r"  :(\w+):.*", line):
            section = under[1]
    return found
