"""./course check and ./course status: compiles the student's files, judges stage by stage, and says what to do next."""

import json
import os
import re
import shlex
import shutil
import sys
import time
from pathlib import Path

from . import blanks, hint_policy
from ..base import jsonout
from ..base.cmake_build import BIN, BUILD, HOMEWORK, ROOT, build
from .block_map import block_map
from .compiler import does_not_compile, shown, warnings
from ..base.errors import CourseError
from .diagnosis import SHOWN_LINES, Verdict, cause_of, in_full, in_short
from .judge import every_test, in_bytes, judge, not_started
from .make_skeleton import holds_work
from .mended import blanks_of, mended
from .names import namesake, plain
from .predict import compared, predict
from .regions import NAME_CAUSE_AT_FAILURE, STAGES, covers, title_of, todos_of, worth
from .ticks import EMPTY, RIGHT, WAITS, WRONG, blamed_by, ticks
from ..base.language import Speaker, fitted, pad, sentence, speaker

COLORS = {"right": "32", "wrong": "31", "crashes": "31", "times-out": "31", "does-not-compile": "31",
           "not-started": "33"}
MARKS = {"right": "✓", "not-started": "·"}
TICK_NAMES = {RIGHT: "right", WRONG: "wrong", EMPTY: "empty", WAITS: "not judged"}  # as scripts read them
TICK_COLORS = {RIGHT: "right", WRONG: "wrong", EMPTY: "not-started"}
STATE_WIDTH = 16  # columns
MOST_ALONE = 5  # TODOs of a stage that are compiled and judged one by one
LOOK_AGAIN = 0.3  # seconds, for a file that has been saved
LONGEST_PRINTED = 400  # of a line that the student's code has printed, in a pipe


# ---- The two commands -----------------------------------------------------------------------------------------------

def run_check(asked: list, as_json: bool, seed, language: str) -> int:
    """Judges the stages asked for, all by default; 0 if every one is right, 1 if not. Raises CourseError(2)."""
    stages = select(asked)
    verdicts = judge_stages(stages, [] if seed is None else [f"--seed={seed}"])
    report(stages, verdicts if as_json else held_back(stages, verdicts), as_json, tell, speaker(language))
    return 0 if all(verdict.state == "right" for verdict in verdicts) else 1


def watch(asked: list, seed, language: str) -> int:
    """Judges the stages asked for, and at each save those of the saved files, until all are right; 0. In a pipe, once."""
    stages, say, seen, states = select(asked), speaker(language), {}, {}
    while True:
        now = {stage["file"]: saved(stage["file"]) for stage in stages}
        if again := [stage for stage in stages if stage["file"] not in seen or now[stage["file"]] != seen[stage["file"]]]:
            verdicts = judge_stages(again, [] if seed is None else [f"--seed={seed}"])
            states |= {stage["id"]: verdict.state for stage, verdict in zip(again, verdicts)}
            print("\033[2J\033[H" if seen else "", end="")  # a clear screen
            report(again, held_back(again, verdicts), False, tell if seen or asked else tell_line, say)
            if set(states.values()) == {"right"} or not sys.stdout.isatty():
                return int(set(states.values()) != {"right"})
            print("\n" + fitted(say("check.watching"), sys.stdout), flush=True)
            seen = now
        time.sleep(LOOK_AGAIN)


def saved(file: str):
    """When the file was last saved; None where there is none, as in the middle of a save."""
    path = folder() / file
    return path.stat().st_mtime_ns if path.exists() else None


def run_status(as_json: bool, language: str) -> int:
    """Judges every stage and shows a line for each, how many are right, and what comes next; 0."""
    stages, say = select([]), speaker(language)
    verdicts = judge_stages(stages)
    report(stages, verdicts if as_json else held_back(stages, verdicts, counts=False), as_json, tell_line, say)
    open_stages = [stage["id"] for stage, verdict in zip(stages, verdicts) if verdict.state != "right"]
    following = sentence("status.next", command=command_of(open_stages[0])) if open_stages else sentence("check.last_stage")
    out = sys.stderr if as_json else sys.stdout
    marks = [mark for stage, verdict in zip(stages, verdicts) for mark in (verdict.todos or dict.fromkeys(stage["todos"], WAITS)).values()]
    said = (say("status.right", n=len(stages) - len(open_stages), all=len(stages), m=marks.count(RIGHT), todos=len(marks)),
            points(open_stages, say), say.text(following))
    print("\n" + fitted(("" if say.language == "zh" else " ").join(said), out), file=out)
    return 0


