"""Judges a stage in a process of its own, so that a crash or an endless loop in one does not hide the others.

What counts is gtest's report, complete and without failures; an exit code alone proves nothing.
"""

import json
import os
import re
import signal
import subprocess
import tempfile
from pathlib import Path
from typing import NamedTuple

from ..base.processes import running
from ..base.language import Speaker
from ..base.scratch import scratch

TIME_LIMIT = 20.0  # seconds for one stage; the reference needs less than one
SHOWN_LINES = 15   # of a story, of the compiler's words, of what the student's file prints

# Eigen's assertions in plain words; the first pattern that occurs in the assertion counts.
ASSERTIONS = [
    (r"startRow >= 0|i>=0", "a block(…) or segment(…) reaches outside its matrix"),
    (r"invalid matrix product|lhs\.cols\(\) == a?_?rhs\.rows\(\)", "the sizes of a matrix product do not fit"),
    (r"aLhs\.rows\(\) == aRhs\.rows\(\)", "the two terms of a sum or difference have different sizes"),
    (r"rows\(\) == \w+\.rows\(\)|resize", "the two sides of = or += have different sizes"),
    (r"SolverBase::solve", "the sizes in a solve(…) do not fit"),
    (r"A·D|D·A", "the sizes of a product with Hmm_inv do not fit"),
    (r"__n < this->size\(\)", "an index lies outside its std::vector"),
    (r"get\(\) != (nullptr|pointer\(\))", "a null pointer was used"),
    (r"index >= 0|row >= 0", "an index lies outside its matrix"),
]

# The standard library's exceptions, likewise.
EXCEPTIONS = [
    (r"std::bad_alloc|length_error|vector::_M_\w*append|_M_realloc_insert",
     "it asks for more memory than 2 GB; a size is wrong, or a loop does not end"),
    (r"map::at", "an id is not in the map that was asked for it"),
    (r"vector::_M_range_check", "an index lies outside its std::vector"),
]


class Verdict(NamedTuple):
    state: str
    hint: str          # one or two sentences
    story: str = ""    # the whole of it, for a human
    printed: str = ""  # what the student's own code has printed
    tests: tuple = ()  # what GoogleTest reports of each test that was run


def judge(executable: Path, stage: dict, time_limit: float = TIME_LIMIT, options=(), worker=(),
          program: Path = None, fail_fast: bool = True, words_of=None) -> Verdict:
    """Runs one stage's tests, up to the first that fails or all; the verdict is that of the first failure.

    `worker` is the command for homework_judge to start, and `program` the student's program among its words.
    `words_of(command)` runs a tool that reads this program, which nobody trusts, and returns what it prints.
    """
    words_of = words_of or output_of
    with tempfile.TemporaryDirectory(dir=scratch()) as folder:
        report_path, printed_path = Path(folder) / "report.json", Path(folder) / "printed"
        command = [str(executable), "--quiet", f"--gtest_filter={stage['tests']}",
                   f"--gtest_output=json:{report_path}", *(["--gtest_fail_fast"] if fail_fast else []), *options,
                   *(["--", *worker] if worker else [])]
        with open(printed_path, "wb") as printed:
            with running(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=printed,
                         stderr=subprocess.STDOUT) as process:
                in_time = wait(process, time_limit)
        with open(printed_path, encoding="utf-8", errors="replace") as printed:
            words = printed.read(1 << 20)
        try:
            tests = json.loads(report_path.read_text(encoding="utf-8"))["testsuites"]
        except (OSError, ValueError, KeyError):
            tests = []
    if not in_time or not tests:
        return ended_early(executable, stage, words, in_time, process.returncode, time_limit, words_of)
    tests = [test for suite in tests for test in suite["testsuite"]]
    failure = worker_failure(tests) if worker else None
    if failure:
        of_a_test = [float(option.partition("=")[2]) for option in options if option.startswith("--time-limit=")]
        verdict = ended_early(program or Path(worker[0]), stage, words, failure[0] != "TIMEOUT", failure[1],
                              *(of_a_test or [time_limit]), words_of)
    else:
        verdict = read_report(tests, process.returncode, words)
    return verdict._replace(tests=tuple(tests))


def wait(process: subprocess.Popen, time_limit: float) -> bool:
    """Whether the process has ended in time. If not, it is asked to end, then killed with all its children."""
    try:
        process.wait(time_limit)
        return True
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGTERM)
        try:
            process.wait(1.0)
        except subprocess.TimeoutExpired:
            pass
        return False
    finally:
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        process.wait()


