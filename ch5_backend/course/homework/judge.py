"""Judges a stage in a process of its own, so that a crash or an endless loop in one does not hide the others.

What counts is gtest's report, complete and without failures; an exit code alone proves nothing.
"""

import json
import os
import re
import signal
import subprocess
import tempfile
import threading
import time
from collections import deque
from contextlib import suppress
from pathlib import Path

from ..base.language import sentence
from ..base.processes import running
from ..base.scratch import scratch
from . import answers
from .diagnosis import ONE_OF_MANY, SHOWN_LINES, Verdict, because, cause_of

MOST_WORDS = 2000  # of an exception
MOST_KEPT = 1 << 20  # bytes of the beginning of what a test prints
MOST_LINES = 200     # of its end
FLOOD = 10 << 20     # bytes that are enough to explain why a test takes long
NOT_STARTED = re.compile(r'"TODO (\S+) ?(.*) is not started"')  # what an empty blank throws
TEST_BEGINS, THROWN = b"\x1eTEST ", b"\x1eTHROWN "  # as main.cc writes them
TIME_LIMIT = 20.0  # seconds for one stage; the reference needs less than one

SIZES = re.compile(r"\nSIZES ((?:-?\d{1,18} ){13}-?\d{1,18})\n")  # what an assertion of Eigen's knows of sizes (told_sizes.h)

# What Eigen's assertions mean; the first pattern that occurs in the assertion counts.
ASSERTIONS = [
    (r"comma initializer", "eigen.comma"),
    (r"given_back_once", "judge.given_back_twice"),  # unset_memory.cc
    (r"startRow >= 0|i>=0", "eigen.block_outside"),
    (r"invalid matrix product|lhs\.cols\(\) == a?_?rhs\.rows\(\)", "eigen.product_sizes"),
    (r"other\.rows\(\) == 1 \|\| other\.cols\(\) == 1", "eigen.matrix_into_vector"),
    (r"aLhs\.rows\(\) == aRhs\.rows\(\)", "eigen.sum_sizes"),
    (r"rows\(\) == \w+\.rows\(\)|resize", "eigen.assignment_sizes"),
    (r"SolverBase::solve", "eigen.solve_sizes"),
    (r"empty matrix", "eigen.empty_matrix"),
    (r"aliasing detected", "eigen.transposed_in_place"),
    (r"A·D|D·A", "eigen.Hmm_inv_sizes"),
    (r"__n < this->size\(\)|i < size_", "judge.index_outside_vector"),
    (r"get\(\) != (nullptr|pointer\(\))", "judge.null_pointer"),
    (r"index >= 0|row >= 0", "eigen.index_outside"),
]

# The standard library's exceptions, likewise.
EXCEPTIONS = [
    (r"std::bad_alloc|length_error|vector::_M_\w*append|_M_realloc_insert", "judge.out_of_memory"),
    (r"map::at", "judge.not_in_map"),
    (r"not finite: \(\d+, \d+\) = -?nan|-\d\.\d+e\+30[0-9]", "judge.unset_numbers"),  # unset_memory.h
    (r"vector::_M_range_check|an edge has no vertex", "judge.index_outside_vector"),
]

# What a crash means, by the names of crash.h.
CRASHES = {"Stack overflow": "judge.stack_full", "Null pointer": "judge.null_followed",
           "Segmentation fault": "judge.outside_memory"}


def judge(executable: Path, stage: dict, time_limit: float = TIME_LIMIT, options=(), worker=(),
          program: Path = None, fail_fast: bool = True, words_of=None) -> Verdict:
    """The verdict on one stage, as run_tests gives it; what is wrong under the name of its mistake, if it has one.

    Answers are known for the usual random numbers: with a seed the stage is run once more, with these, to find the name.
    """
    run = lambda options, fail_fast: run_tests(executable, stage, time_limit, options, worker, program, fail_fast, words_of)
    verdict = run(options, fail_fast)
    if verdict.state != "wrong":
        return verdict
    usual_options = [option for option in options if not option.startswith("--seed=")]
    usual = verdict if usual_options == list(options) else run(usual_options, True)
    if failed_in(usual.tests) == failed_in(verdict.tests):
        verdict = verdict._replace(diagnosis=answers.named(verdict.diagnosis, usual.diagnosis))
    return with_a_cause_of_all_calls(verdict, lambda asked: run([*options, asked], False).tests)