def points(open_stages: list, say: Speaker) -> str:
    """The points of the right stages; a stage that is not right may have earned some, too."""
    earned = sum(worth(stage) for stage in STAGES if stage["id"] not in open_stages)
    return say("status.points", points=f"{earned:g}", all=f"{sum(map(worth, STAGES)):g}")


def held_back(stages: list, verdicts: list, counts: bool = True) -> list:
    """The verdicts as a student sees them: a failure's cause is named only after one try at finding it."""
    return [hint_policy.hold_back(stage, verdict, NAME_CAUSE_AT_FAILURE, blanks.content_of(folder() / stage["file"]) or b"", counts)
            for stage, verdict in zip(stages, verdicts)]


def select(asked: list) -> list:
    """The requested rows of the table; "1" means 1.1 and 1.2, and a stage's sections, TODOs and file mean it too."""
    def means(name: str, stage: dict) -> bool:
        return covers(name.upper(), stage) or name.lower() in todos_of(stage)
    names = {plain(name): name for name in asked if name.lower() not in ("stage", "阶段")}  # "stage 3" may be two words
    for name in names:
        if not any(means(name, stage) for stage in STAGES):
            raise CourseError(sentence("hint.unknown_stage", name=names[name], stages=", ".join(stage["id"] for stage in STAGES)))
    return [stage for stage in STAGES if not names or any(means(name, stage) for name in names)]


def judge_stages(stages: list, options=()) -> list:
    """The verdicts, in the order of the stages. An untouched file says itself that it is not started: nothing is built for it."""
    untouched = {stage["file"] for stage in stages if (folder() / stage["file"]).exists() and not holds_work(folder() / stage["file"])}
    broken = compile_files(sorted({stage["file"] for stage in stages} - untouched))
    return [with_namesake(untouched_stage(stage) if stage["file"] in untouched else
                          broken.get(stage["file"]) or judge_stage(stage, options), stage["file"]) for stage in stages]


def untouched_stage(stage: dict) -> Verdict:
    """The verdict on a stage of a skeleton: its first blank is not started."""
    throws = dict(re.findall(r'throw HomeworkMissing\("(\S+) (.*)"', (folder() / stage["file"]).read_text(encoding="utf-8")))
    todo = next(todo for todo in throws if todo in todos_of(stage))
    return Verdict("not-started", not_started(todo, throws[todo]), todos={todo: EMPTY for todo in throws if todo in todos_of(stage)})


def with_namesake(verdict: Verdict, file: str) -> Verdict:
    """Tells where the student's code may be, if this file is not there or not begun."""
    found = namesake(file, folder()) if verdict.state in ("not-started", "does-not-compile") else ""
    if not found or verdict.diagnosis.get("begun") or (verdict.state == "does-not-compile" and (folder() / file).exists()):
        return verdict
    cause = sentence("submission.resembling", file=file, found=found) if verdict.state == "does-not-compile" else \
        sentence("check.namesake", file=file, found=found, more=verdict.diagnosis["cause"])
    return verdict._replace(diagnosis={**verdict.diagnosis, "cause": cause})


def judge_stage(stage: dict, options) -> Verdict:
    content = blanks.content_of(folder() / stage["file"])
    verdict, tests = judge_every_test(target(stage["file"]), stage, options)
    verdict = blanks.explain(verdict, stage, content)
    marks = marks_of(stage, verdict, tests, content or b"")
    marks.update(marks_alone(stage, content or b"", marks, options, verdict.diagnosis.get("todo", "")))
    wrong = [todo for todo, mark in marks.items() if mark == WRONG]
    own = {"todo": wrong[0]} if len(wrong) == 1 and verdict.diagnosis.get("todo") in marks else {}
    return verdict._replace(todos=marks, diagnosis={**verdict.diagnosis, **own})


