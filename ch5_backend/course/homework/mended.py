"""A student's file with the solution's lines in some of its blanks, so that each blank can be judged alone."""

import difflib
import re

from .blanks import asks_deep
from .make_skeleton import skeleton
from .regions import regions, solution_text

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