def with_a_cause_of_all_calls(verdict: Verdict, tests_of) -> Verdict:
    """A slip in a formula is found in the first wrong answer. If it is one of many that were tried there, one may fit by
    coincidence: where another wrong answer refutes it, only what is seen is said. Of a mistake with a name of its own this is
    not asked.

    `tests_of(option)` runs the tests once more, now asking of each answer whether the slip explains it.
    """
    known = dict(verdict.diagnosis)
    formula, symptom = known.pop("formula", ""), known.pop("symptom", "")
    asked = f"--explains={formula}={answers.as_text(known.get('cause'))}"
    if formula and cause_of(known) in ONE_OF_MANY and "judged" not in known and any("refuted" in test for test in tests_of(asked)):
        known["cause"] = symptom
    return verdict._replace(diagnosis=known)


def every_test(executable: Path, stage: dict, options=()) -> tuple:
    """What GoogleTest reports of all tests of a stage, also of those after the first that fails. If one ends the program, each is
    run alone, and that one has failed; () if one does not end."""
    def run(tests: str) -> Verdict:
        return run_tests(executable, {**stage, "tests": tests}, TIME_LIMIT, options, (), None, False, None)

    def alone(check: str) -> dict:
        verdict = run(stage["tests"].replace("*", check))
        return verdict.tests[0] if verdict.tests else {"name": check, "failures": [{"failure": verdict.state}]}
    verdict = run(stage["tests"])
    return verdict.tests if verdict.tests or verdict.state == "times-out" else tuple(map(alone, stage.get("checks", ())))


def failed_in(tests: tuple) -> str:
    """The name of the first test that has failed."""
    return next((test["name"] for test in tests if test.get("failures")), "")


def run_tests(executable: Path, stage: dict, time_limit: float, options, worker, program, fail_fast: bool, words_of) -> Verdict:
    """Runs one stage's tests, up to the first that fails or all; the verdict is that of the first failure.

    `worker` is the command for homework_judge to start, and `program` the student's program among its words.
    `words_of(command)` runs a tool that reads this program, which nobody trusts, and returns what it prints.
    """
    words_of = words_of or output_of
    with tempfile.TemporaryDirectory(dir=scratch()) as folder:
        report_path = Path(folder) / "report.json"
        command = [str(executable), "--quiet", f"--gtest_filter={stage['tests']}",
                   f"--gtest_output=json:{report_path}", *(["--gtest_fail_fast"] if fail_fast else []), *options,
                   *(["--", *worker] if worker else [])]
        with running(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                     stderr=subprocess.STDOUT) as process:
            printed = Printed(process.stdout)
            in_time = wait(process, time_limit)
        printed.join(1.0)  # longer, and a child that has left the group holds the pipe
        if not printed.is_alive():
            process.stdout.close()
        try:
            tests = json.loads(report_path.read_text(encoding="utf-8"), object_hook=mended)["testsuites"]
        except (OSError, ValueError, KeyError):
            tests = []
    if not in_time or not tests:
        return ended_early(executable, stage, printed, in_time, process.returncode, time_limit, words_of)
    tests = [test for suite in tests for test in suite["testsuite"]]
    failure = worker_failure(tests) if worker else None
    if failure:
        of_a_test = [float(option.partition("=")[2]) for option in options if option.startswith("--time-limit=")]
        verdict = ended_early(program or Path(worker[0]), stage, printed, failure[0] != "TIMEOUT", failure[1],
                              *(of_a_test or [time_limit]), words_of)
    else:
        verdict = read_report(tests, process.returncode, printed)
        if verdict.state == "crashes" and (place := locate(executable, stage["file"], printed.thrown_in(failed_in(tests)), words_of)):
            cause = {**verdict.diagnosis["cause"], "where": sentence("judge.at_place", place=place)}
            verdict = verdict._replace(diagnosis={**verdict.diagnosis, "cause": cause, "place": place})
    return verdict._replace(tests=tuple(tests))