def read_report(tests: list, exit_code: int, words: str) -> Verdict:
    """The verdict of a complete report: that of the first failure, if there is one."""
    for test in tests:
        for failure in test.get("failures", []):
            text = mend_utf8(failure["failure"])
            text = (text.partition("\n")[2] or text).removeprefix("Failed\n").strip()
            missing = re.search(r'"(TODO .+ is not started)"', text)
            thrown = re.search(r'C\+\+ exception with description "(.*)" thrown', text, re.DOTALL)
            if missing:
                return Verdict("not-started", missing[1] + ".", "", words)
            if thrown:
                plain = in_plain_words(thrown[1], EXCEPTIONS)
                return Verdict("crashes", f"An exception ended the test {test['name']}: {plain}.", "", words)
            told = re.search(r"^Stage \S+: .*", text, re.MULTILINE | re.DOTALL)  # behind the expression of an ASSERT_TRUE
            text = told[0] if told else text
            return Verdict("wrong", cause(text), "\n".join(text.splitlines()[:SHOWN_LINES]), words)
    if exit_code or not tests or any(test.get("result") != "COMPLETED" for test in tests):
        return Verdict("crashes", f"The tests were not all run (exit code {exit_code}).", "", words)
    return Verdict("right", "", "", words)


def worker_failure(tests: list):
    """How the worker has failed to answer: ("EXIT", 0), ("CRASH", minus the signal), or None. See WorkerFailure in
    ch5_homework/judge/remote/process.h."""
    for failure in (failure for test in tests for failure in test.get("failures", [])):
        found = re.search(r'with description "(?:START: )?(CRASH|EXIT|TIMEOUT|GARBAGE)\b ?(\d*)(.*)', mend_utf8(failure["failure"]))
        name = found[3].partition(" in ")[0] if found else ""
        by = [-number for number in signal.valid_signals() if name == signal.strsignal(number)]
        return (found[1], by[0] if by else int(found[2] or 0)) if found else None
    return None


def in_plain_words(message: str, table: list) -> str:
    return next((text for pattern, text in table if re.search(pattern, message)), message)


def mend_utf8(text: str) -> str:
    """GoogleTest up to 1.12 writes each byte of a UTF-8 letter as a letter of its own."""
    try:
        return text.encode("latin-1").decode("utf-8")
    except UnicodeError:
        return text


def in_full(hint: str, story: str, say: Speaker) -> str:
    """All that a verdict says, in a language; above a compiler's own words stands what they mean."""
    told, sentence = say.story(story), say.hint(hint, story)
    return told if story.startswith("Stage ") or sentence and told.startswith(sentence) else f"{sentence}\n\n{told}".strip()


def cause(story: str) -> str:
    """What a story says of the cause, and what it is about."""
    first = story.partition("\n")[0]
    found = re.search(r"^  cause +(.*)$", story, re.MULTILINE)
    return f"{first}: {found[1]}." if found else first


def ended_early(executable: Path, stage: dict, words: str, in_time: bool, exit_code: int, time_limit: float,
                words_of) -> Verdict:
    """The verdict of a process that has left no report: where it ended, and why."""
    student, crash, trace = words.partition("\nCRASH ")
    name, _, test = trace.partition("\n")[0].partition(" in ")
    place = locate(executable, stage["file"], trace, words_of)
    where = f"{' at ' + place if place else ''}{', in the test ' + test if test else ''}"
    if not in_time:
        return Verdict("times-out", f"Still running after {time_limit:g} s{where}: a loop does not end.", "", student)
    assertion = re.search(r"Assertion [`'](.*)' failed", student, re.DOTALL)
    if assertion:
        plain = in_plain_words(assertion[1], ASSERTIONS)
        student = student[:student.rfind("\n", 0, assertion.start()) + 1]
        return Verdict("crashes", f"An assertion stopped the program: {plain}{where}.", "", student)
    if name == "Stack overflow":
        return Verdict("crashes", f"The stack is full{where}: a function calls itself without end, or a local array is too "
                       "large.", "", student)
    if crash or exit_code < 0:
        what = f"Crash ({name or signal.strsignal(-exit_code)})"
    else:
        what = f"The program ended by itself (exit code {exit_code})"
    return Verdict("crashes", f"{what}{where}, before the tests were through.", "", student)


def locate(executable: Path, file: str, trace: str, words_of) -> str:
    """The first line of the student's file in a trace of return addresses: "problem.cc:71", or "" if unknown."""
    offsets = re.findall(rf"{re.escape(executable.name)}\(\+0x([0-9a-f]+)\)", trace)
    addresses = [hex(int(offset, 16) - 1) for offset in offsets]  # of the calls, not of where they return to
    answer = words_of(["addr2line", "-i", "-e", str(executable), *addresses[:100]]) if addresses else ""
    found = re.search(rf"/({re.escape(file)}:\d+)", answer)
    return found[1] if found else ""


def output_of(command: list) -> str:
    try:
        return subprocess.run(command, text=True, timeout=20, capture_output=True, check=False).stdout
    except (OSError, subprocess.TimeoutExpired):
        return ""
