"""./course test: builds what the tests need and runs CTest."""

import re
import shlex
import subprocess
import sys
from collections import Counter
from contextlib import ExitStack
from xml.etree import ElementTree

from .base.cmake_build import BUILD, CORES, ROOT, build_lock, build_or_fail, configure, run_logged
from .base.errors import CourseError
from .base.progress import Progress

TEST = re.compile(r"^TEST(?:_[FP])?\((\w+), (\w+)\)", re.MULTILINE)


def test(names: list, quick: bool, nightly: bool, extra: list) -> int:
    """Runs the tests whose names match one of `names` (default: all but the nightly ones), with `extra` words for CTest.

    Prints what failed, each with the command that repeats it, CTest's closing lines, and in a line what was skipped and why.
    Returns 0 if all passed, else 1.
    """
    refuse(names)
    build_or_fail(targets_of(names))
    results = BUILD / "ctest.xml"
    results.unlink(missing_ok=True)
    command = ["ctest", "--test-dir", str(BUILD), "-j", str(CORES), "--output-on-failure", "--no-tests=error",
               "--output-junit", str(results), "--test-output-size-passed", "100000"]
    if names:
        command += ["-R", "|".join(names)]
    if nightly:
        command += ["-L", "nightly"]
    elif quick or not names:
        command += ["-LE", "slow|nightly" if quick else "nightly"]
    failed = []
    with Progress("test") as progress, ExitStack() as reading:
        reading.enter_context(build_lock())  # until CTest has read its files, which another ./course may configure anew

        def step(line: str) -> None:
            if re.match(r"\s*Start ", line):
                reading.close()
            if "***" in line:
                failed.append(line)
            if re.match(r"\d+/\d+ ", line):
                progress.step(line + (f"   {len(failed)} failed" if failed else ""))
        done = run_logged(command + extra, "ctest.log", step)
    for line in worth_reading(done.stdout.splitlines()):
        print(line)
    if results.exists():
        print(skipped(results.read_text(encoding="utf-8", errors="replace")), end="")
    if done.returncode:
        print(f"The whole log: {BUILD / 'ctest.log'}", file=sys.stderr)
    return 1 if done.returncode else 0


def targets_of(names: list) -> list:
    """The executables of the C++ tests of which the names say how they begin, such as ^Loss. [], which means all, where they
    leave that open, since a value of a parameter may match too, or mean another kind of test: one in Python may start any program."""
    if not names or not all(name.startswith("^") and "|" not in name for name in names):
        return []
    configure()
    known = subprocess.run(["ctest", "--test-dir", str(BUILD), "-N", "-R", "|".join(names)], capture_output=True, text=True, check=False)
    executables = {f"{suite}.{name}": target for file in (ROOT / "tests").rglob("CMakeLists.txt")
                   for target, sources in re.findall(r"ch5_add_test\((\w+) ([^)]*)\)", file.read_text(encoding="utf-8"))
                   for source in re.findall(r"[\w/.]+\.cc", sources)
                   for suite, name in TEST.findall((file.parent / source).read_text(encoding="utf-8"))}
    if {re.sub("[/<].*", "", name) for name in re.findall(r"Test +#\d+: (.+)", known.stdout)} - executables.keys():
        return []
    try:
        return sorted({target for name, target in executables.items() if any(re.match(begin, name) for begin in names)})
    except re.error:
        return []


def worth_reading(lines: list) -> list:
    """What is worth reading of CTest's words."""
    kept = []
    for line in lines:
        if re.match(r"Internal ctest|Test project|\s*Start +\d+:|.* Passed +[\d.]+ sec$|.*\*\*\*Skipped|The following tests did not run|.*\(Skipped\)",
                    line):
            continue
        if failed := re.match(r"\s*\d+/\d+ Test +#\d+: (\S+) .*\*\*\*", line):
            pattern = re.sub(r"([][+*?()|^$\\])", r"\\\1", failed[1])
            kept.append(f"✗ {failed[1]} failed; once more: ./course test {shlex.quote(f'^{pattern}$')}")
        kept.append(line)
    return kept


def skipped(junit: str) -> str:
    """A line with the number of skipped tests and the reasons, the most frequent first; "" if there are none."""
    cases = ElementTree.fromstring(junit).findall("testcase")
    reasons = Counter(reason for case in cases
                      for reason in reasons_in(case.findtext("system-out", ""), case.find("skipped") is not None))
    told = "; ".join(f"{count} {reason}" for reason, count in reasons.most_common())
    return f"Skipped: {reasons.total()} of {len(cases)} tests: {told}\n" if reasons else ""


def reasons_in(output: str, is_skipped: bool) -> list:
    """Why what a test of CTest's consists of was skipped: as GoogleTest, Python's unittest or, in its last line, a program
    says it."""
    said = re.findall(r": Skipped\n(.+)", output) or [why for _, why in re.findall(r" skipped (['\"])(.+)\1$", output, re.MULTILINE)]
    last = ([line for line in output.splitlines() if line.strip()] or ["(without a reason)"])[-1]
    return said or [last.removeprefix("course: ")] * is_skipped


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
