"""What is right in a stage that is not: its blanks are judged one by one, so that one slip does not cost all.

A blank is replaced by the solution's lines, and the stage compiled and judged as before. If it is right with k of its n
blanks replaced, the other n − k are right, and earn their part of the points, rounded down to half a point. What earns
points passes every check, on the same cases, in the same sandbox; what such a program prints is not shown. The solution's lines
are inserted only between lines that cannot read them (provenance.closed_to), and have the numbers of those that they replace.
"""

import difflib
import re

from . import provenance
from ..homework.blanks import asks_deep, own_todo
from ..homework.diagnosis import Verdict
from ..homework.make_skeleton import skeleton
from ..homework.regions import regions, solution_text


MOST_LINES = 5000  # of a file in which blanks are looked for; the solutions have 300


def blanks_of(file: str, text: str) -> dict:
    """{todo: (begin, end)} in lines of a student's file: the lines between the skeleton's lines on either side of a blank.
    Without the blanks around which these lines have been changed."""
    lines = [line.strip() for line in text.splitlines()]
    if len(lines) > MOST_LINES:
        return {}
    solved = {region.todo: region for region in regions(solution_text(file))}
    deep = asks_deep(text.encode("utf-8", "surrogateescape"))
    blanks = [region for region in solved.values() if deep or region.kind == "SOLUTION"]
    found = {}
    for tasks in (False, True):  # some delete the comment above a blank together with its throw
        frame, places = frame_of(file, blanks, deep, tasks)
        at = {}
        for block in difflib.SequenceMatcher(None, frame, lines, autojunk=False).get_matching_blocks():
            at.update({block.a + k: block.b + k for k in range(block.size)})
        found.update({todo: (at[place - 1] + 1, at[place])
                      for todo, place in places.items()
                      if place - 1 in at and place in at and list(places.values()).count(place) == 1})
    return found


def frame_of(file: str, blanks: list, deep: bool, tasks: bool) -> tuple:
    """The lines of a skeleton outside of its blanks, with or without the comments that say what to write there, and
    {todo: how many of them come before it}."""
    text, frame, places = skeleton(file, depth=2 if deep else 1), [], {}
    for region in blanks:
        before, _, text = text.partition(region.blank(deep))
        if not tasks:
            before = re.sub(r" *// TODO:: .*\n( *//.*\n)*\Z", "", before)
        frame += before.splitlines()
        places[region.todo] = len(frame)
    return [line.strip() for line in frame + text.splitlines()], places


def mended(file: str, text: str, todos) -> str:
    """The student's file with the solution's lines in these blanks."""
    solved = {region.todo: region.solution for region in regions(solution_text(file))}
    lines = text.splitlines(keepends=True)
    for todo, (begin, end) in sorted(blanks_of(file, text).items(), key=lambda item: item[1], reverse=True):
        if todo in todos:
            lines[begin:end] = [solved[todo], f"#line {end + 1}\n"]
    return "".join(lines)


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