class Printed(threading.Thread):
    """Reads what a process prints, test by test: its size, its beginning, and its last lines. A test begins at a line
    TEST_BEGINS NAME (main.cc), and an exception ends it with its calls, THROWN CALLS; the judge of a worker writes neither."""

    def __init__(self, stream):
        super().__init__(daemon=True)
        self.stream, self.tests = stream, [("", Part())]
        self.start()

    def run(self) -> None:
        for line in iter(lambda: self.stream.readline(MOST_KEPT), b""):
            before, begins, name = line.partition(TEST_BEGINS)
            before, _, calls = before.partition(THROWN)
            part = self.tests[-1][1]
            part.add(before)
            part.thrown = part.thrown or calls.decode("utf-8", "replace")
            if begins:
                self.tests.append((name.decode("utf-8", "replace").strip(), Part()))

    def of(self, test: str = "") -> "Part":
        """What was printed in this test; without a name, in the last one in which something was."""
        known = {name for name, _ in self.tests[1:]}
        parts = [part for name, part in self.tests if part.size and (name == test or test not in known)]
        return parts[-1] if parts else Part()

    def thrown_in(self, test: str) -> str:
        return next((part.thrown for name, part in self.tests if name == test), "")


class Part:
    """What was printed in a test."""

    def __init__(self):
        self.size, self.head, self.tail = 0, bytearray(), deque(maxlen=MOST_LINES)
        self.thrown = ""  # the calls that led to an exception

    def add(self, line: bytes) -> None:
        self.size += len(line)
        if len(self.head) < MOST_KEPT:
            self.head += line
        else:
            self.tail.append(line)

    def text(self) -> str:
        return (bytes(self.head) + b"".join(self.tail)).decode("utf-8", "replace")


