"""What is right in a stage that is not: its blanks are judged one by one, so that one slip does not cost all.

A blank is replaced by the solution's lines, and the stage compiled and judged as before. If it is right with k of its n
blanks replaced, the other n − k are right, and earn their part of the points, rounded down to half a point. What earns
points passes every check, on the same cases, in the same sandbox; what such a program prints is not shown. The solution's lines
are inserted only between lines that cannot read them (provenance.closed_to), and have the numbers of those that they replace.
"""

from . import provenance
from ..homework.blanks import own_todo
from ..homework.diagnosis import Verdict
from ..homework.mended import blanks_of, mended


def follow_through(stage: dict, content: bytes, verdict: Verdict, judge) -> dict:
    """{"replaced", "blanks"} if some blanks of a stage are right, else {}; what they are worth is the rubric's business.
    judge(content) gives the verdict on another text of the file."""
    file, text = stage["file"], content.decode("utf-8", "surrogateescape")
    spans, todos, empty = blanks_to_judge(stage, text)
    if not todos:
        return {}
    known = {frozenset(): verdict}

    def blanks(replaced) -> int:  # of the second depth those that are not right: the others any file has if it says it has them
        return len({*stage["todos"], *replaced})

    def some_left(replaced) -> bool:
        return len(replaced) < blanks(replaced)

    def after(replaced) -> Verdict:
        key = frozenset(replaced)
        if key not in known:
            known[key] = judge(mended(file, text, key).encode("utf-8", "surrogateescape"))
        return known[key]

    replaced = list(empty)
    while some_left(replaced):
        verdict = after(replaced)
        if verdict.state == "right":
            return {"replaced": replaced, "blanks": blanks(replaced)}
        named = blamed(verdict, file, content, spans)
        if verdict.state == "times-out" or named not in todos or named in replaced:
            break
        replaced.append(named)
    if len(replaced) > len(empty) + 1 or verdict.state == "times-out":
        return {}
    for replaced in ([*empty, todo] for todo in todos if todo not in empty):  # the diagnosis may blame another blank
        if some_left(replaced) and after(replaced).state == "right":
            return {"replaced": replaced, "blanks": blanks(replaced)}
    return {}


def blanks_to_judge(stage: dict, text: str) -> tuple:
    """({TODO: its lines}, the stage's TODOs, those of them that are left empty); no TODOs where blanks cannot be told apart, or
    nothing is filled in: no empty blank passes with the rest right."""
    lines, none, spans = text.splitlines(), ({}, [], []), blanks_of(stage["file"], text)
    within = {todo: lines[slice(*spans[todo])] for todo in [*stage["todos"], *stage.get("deep", [])] if todo in spans}
    if not set(stage["todos"]) <= within.keys():
        return none
    if not provenance.closed_to(text, [offset(text, line) for span in spans.values() for line in span]):
        return none
    if not any(line.strip() and not line.strip().startswith("//") for blank in within.values() for line in blank):
        return none
    return spans, list(within), [todo for todo, blank in within.items()
                                 if any(line.strip().startswith("throw HomeworkMissing(") for line in blank)]


def offset(text: str, line: int) -> int:
    return sum(map(len, text.splitlines(keepends=True)[:line]))


def blamed(verdict: Verdict, file: str, content: bytes, spans: dict) -> str:
    """The blank that a diagnosis names, or in which the program has ended."""
    if todo := verdict.diagnosis.get("todo"):
        return own_todo(todo, content)
    number = str(verdict.diagnosis.get("place", "")).removeprefix(f"{file}:")
    return next((todo for todo, (begin, end) in spans.items() if number.isdigit() and begin < int(number) <= end), "")

