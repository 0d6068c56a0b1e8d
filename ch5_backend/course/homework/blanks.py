"""The blanks of a student's file, as text: whether they are filled, and with what."""

import re
from pathlib import Path

from ..base.language import sentence
from .diagnosis import Verdict
from .regions import STAGES


MOST_NAMES = 50  # of a line that are looked for in the lines above it
DEEP = "// The second depth (./course deep): more blanks than usual.\n"  # the first line of such a file
BARE = "// The third depth (./course deep --bare): empty functions; the handout has their formulas.\n"  # likewise
DECLARATION = re.compile(r"\s*(?:MatXX|VecX)\b([\w,\s]*);")


def content_of(path: Path):
    """The bytes of a file, or None."""
    try:
        return path.read_bytes()
    except OSError:
        return None


def asks_deep(content: bytes) -> bool:
    """Whether a file is at the second or third depth: its first line says so, or it contains a task that only these have."""
    return any(first.strip().encode() in content for first in (DEEP, BARE)) or any(
        f"home work {todo}.".encode() in content for stage in STAGES for todo in stage.get("deep", []))


def depth_of(content: bytes) -> int:
    return 3 if BARE.strip().encode() in content else 2 if asks_deep(content) else 1


def keeps_throw(content: bytes, todo: str) -> bool:
    """Whether this blank has code, and below it still the throw that says it is empty."""
    _, task, rest = content.decode("utf-8", "replace").partition(f"TODO:: home work {todo}.")
    blank, throw, _ = rest.partition(f'throw HomeworkMissing("{todo} ')
    return bool(task and throw) and any(line.strip() and not line.strip().startswith("//") for line in blank.splitlines()[1:])


def is_empty(todo: str, content: bytes) -> bool:
    """Whether this blank still has the throw that says it is empty."""
    return f'throw HomeworkMissing("{todo} '.encode() in content


def some_filled(stage: dict, content: bytes) -> bool:
    """Whether a blank of this stage has lost its throw; those of the second depth count where the file asks for them."""
    asked = stage.get("deep", []) if asks_deep(content) else []
    return any(not is_empty(todo, content) for todo in stage["todos"] + asked)


def still_empty(text: str, number: int):
    """(variable, TODO) of a matrix in line `number` to which nothing was assigned since it was declared, or None."""
    lines = text.splitlines()
    code = [line.partition("//")[0] for line in lines]
    if not 0 < number <= len(code):
        return None
    declarations = {name: i for i, line in enumerate(code[:number - 1]) if (found := DECLARATION.match(line))
                    for name in re.findall(r"\w+", found[1])}
    for name in re.findall(r"\b[A-Za-z_]\w*\b", code[number - 1])[:MOST_NAMES]:
        declared = declarations.get(name)
        if declared is None or re.search(rf"\b{name} *=(?!=)", code[number - 1]):
            continue
        between = range(declared + 1, number - 1)
        if any(re.search(rf"\b{name}\b", code[i]) for i in between):
            continue
        todos = [found[1] for i in between if (found := re.search(r"TODO:: home work (\S+)\.", lines[i]))]
        if todos:
            return name, todos[0]
    return None


def own_todo(todos: str, content: bytes) -> str:
    """Of the TODOs that a mistake may belong to, such as "1.1c 1.1a", the one that this file asks for: the second depth has
    blanks where the usual skeleton has lines."""
    deep = {todo for stage in STAGES for todo in stage.get("deep", [])}
    found = todos.split() or [""]
    return next((todo for todo in found if todo not in deep or asks_deep(content)), found[-1])


def explain(verdict: Verdict, stage: dict, content) -> Verdict:
    """The TODO is one of this file's; a stage of which a blank is filled has been begun; a throw below a student's lines is
    distinguished from an empty blank; and a crash in lines that the student did not write is explained: a blank left empty."""
    content, told = content or b"", dict(verdict.diagnosis)
    if " " in told.get("todo", ""):
        told["todo"] = own_todo(told["todo"], content)
    if verdict.state == "not-started":
        if keeps_throw(content, told.get("todo", "")):
            told["cause"] = sentence("judge.leftover_throw", todo=told["todo"])
        if some_filled(stage, content):
            told["begun"] = True
    number = told.get("place", "").removeprefix(f"{stage['file']}:") if verdict.state == "crashes" else ""
    if number.isdigit() and (found := still_empty(content.decode("utf-8", "replace"), int(number))):
        variable, told["todo"] = found
        told["cause"] = sentence("judge.blank_left_empty", variable=variable, todo=told["todo"], more=told["cause"])
    return verdict._replace(diagnosis=told)