def in_bytes(size: int) -> str:
    """"512 B", "4.6 KB", "342 MB"."""
    power = min(3, max(0, len(str(size)) - 1) // 3)
    return f"{size / 1000 ** power:.3g} {('B', 'KB', 'MB', 'GB')[power]}"


def wait(process: subprocess.Popen, time_limit: float) -> bool:
    """Whether the process has ended in time. If not, it is asked to end, then killed with all its children. What it waits for a
    core of a busy machine is not its time."""
    begin = time.monotonic()
    try:
        while (left := time_limit + queued(process.pid) - (time.monotonic() - begin)) > 0:
            with suppress(subprocess.TimeoutExpired):
                process.wait(left)
                return True
        os.killpg(process.pid, signal.SIGTERM)
        with suppress(subprocess.TimeoutExpired):
            process.wait(1.0)
        return False
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def queued(pid: int) -> float:
    """Seconds in which a process could have run and had no core; 0 where the kernel does not count them."""
    with suppress(OSError, IndexError):
        return int(Path(f"/proc/{pid}/schedstat").read_text(encoding="ascii").split()[1]) / 1e9
    return 0.0


def read_report(tests: list, exit_code: int, printed: Printed) -> Verdict:
    """The verdict of a complete report: that of the first failure, if there is one."""
    failed = next((test for test in tests if test.get("failures")), None)
    part = printed.of(failed["name"] if failed else "")
    if failed:
        verdict = read_failure(failed)
    elif exit_code or not tests or any(test.get("result") != "COMPLETED" for test in tests):
        verdict = Verdict("crashes", because("judge.not_all_run", n=exit_code))
    else:
        verdict = Verdict("right")
    return verdict._replace(printed=part.text(), printed_bytes=part.size)


def read_failure(test: dict) -> Verdict:
    """The verdict on a test that has failed: what it says itself, or what was thrown."""
    if "diagnosis" in test:
        return Verdict("wrong", json.loads(test["diagnosis"]))
    text = test["failures"][0]["failure"]
    if missing := NOT_STARTED.search(text):
        return Verdict("not-started", not_started(missing[1], missing[2]))
    if thrown := re.search(r'C\+\+ exception with description "(.*)" thrown', text, re.DOTALL):
        reason = in_plain_words(thrown[1], EXCEPTIONS)
        return Verdict("crashes", because("judge.exception", test=test["name"], reason=reason, where=""))
    if "Unknown C++ exception" in text:
        return Verdict("crashes", because("judge.unknown_exception", test=test["name"], where=""))
    text = (text.partition("\n")[2] or text).strip()  # without the line of the test
    return Verdict("wrong", because("judge.test_failed", test=test["name"]), "\n".join(text.splitlines()[:SHOWN_LINES]))


def not_started(todo: str, place: str) -> dict:
    return {**because("judge.not_started", todo=todo, place={"quoted": place}), "todo": todo}


def worker_failure(tests: list):
    """How the worker has failed to answer: ("EXIT", 0), ("CRASH", minus the signal), or None. See WorkerFailure in
    ch5_homework/judge/remote/process.h."""
    for failure in (failure for test in tests for failure in test.get("failures", [])):
        found = re.search(r'with description "(?:START: )?(CRASH|EXIT|TIMEOUT|GARBAGE)\b ?(\d*)(.*)', failure["failure"])
        name = found[3].partition(" in ")[0] if found else ""
        by = [-number for number in signal.valid_signals() if name == signal.strsignal(number)]
        return (found[1], by[0] if by else int(found[2] or 0)) if found else None
    return None


def in_plain_words(message: str, table: list):
    """What a message means, as data."""
    return next((sentence(name) for pattern, name in table if re.search(pattern, message)), {"quoted": message[:MOST_WORDS]})


def in_numbers(told: list) -> dict:
    """Of SIZES: "block(6, 6, 12, 12) of 12×12", or "12×12 and 6×6" of a sum or an assignment; {} without numbers."""
    row, column, rows, columns = told[:4]
    size = [f"{told[k]}×{told[k + 1]}" if told[k] >= 0 else "" for k in range(4, 14, 2)]
    if size[0] and min(row, rows) >= 0 and told[5] == columns == 1:
        return sentence("eigen.segment_of", row=row, rows=rows, n=told[4])
    if size[0] and min(rows, columns) >= 0:
        return sentence("eigen.block_of", row=row, column=column, rows=rows, columns=columns, size=size[0])
    this, that = size[1:3] if size[1] else size[3:5]
    return sentence("eigen.two_sizes", this=this, that=that) if this and that else {}


def mended(report: dict) -> dict:
    """GoogleTest up to 1.12 writes each byte of a UTF-8 letter as a letter of its own."""
    def mend(value):
        try:
            return value.encode("latin-1").decode("utf-8") if isinstance(value, str) else value
        except UnicodeError:
            return value
    return {name: mend(value) for name, value in report.items()}


def ended_early(executable: Path, stage: dict, printed: Printed, in_time: bool, exit_code: int, time_limit: float,
                words_of) -> Verdict:
    """The verdict of a process that has left no report: where it ended, and why."""
    part = printed.of()
    words = part.text()
    student, crash, trace = words.partition("\nCRASH ")
    name, _, test = trace.partition("\n")[0].partition(" in ")
    place = locate(executable, stage["file"], trace, words_of)
    name_of_where = "judge.at_place_in_test" if place and test else "judge.at_place" if place else "judge.in_test"
    where = sentence(name_of_where, place=place, test=test) if place or test else ""

    def verdict(state: str, cause: str, /, **arguments) -> Verdict:
        return Verdict(state, {**because(cause, where=where, **arguments), "place": place}, printed=student, printed_bytes=part.size)
    if not in_time and part.size > FLOOD:
        return verdict("times-out", "judge.prints_too_much", n=f"{time_limit:g}", size=in_bytes(part.size))
    if not in_time:
        return verdict("times-out", "judge.does_not_end", n=f"{time_limit:g}")
    assertion = re.search("Assertion [`']", student)
    if assertion and (end := student.rfind("' failed", assertion.end())) >= 0:
        student, assertion = student[:student.rfind("\n", 0, assertion.start()) + 1], student[assertion.end():end]
        reason, sizes = in_plain_words(assertion, ASSERTIONS), SIZES.search(student)
        if told := sizes and in_numbers([int(number) for number in sizes[1].split()]):
            reason = sentence("judge.with_sizes", reason=reason, sizes=told)
        student = SIZES.sub("", student)
        return verdict("crashes", "judge.assertion", reason=reason)
    if name or exit_code < 0:  # the words may be the program's own, without a name
        name = name or signal.strsignal(-exit_code)
        return verdict("crashes", CRASHES.get(name, "judge.crash"), signal={"quoted": name})
    return verdict("crashes", "judge.ended_by_itself", n=exit_code)


def locate(executable: Path, file: str, trace: str, words_of) -> str:
    """The first line of the student's file in a trace of return addresses: "problem.cc:71", or "" if unknown."""
    offsets = re.findall(rf"{re.escape(executable.name)}\(\+0x([0-9a-f]+)\)", trace)
    addresses = [hex(int(offset, 16) - 1) for offset in offsets]  # of the calls, not of where they return to
    answer = words_of(["addr2line", "-i", "-e", str(executable), *addresses[:100]]) if addresses else ""
    found = re.search(rf"/({re.escape(file)}:\d{{1,9}})\b", answer)
    return found[1] if found else ""


def output_of(command: list) -> str:
    try:
        return subprocess.run(command, text=True, timeout=20, capture_output=True, check=False).stdout
    except (OSError, subprocess.TimeoutExpired):
        return ""
