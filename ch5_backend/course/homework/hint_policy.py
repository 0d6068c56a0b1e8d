"""When ./course check says which mistake it sees: at a failure's second time, so that there is something to find first.

The number stands in ch5_homework/stages.json, "name_cause_at_failure"; 1 names causes at once.
"""

import json
import re

from . import hint
from ..base.build import BUILD, HOMEWORK
from .judge import Verdict

# What gives no answer away is told at once.
CAUSE = re.compile(r"^  cause +(?!none of the typical mistakes|still empty|still zero|nothing was assigned)\S.*(?:\n {12}.*)*", re.MULTILINE)


def hold_back(stage: dict, verdict: Verdict, threshold: int, counts: bool = True) -> Verdict:
    """The verdict as a student reads it, without its cause if the stage has not failed like this often enough.

    `counts` says whether this is a failure of its own, or only another look at one.
    """
    failure = verdict.story.partition("\n")[0] if verdict.state == "wrong" else ""
    times = remember(stage["id"], failure, counts)
    if not failure or times >= threshold or not CAUSE.search(verdict.story):
        return verdict
    line = ("  cause     named " + ("the second time" if threshold == 2 else f"at failure {threshold}") +
            f" this fails; before that, try ./course hint {section_of(stage, verdict.story)} 1")
    return verdict._replace(hint=failure + ".", story=CAUSE.sub(line, verdict.story, 1))


def remember(stage_id: str, failure: str, counts: bool) -> int:
    """How often the stage has failed like this in a row; "" is no failure."""
    path, key = BUILD / "failures.json", f"{HOMEWORK} {stage_id}"
    try:
        known = json.loads(path.read_text(encoding="utf-8"))
        known = known if isinstance(known, dict) else {}
    except (OSError, ValueError):
        known = {}
    last, times = known.get(key, ["", 0])
    times = (times if last == failure else 0) + counts
    if not counts:
        return times
    known[key] = [failure, times]
    try:
        path.write_text(json.dumps(known, ensure_ascii=False, indent=1), encoding="utf-8")
    except OSError:  # then causes are named at once, rather than never
        return 1 << 30
    return times


def section_of(stage: dict, story: str) -> str:
    """The handout's section that a story belongs to."""
    todo = re.search(r"TODO (\S+)$", story, re.MULTILINE)
    sections = stage.get("sections", [stage["id"]])
    return hint.find(todo[1], hint.handout("en")) if todo and len(sections) > 1 else sections[0]
