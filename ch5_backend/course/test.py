"""./course test: builds everything and runs CTest."""

import re
import sys

from .base.cmake_build import BUILD, CORES, ROOT, build_or_fail, run_logged
from .base.errors import CourseError
from .base.progress import Progress


def test(names: list, quick: bool, nightly: bool, extra: list) -> int:
    """Runs the tests whose names match one of `names` (default: all but the nightly ones), with `extra` words for CTest.

    Prints what failed and CTest's closing lines. Returns 0 if all passed, else 1.
    """
    refuse(names)
    build_or_fail()
    command = ["ctest", "--test-dir", str(BUILD), "-j", str(CORES), "--output-on-failure", "--no-tests=error"]
    if names:
        command += ["-R", "|".join(names)]
    if nightly:
        command += ["-L", "nightly"]
    elif quick or not names:
        command += ["-LE", "slow|nightly" if quick else "nightly"]
    failed = []
    with Progress("test") as progress:
        def step(line: str) -> None:
            if "***" in line:
                failed.append(line)
            if re.match(r"\d+/\d+ ", line):
                progress.step(line + (f"   {len(failed)} failed" if failed else ""))
        done = run_logged(command + extra, "ctest.log", step)
    for line in done.stdout.splitlines():
        if not re.match(r"Internal ctest|Test project|\s*Start +\d+:|.* Passed +[\d.]+ sec$", line):
            print(line)
    if done.returncode:
        print(f"The whole log: {BUILD / 'ctest.log'}", file=sys.stderr)
    return 1 if done.returncode else 0


def refuse(names: list) -> None:
    """Raises CourseError for the name of no test."""
    for name in names:
        require_known(name)


def require_known(name: str) -> None:
    """Raises CourseError if no test can have this name, before everything is built, after which CTest knows all names: they
    consist of words that stand in the tests' sources or file names."""
    if not re.fullmatch(r"[\w.]+", name):
        return  # other patterns are CTest's to read
    sources = [path for folder in ("tests", "ch5_homework/judge") for path in (ROOT / folder).rglob("*")
               if path.suffix in (".cc", ".h", ".py", ".txt", ".cmake")]
    text = "\n".join(f"{path.stem}\n{path.read_text(encoding='utf-8', errors='replace')}" for path in sources)
    if unknown := [word for word in re.findall(r"[^\W_]+", name) if word not in text]:
        raise CourseError(f"no test is called {name}: '{unknown[0]}' occurs in none")
