"""./course check and ./course status: compiles the student's files, judges stage by stage, and says what to do next.

A stage is judged in a process of its own, so that a crash or an endless loop in one does not hide the others. What
counts is gtest's report, complete and without failures; an exit code alone proves nothing.
"""

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from . import jsonout
from .build import BIN, HOMEWORK, ROOT, build
from .errors import CourseError

TABLE = ROOT / "ch5_homework" / "stages.json"
TIME_LIMIT = 20.0  # seconds for one stage; the reference needs less than one
SHOWN_LINES = 15   # of a story, of the compiler's words, of what the student's file prints

COLOURS = {"right": "32", "wrong": "31", "crashes": "31", "times-out": "31", "does-not-compile": "31",
           "not-started": "33"}
MARKS = {"right": "✓", "not-started": "·"}

# Eigen's assertions in plain words; the first pattern that occurs in the assertion counts.
ASSERTIONS = [
    (r"startRow >= 0|i>=0", "a block(…) or segment(…) reaches outside its matrix"),
    (r"invalid matrix product|lhs\.cols\(\) == a?_?rhs\.rows\(\)", "the sizes of a matrix product do not fit"),
    (r"aLhs\.rows\(\) == aRhs\.rows\(\)", "the two terms of a sum or difference have different sizes"),
    (r"rows\(\) == \w+\.rows\(\)|resize", "the two sides of = or += have different sizes"),
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


# ---- The two commands -----------------------------------------------------------------------------------------------

def run_check(asked: list, as_json: bool) -> int:
    """Judges the stages asked for, all by default; 0 if every one is right, 1 if not. Raises CourseError(2)."""
    stages = select(asked)
    verdicts = judge_stages(stages)
    report(stages, verdicts, as_json, tell)
    return 0 if all(verdict.state == "right" for verdict in verdicts) else 1


def run_status(as_json: bool) -> int:
    """Judges every stage and shows a line for each; 0."""
    stages = select([])
    report(stages, judge_stages(stages), as_json, tell_line)
    return 0


def stage_table() -> list:
    return json.loads(TABLE.read_text(encoding="utf-8"))["stages"]


def select(asked: list) -> list:
    """The rows of the table that are asked for; "1" means 1.1 and 1.2."""
    table = stage_table()
    for name in asked:
        if not any(covers(name, stage) for stage in table):
            raise CourseError(f"unknown stage '{name}'; there are {', '.join(stage['id'] for stage in table)}")
    return [stage for stage in table if not asked or any(covers(name, stage) for name in asked)]


def covers(name: str, stage: dict) -> bool:
    return stage["id"] == name or stage["id"].startswith(name + ".")


def judge_stages(stages: list) -> list:
    """The verdicts, in the order of the stages."""
    broken = compile_files(sorted({stage["file"] for stage in stages}))
    return [broken.get(stage["file"]) or judge(BIN / target(stage["file"]), stage) for stage in stages]


def report(stages: list, verdicts: list, as_json: bool, tell_one) -> None:
    """One JSON object on standard output, the words then on standard error; or the words on standard output."""
    out = sys.stderr if as_json else sys.stdout
    for stage, verdict in zip(stages, verdicts):
        tell_one(stage, verdict, out)
    if as_json:
        jsonout.emit({"stages": [{"id": stage["id"], "state": verdict.state, "hint": verdict.hint}
                                 for stage, verdict in zip(stages, verdicts)]})


# ---- Compiling ------------------------------------------------------------------------------------------------------

def target(file: str) -> str:
    """The executable that judges this file. The end-to-end test has a set of its own, told apart by a prefix."""
    return os.environ.get("CH5_CHECK_PREFIX", "") + "check_" + Path(file).stem


def compile_files(files: list) -> dict:
    """Builds what judges these files; returns a verdict for each file that cannot be compiled."""
    done = build(["-k", "0", *map(target, files)])
    if done.returncode == 0:
        return {}
    if len(files) == 1:
        return {files[0]: does_not_compile(files[0], done.stdout)}
    return {file: verdict for each in files for file, verdict in compile_files([each]).items()}


def does_not_compile(file: str, output: str) -> Verdict:
    lines = [line for line in output.splitlines() if not line.startswith("ninja: build stopped")]
    patterns = [rf"{re.escape(file)}:\d+:(\d+:)? (fatal )?error: ", "multiple definition|undefined reference", "error: ",
                "FAILED|ninja: "]
    first = next((i for pattern in patterns for i, line in enumerate(lines) if re.search(pattern, line)), 0)
    hint = shorten(lines[first]) if lines else "the compiler said nothing"
    if "multiple definition of `main'" in hint:
        hint = f"{file} has a main of its own; remove it, the check brings one."
    elif "missing and no known rule" in hint or f"{file}: No such file" in hint:
        hint = f"{file} is missing; tests/homework/make_skeleton.py {file} writes it anew."
    story = "\n".join(shorten(line) for line in lines[first:first + SHOWN_LINES])
    return Verdict("does-not-compile", hint, story)


def shorten(line: str) -> str:
    """Without the project's folder, in which everything lies."""
    return line.replace(str(ROOT) + os.sep, "").strip("\n")


# ---- Judging --------------------------------------------------------------------------------------------------------

def judge(executable: Path, stage: dict, time_limit: float = TIME_LIMIT, options=()) -> Verdict:
    """Runs one stage's tests, up to the first that fails."""
    with tempfile.TemporaryDirectory() as folder:
        report_path, printed_path = Path(folder) / "report.json", Path(folder) / "printed"
        command = [str(executable), "--quiet", "--gtest_fail_fast", f"--gtest_filter={stage['tests']}",
                   f"--gtest_output=json:{report_path}", *options]
        with open(printed_path, "wb") as printed:
            process = subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=printed,
                                       stderr=subprocess.STDOUT, start_new_session=True)
            in_time = wait(process, time_limit)
        with open(printed_path, encoding="utf-8", errors="replace") as printed:
            words = printed.read(1 << 20)
        try:
            tests = json.loads(report_path.read_text(encoding="utf-8"))["testsuites"]
        except (OSError, ValueError, KeyError):
            tests = []
    if not in_time or not tests:
        return ended_early(executable, stage, words, in_time, process.returncode, time_limit)
    return read_report([test for suite in tests for test in suite["testsuite"]], process.returncode, words)


