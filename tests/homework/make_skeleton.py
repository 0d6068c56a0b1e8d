#!/usr/bin/env python3
"""Makes ch5_homework/*.cc from solutions/*.cc: each graded region becomes its hints and a throw.

  make_skeleton.py                 writes ch5_homework/, all of it
  make_skeleton.py problem.cc      writes this file anew, and leaves the others alone
  make_skeleton.py --check         compares instead: 0 current, 1 not, 77 a student is at work (not in CI)
  make_skeleton.py --output DIR    writes elsewhere
  make_skeleton.py --blank 1.1a    blanks this region only, repeatable; the others hold the solution
"""

import argparse
import os
import sys
from pathlib import Path

from regions import FILES, ROOT, STAGES, fill, regions, solution_text

STUDENT_AT_WORK = 77  # CTest's SKIP_RETURN_CODE


def skeleton(name: str, blanks=None) -> str:
    """The student's file; `blanks` are the TODOs to blank, all of them by default."""
    def content(region):
        return region.blank() if blanks is None or region.todo in blanks else region.solution
    return fill(solution_text(name), content)


def check(folder: Path) -> int:
    verdict = 0
    for name in FILES:
        wanted, found = skeleton(name), (folder / name).read_text(encoding="utf-8")
        if found == wanted:
            continue
        if found.count("throw HomeworkMissing") < wanted.count("throw HomeworkMissing") and not os.environ.get("CI"):
            print(f"{name}: some TODOs are filled, so there is nothing to compare")
            verdict = verdict or STUDENT_AT_WORK
        else:
            print(f"{name}: not what solutions/{name} gives; run tests/homework/make_skeleton.py")
            verdict = 1
    return verdict


def table_is_true() -> bool:
    """The stage table and the markers name the same TODOs."""
    marked = [(name, region.todo) for name in FILES for region in regions(solution_text(name))]
    listed = [(stage["file"], todo) for stage in STAGES for todo in stage["todos"]]
    if sorted(marked) != sorted(listed):
        print("ch5_homework/stages.json and solutions/ differ:", sorted(set(marked) ^ set(listed)))
    return sorted(marked) == sorted(listed)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", metavar="FILE")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--output", type=Path, default=ROOT / "ch5_homework", metavar="DIR")
    parser.add_argument("--blank", action="append", metavar="TODO")
    options = parser.parse_args()
    if not table_is_true():
        return 1
    if options.check:
        return check(options.output)
    if unknown := set(options.files) - set(FILES):
        parser.error(f"no homework is in {', '.join(sorted(unknown))}; there are {', '.join(FILES)}")
    options.output.mkdir(parents=True, exist_ok=True)
    for name in options.files or FILES:
        (options.output / name).write_text(skeleton(name, options.blank), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