def judge_every_test(check: str, stage: dict, options) -> tuple:
    """The verdict, which the first test that fails decides, and all tests."""
    executable = BIN / program(check)
    verdict = judge(executable, stage, options=options)
    others = verdict.state == "crashes" or (verdict.tests and verdict.state != "right")
    tests = every_test(executable, stage, options) if others else verdict.tests
    if executable.name != check and any("diagnosis" in test for test in tests) and not build([check]).returncode:
        return judge_every_test(check, stage, options)
    return verdict, tests


def marks_of(stage: dict, verdict: Verdict, tests: tuple, content: bytes) -> dict:
    return ticks(stage, tests, content, blamed_by(verdict.diagnosis, content) if verdict.state != "not-started" else "")


def marks_alone(stage: dict, content: bytes, marks: dict, options, suspect: str = "") -> dict:
    """Other marks of TODOs, by the solution's lines: first in what is empty; then in the one blank that is blamed, without which all
    others may be right; if they are not, or none or several are blamed, in all blanks but one. {} without the solutions, as in the
    students' archive, and where the blanks cannot be told apart."""
    file, text = stage["file"], content.decode("utf-8", "surrogateescape")
    spans = blanks_of(file, text) if WRONG in marks.values() or WAITS in marks.values() else {}
    if not spans or not (ROOT / "solutions" / file).exists() or not {*marks} <= spans.keys():
        return {}

    def judged_with(solved: list) -> tuple:
        """The verdict and the tests of this text with the solution's lines in these blanks; None if it does not compile."""
        filled = mended(file, text, solved).encode("utf-8", "surrogateescape")
        (BUILD / "filled").mkdir(exist_ok=True)
        if blanks.content_of(BUILD / "filled" / file) != filled:
            (BUILD / "filled" / file).write_bytes(filled)
        check = f"filled_check_{Path(file).stem}"
        return None if build([program(check)]).returncode else (*judge_every_test(check, stage, options), filled)

    def is_right(solved: list):
        """None if it does not compile."""
        judged = judged_with(solved)
        return judged and judged[0].state == "right"

    found, empty = {}, [todo for todo in spans if blanks.is_empty(todo, content)]  # of all stages, so that they share a program
    if WAITS in marks.values() and {*empty} & {*marks} and (judged := judged_with(empty)):
        verdict, tests, filled = judged
        found = {todo: mark for todo, mark in marks_of(stage, blanks.explain(verdict, stage, filled), tests, filled).items()
                 if marks[todo] == WAITS}
    now = {**marks, **found}
    blamed = [todo for todo, mark in now.items() if mark == WRONG or (mark == WAITS and todo == suspect)]
    waiting = [todo for todo, mark in now.items() if mark == WAITS and todo not in blamed]
    if len(blamed) < 2 and not waiting:
        return found
    if len(blamed) == 1 and is_right([*empty, *blamed]):
        return {**found, **dict.fromkeys(waiting, RIGHT), blamed[0]: WRONG}
    for todo in blamed + (waiting if len(blamed + waiting) <= MOST_ALONE else []):
        if (alone := is_right([other for other in spans if other != todo])) is not None:
            found[todo] = RIGHT if alone else WRONG
    wrong = [todo for todo, mark in found.items() if mark == WRONG]
    outside = len(wrong) > 1 and is_right([*spans]) is False  # a line that is in none of the blanks is wrong
    return {**found, **dict.fromkeys(wrong, WAITS)} if outside else found


def report(stages: list, verdicts: list, as_json: bool, tell_one, say: Speaker) -> None:
    """One JSON object on standard output, the words then on standard error; or the words on standard output."""
    out = sys.stderr if as_json else sys.stdout
    for stage, verdict in zip(stages, verdicts):
        tell_one(stage, verdict, out, say)
    if as_json:
        jsonout.emit({"stages": [{"id": stage["id"], "state": verdict.state, "hint": in_short(verdict.diagnosis, say),
                                  "todos": {todo: TICK_NAMES[mark] for todo, mark in verdict.todos.items()}}
                                 for stage, verdict in zip(stages, verdicts)]})