def wait(process: subprocess.Popen, time_limit: float) -> bool:
    """Whether the process has ended in time. If not, it is asked where it is, then killed with all its children."""
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
            return Verdict("wrong", cause(text), "\n".join(text.splitlines()[:SHOWN_LINES]), words)
    if exit_code or not tests or any(test.get("result") != "COMPLETED" for test in tests):
        return Verdict("crashes", f"The tests were not all run (exit code {exit_code}).", "", words)
    return Verdict("right", "", "", words)


def in_plain_words(message: str, table: list) -> str:
    return next((text for pattern, text in table if re.search(pattern, message)), message)


def mend_utf8(text: str) -> str:
    """GoogleTest up to 1.12 writes each byte of a UTF-8 letter as a letter of its own."""
    try:
        return text.encode("latin-1").decode("utf-8")
    except UnicodeError:
        return text


def cause(story: str) -> str:
    """What a story says of the cause, and what it is about."""
    first = story.partition("\n")[0]
    found = re.search(r"^  cause +(.*)$", story, re.MULTILINE)
    return f"{first}: {found[1]}." if found else first


def ended_early(executable: Path, stage: dict, words: str, in_time: bool, exit_code: int, time_limit: float) -> Verdict:
    """The verdict of a process that has left no report: where it ended, and why."""
    student, crash, trace = words.partition("\nCRASH ")
    name, _, test = trace.partition("\n")[0].partition(" in ")
    place = locate(executable, stage["file"], trace)
    where = f"{' at ' + place if place else ''}{', in the test ' + test if test else ''}"
    if not in_time:
        return Verdict("times-out", f"Still running after {time_limit:g} s{where}: a loop does not end.", "", student)
    assertion = re.search(r"Assertion [`'](.*)' failed", student, re.DOTALL)
    if assertion:
        plain = in_plain_words(assertion[1], ASSERTIONS)
        student = student[:student.rfind("\n", 0, assertion.start()) + 1]
        return Verdict("crashes", f"An assertion stopped the program: {plain}{where}.", "", student)
    what = f"Crash ({name})" if crash else f"The program ended by itself (exit code {exit_code})"
    return Verdict("crashes", f"{what}{where}, before the tests were through.", "", student)


