#!/usr/bin/env python3
"""Makes ch5_homework/*.cc from solutions/*.cc: each graded region becomes its hints and a throw.

  make_skeleton.py                 writes ch5_homework/, all of it
  make_skeleton.py --check         compares instead: 0 current, 1 not, 77 a student is at work (not in CI)
  make_skeleton.py --output DIR    writes elsewhere
  make_skeleton.py --blank 1.1a    blanks this region only, repeatable; the others hold the solution
  make_skeleton.py --depth N       2: more blanks, and no lines to fill in; 3: empty functions; see ./course deep
"""

import argparse
import itertools
import os
import sys
from pathlib import Path

from ..base.cmake_build import HOMEWORK
from ..base.errors import CourseError
from ..base.language import sentence, speaker
from .blanks import BARE, DEEP, content_of, depth_of
from .regions import FILES, ROOT, STAGES, emptied, fill, regions, solution_text

STUDENT_AT_WORK = 77  # CTest's SKIP_RETURN_CODE
DEPTHS = (1, 2, 3)
AT = ("skeleton.at_first_depth", "skeleton.at_second_depth", "skeleton.at_third_depth")
ALL_AT = ("skeleton.first_depth", "skeleton.second_depth", "skeleton.third_depth")
OTHERS_AT = ("skeleton.others_first_depth", "skeleton.others_second_depth", "skeleton.others_third_depth")


def skeleton(name: str, blanks=None, depth: int = 1) -> str:
    """The student's file; `blanks` are the TODOs to blank, by default all of this depth."""
    def content(region):
        blank = region.todo in blanks if blanks is not None else depth > 1 or region.kind == "SOLUTION"
        return region.blank(depth > 1) if blank else region.solution
    text = fill(solution_text(name), content)
    return (text, DEEP + text, BARE + emptied(text))[depth - 1]


def check(folder: Path) -> int:
    verdict = 0
    for name in FILES:
        wanted, found = skeleton(name), (folder / name).read_text(encoding="utf-8")
        if found == wanted:
            continue
        fewer = found.count("throw HomeworkMissing") < wanted.count("throw HomeworkMissing")
        if (fewer or found in untouched(name)) and not os.environ.get("CI"):
            print(f"{name}: some TODOs are filled, or it is of another depth, so there is nothing to compare")
            verdict = verdict or STUDENT_AT_WORK
        else:
            print(f"{name}: not what solutions/{name} gives; run python3 -m ch5_backend.course.homework.make_skeleton")
            verdict = 1
    return verdict


def table_is_true() -> bool:
    """The stage table and the markers name the same TODOs."""
    marked = [(name, region.todo, region.kind) for name in FILES for region in regions(solution_text(name))]
    listed = [(stage["file"], todo, kind) for stage in STAGES
              for kind, todos in (("SOLUTION", stage["todos"]), ("DEEP", stage.get("deep", []))) for todo in todos]
    if sorted(marked) != sorted(listed):
        print("ch5_homework/stages.json and solutions/ differ:", sorted(set(marked) ^ set(listed)))
    return sorted(marked) == sorted(listed)


def untouched(name: str) -> list:
    return [skeleton(name, depth=depth) for depth in DEPTHS]


def holds_work(path: Path) -> bool:
    """Whether a student has begun this file."""
    return path.exists() and path.read_text(encoding="utf-8", errors="replace") not in untouched(path.name)


def present_depth(name: str) -> int:
    """The depth of a file: its own where it is there, otherwise that of the others."""
    contents = [content_of(HOMEWORK / file) for file in (name, *FILES)]
    return depth_of(next((content for content in contents if content), b""))


def deepen(off: bool, bare: bool, language: str) -> int:
    """Writes each file of the homework at the depth asked for, unless a student has begun it at another one. Returns 0: what
    was left as it is has been named. Raises CourseError(2)."""
    if off and bare:
        raise CourseError(sentence("skeleton.one_depth"))
    depth = 1 if off else 3 if bare else 2
    say, begun = speaker(language), []
    HOMEWORK.mkdir(parents=True, exist_ok=True)
    for name in FILES:
        if not holds_work(HOMEWORK / name):
            (HOMEWORK / name).write_text(skeleton(name, depth=depth), encoding="utf-8")
        elif present_depth(name) != depth:
            begun.append(name)
            print(say("skeleton.holds_work", file=name, command=f"./course reset {name}"))
    print(say((OTHERS_AT if begun else ALL_AT)[depth - 1]))
    return 0


def set_aside(path: Path) -> Path:
    """Renames a file to the first free one of NAME.before, NAME.before.2, …; the new path."""
    for n in itertools.count(1):
        kept = path.with_name(f"{path.name}.before" + (f".{n}" if n > 1 else ""))
        try:
            os.link(path, kept)  # unlike a renaming it replaces nothing
        except FileExistsError:
            continue
        except OSError:  # a file system without links
            if kept.exists():
                continue
            path.replace(kept)
            return kept
        path.unlink()
        return kept


def reset(files: list, language: str) -> int:
    """Restores the skeleton of these files, each at its depth; the old versions are kept beside them. Raises CourseError(2) for
    what is no homework."""
    names, say = list(dict.fromkeys(Path(file).name for file in files)), speaker(language)
    if not names or not set(names) <= set(FILES):
        raise CourseError(sentence("skeleton.which_file", files=", ".join(FILES)))
    HOMEWORK.mkdir(parents=True, exist_ok=True)
    for name in names:
        path, depth = HOMEWORK / name, present_depth(name)
        kept = set_aside(path).name if holds_work(path) else ""
        path.write_text(skeleton(name, depth=depth), encoding="utf-8")
        print(say("skeleton.begun_anew_kept" if kept else "skeleton.begun_anew", file=name, depth=sentence(AT[depth - 1]), kept=kept))
    return 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--output", type=Path, default=ROOT / "ch5_homework", metavar="DIR")
    parser.add_argument("--blank", action="append", metavar="TODO")
    parser.add_argument("--depth", type=int, choices=DEPTHS, default=1)
    options = parser.parse_args()
    if not table_is_true():
        return 1
    if options.check:
        return check(options.output)
    options.output.mkdir(parents=True, exist_ok=True)
    for name in FILES:
        (options.output / name).write_text(skeleton(name, options.blank, options.depth), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