# ---- Compiling ------------------------------------------------------------------------------------------------------

def folder() -> Path:
    """The student's files. The end-to-end test has a folder and executables of its own, the latter marked by a prefix."""
    return Path(os.environ.get("CH5_CHECK_FOLDER") or HOMEWORK)


def target(file: str) -> str:
    """The executable that judges this file."""
    return os.environ.get("CH5_CHECK_PREFIX", "") + "check_" + Path(file).stem


def program(check: str) -> str:
    """What is built of it: until an answer is wrong for the first time, a program that names no slips, for which half a minute less
    of compiling is needed."""
    return check if (BIN / check).exists() else f"first_{check}"


def compile_files(files: list) -> dict:
    """Builds what judges these files; returns a verdict for each file that cannot be compiled."""
    if not files:
        return {}
    done = build(["-k", "0", *(program(target(file)) for file in files)])
    keep_warnings(files, done.stdout)
    if done.returncode == 0:
        return {}
    if len(files) == 1:
        return {files[0]: does_not_compile(files[0], done.stdout, blanks.content_of(folder() / files[0]))}
    return {file: verdict for each in files for file, verdict in compile_files([each]).items()}


def keep_warnings(files: list, output: str) -> None:
    """Remembers the compiler's warnings of the files that this build has compiled."""
    compiled = [file for file in files if f"{target(file)}_student.dir/" in output]
    known = kept_warnings()
    known.update({str(folder() / file): warnings((folder() / file).resolve(), output) for file in compiled})
    if compiled:
        (BUILD / "warnings.json").write_text(json.dumps(known, ensure_ascii=False, indent=1), encoding="utf-8")


