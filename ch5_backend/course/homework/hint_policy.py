"""When ./course check says which mistake it sees: at a failure's second time, so that there is something to find first.

The number stands in ch5_homework/stages.json, "name_cause_at_failure"; 1 names causes at once.
"""

import json

from . import hint
from ..base.build import BUILD, HOMEWORK
from ..base.language import sentence
from .diagnosis import SYMPTOMS, UNSET, Verdict, cause_of


def hold_back(stage: dict, verdict: Verdict, threshold: int, counts: bool = True) -> Verdict:
    """The verdict as a student reads it, without its cause if the stage has not failed like this often enough.

    `counts` says whether this is a failure of its own, or only another look at one.
    """
    diagnosis = verdict.diagnosis if verdict.state == "wrong" else {}
    failure = json.dumps([diagnosis["stage"], diagnosis["check"]], ensure_ascii=False) if "check" in diagnosis else ""
    times, cause = remember(stage["id"], failure, counts), cause_of(diagnosis)
    if not failure or times >= threshold or not cause or cause in SYMPTOMS + UNSET:
        return verdict
    section = section_of(stage, diagnosis.get("todo", ""))
    why = (sentence("hint.named_second_time", section=section) if threshold == 2 else
           sentence("hint.named_at_failure", n=threshold, section=section))
    return verdict._replace(diagnosis={**{key: value for key, value in diagnosis.items() if key != "cause"}, "held_back": why})


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


def section_of(stage: dict, todo: str) -> str:
    """The handout's section that a diagnosis belongs to."""
    sections = stage.get("sections", [stage["id"]])
    return hint.find(todo, hint.handout("en")) if todo and len(sections) > 1 else sections[0]