def locate(executable: Path, file: str, trace: str) -> str:
    """The first line of the student's file in a trace of return addresses: "problem.cc:71", or "" if unknown."""
    offsets = re.findall(rf"{re.escape(executable.name)}\(\+0x([0-9a-f]+)\)", trace)
    addresses = [hex(int(offset, 16) - 1) for offset in offsets]  # of the calls, not of where they return to
    try:
        answer = subprocess.run(["addr2line", "-i", "-e", str(executable), *addresses], text=True, timeout=20,
                                capture_output=True, check=False).stdout if addresses else ""
    except (OSError, subprocess.TimeoutExpired):
        return ""
    found = re.search(rf"/({re.escape(file)}:\d+)", answer)
    return found[1] if found else ""


# ---- Telling --------------------------------------------------------------------------------------------------------

def paint(text: str, state: str, out) -> str:
    if not out.isatty() or os.environ.get("NO_COLOR"):
        return text
    return f"\033[1;{COLOURS[state]}m{text}\033[0m"


def tell_line(stage: dict, verdict: Verdict, out) -> None:
    """One line of ./course status, and one for the hint."""
    state = paint(f"{MARKS.get(verdict.state, '✗')} {verdict.state:<16}", verdict.state, out)
    print(f"{stage['id']:<4} {state}  {stage['title']}  ({stage['file']})", file=out)
    if verdict.hint:
        print(f"       {verdict.hint}", file=out)


def tell(stage: dict, verdict: Verdict, out) -> None:
    """The verdict of ./course check, its story, and what to do next."""
    head = f"{MARKS.get(verdict.state, '✗')} {stage['id']} {verdict.state}"
    print(f"{paint(head, verdict.state, out)}   {stage['title']}", file=out)
    printed = verdict.printed.strip("\n").splitlines()
    if printed:
        print("\n  Your code printed" + (f" (the last {SHOWN_LINES} lines)" if len(printed) > SHOWN_LINES else "") + ":",
              file=out)
        print("\n".join("  │ " + line for line in printed[-SHOWN_LINES:]), file=out)
    print("\n" + indent(verdict.story or verdict.hint) + "\n" if verdict.state != "right" else "", file=out, end="")
    print(f"  {next_step(stage, verdict)}\n", file=out)


def keeps_throw(path: Path, todo: str) -> bool:
    """Whether code stands in this gap, and below it still the throw that says it is empty."""
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return False
    name = re.escape(todo)
    gap = re.search(rf'TODO:: home work {name}\.(.*?)throw HomeworkMissing\("{name} ', text, re.DOTALL)
    return bool(gap) and any(line.strip() and not line.strip().startswith("//") for line in gap[1].splitlines()[1:])


def indent(text: str) -> str:
    return "\n".join("  " + line for line in text.splitlines())


def next_step(stage: dict, verdict: Verdict) -> str:
    again, file = f"./course check {stage['id']}", stage["file"]
    if verdict.state == "right":
        ids = [row["id"] for row in stage_table()]
        following = ids[ids.index(stage["id"]) + 1:]
        return "Well done. " + (f"Next: ./course check {following[0]}" if following else "That was the last stage.")
    todo = verdict.hint.split()[1] if verdict.state == "not-started" else ""  # "TODO 1.1a …"
    if todo and keeps_throw(HOMEWORK / file, todo):
        return f"Your lines for {todo} are there, but so is the throw below them: delete it. Then: {again}"
    return {
        "not-started": f"Search {file} for “home work {todo}”; the handout is ch5_homework/README.md, Stage "
                       f"{stage['id']}. Then: {again}",
        "does-not-compile": f"Mend the first error; the others may follow from it. Then: {again}",
        "wrong": f"Mend {file}. Then: {again}",
        "crashes": f"Look at your lines in {file}, at places and sizes first. Then: {again}",
        "times-out": f"Look for the loop in {file}. Then: {again}",
    }[verdict.state]