def kept_warnings() -> dict:
    """{path: [[line, words], …]}, as the last compilation of each file has given them."""
    try:
        return json.loads((BUILD / "warnings.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}


# ---- Telling --------------------------------------------------------------------------------------------------------

def paint(text: str, state: str, out) -> str:
    if not out.isatty() or os.environ.get("NO_COLOR"):
        return text
    return f"\033[1;{COLORS[state]}m{text}\033[0m"


def state_of(verdict: Verdict, say: Speaker) -> str:
    return say("state.half-done" if verdict.diagnosis.get("begun") else f"state.{verdict.state}")


def tell_line(stage: dict, verdict: Verdict, out, say: Speaker) -> None:
    """One line of ./course status, and one for the hint."""
    state = paint(f"{MARKS.get(verdict.state, '✗')} {pad(state_of(verdict, say), STATE_WIDTH)}", verdict.state, out)
    title = f"{title_of(stage['id'], say)} ({stage['file']})"
    narrow = out.isatty() and shutil.get_terminal_size().columns < 100
    print(f"{stage['id']:<4} {state}" + ("\n" + fitted(f"       {title}", out) if narrow else f"  {title}"), file=out)
    tell_ticks(verdict, "       ", out, say)
    if verdict.diagnosis:
        print(fitted(f"       {in_short(verdict.diagnosis, say)}", out), file=out)


def tell(stage: dict, verdict: Verdict, out, say: Speaker) -> None:
    """The verdict of ./course check, all that it says, and what to do next."""
    head = f"{MARKS.get(verdict.state, '✗')} {stage['id']} {state_of(verdict, say)}"
    print(f"{paint(head, verdict.state, out)}   {title_of(stage['id'], say)}", file=out)
    tell_ticks(verdict, "  ", out, say)
    tell_printed(verdict, out, say)
    words = in_full(verdict.diagnosis, verdict.output, say)
    print("\n" + fitted(indent(words + line_at(verdict.diagnosis.get("place"))), out) + "\n" if verdict.state != "right" else "", file=out, end="")
    tell_map(verdict, out, say)
    if verdict.state not in ("right", "not-started"):
        tell_warnings(stage["file"], out, say)
    lines = (*compared(stage, "" if verdict.diagnosis.get("begun") else verdict.state, folder(), say), say.text(next_step(stage, verdict)), "")
    print("\n".join(fitted(f"  {line}".rstrip(), out) for line in lines), file=out)


def line_at(place: str) -> str:
    """The student's line at "problem.cc:84", below the words about it, or ""."""
    file, _, number = (place or "").partition(":")
    lines = (blanks.content_of(folder() / file) or b"").decode("utf-8", "replace").splitlines() if number else []
    return f"\n\n{number} │ {lines[int(number) - 1].strip()}" if 0 < int(number or 0) <= len(lines) else ""


def tell_ticks(verdict: Verdict, indented: str, out, say: Speaker) -> None:
    """A mark for each TODO of several, once one is more than empty and the stage is not right yet."""
    marks = set(verdict.todos.values())
    if marks - {EMPTY} and marks != {RIGHT} and len(verdict.todos) > 1:
        line = "  ".join(f"{todo} {paint(mark, TICK_COLORS[mark], out) if mark in TICK_COLORS else mark}" for todo, mark in verdict.todos.items())
        print(indented + line + (f"   ({say('check.todo_waits')})" if WAITS in marks else ""), file=out)


def tell_printed(verdict: Verdict, out, say: Speaker) -> None:
    """What the student's code has printed in the check that failed: its beginning, or its end where it crashed."""
    lines = verdict.printed.strip("\n").splitlines()
    if not lines:
        return
    crashed = verdict.state == "crashes"
    head = say("check.printed") if len(lines) <= SHOWN_LINES else \
        say("check.printed_last" if crashed else "check.printed_first", n=SHOWN_LINES, size=in_bytes(verdict.printed_bytes))
    shown_lines = lines[-SHOWN_LINES:] if crashed else lines[:SHOWN_LINES]
    width = shutil.get_terminal_size().columns - 4 if out.isatty() else LONGEST_PRINTED
    print("\n  " + head, file=out)
    print("\n".join("  │ " + (line if len(line) <= width else line[:width - 1] + "…") for line in shown_lines), file=out)


def tell_map(verdict: Verdict, out, say: Speaker) -> None:
    """Which blocks of the matrix are wrong."""
    failed = next((test for test in verdict.tests if test.get("failures")), {})
    if lines := block_map(failed, say) if verdict.state == "wrong" else []:
        print(f"\n  {say('check.blocks')}\n    " + "\n    ".join(lines) + "\n", file=out)


def tell_warnings(file: str, out, say: Speaker) -> None:
    warned = kept_warnings().get(str(folder() / file), [])[:SHOWN_LINES]
    if warned:
        print(f"  {say('check.compiler_warns')}", file=out)
    for line, words in warned:
        words = say("compiler.comment_continues") if words.startswith("multi-line comment") else words
        print(fitted(f"    {file}:{line}: {words}", out), file=out)
    print("\n" if warned else "", file=out, end="")


def indent(text: str) -> str:
    return "\n".join(("  " + line).rstrip() for line in text.splitlines())


def command_of(stage: str) -> str:
    """What checks a stage of this homework."""
    where = "" if HOMEWORK == ROOT / "ch5_homework" else f"CH5_HOMEWORK_DIR={shlex.quote(str(HOMEWORK))} "
    return f"{where}./course check {stage}"


def next_step(stage: dict, verdict: Verdict) -> dict:
    """What to do, as data."""
    again = command_of(stage["id"])
    file = stage["file"] if HOMEWORK == ROOT / "ch5_homework" else shown(HOMEWORK / stage["file"])
    if verdict.state == "right":
        ids = [row["id"] for row in STAGES]
        following = ids[ids.index(stage["id"]) + 1:]
        if not following:
            return sentence("check.last_stage")
        done = "check.next_stage_after_page" if stage.get("read_by_instructor") else "check.next_stage"
        return sentence(done, stage=stage["id"], command=command_of(following[0]))
    if cause_of(verdict.diagnosis) in ("judge.ended_by_itself", "judge.prints_too_much"):
        return sentence(f"check.next_{cause_of(verdict.diagnosis).partition('.')[2]}", file=file, command=again)
    return sentence(f"check.next_{verdict.state.replace('-', '_')}", file=file, todo=verdict.diagnosis.get("todo", ""),
                    stage=stage["id"], command=again)
