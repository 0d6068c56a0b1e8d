"""When ./course check says which mistake it sees: when the same mistake comes a second time, in a file that has changed since, so
that there is something to find first.

The number stands in ch5_homework/stages.json, "name_cause_at_failure"; 1 names causes at once.
"""

import hashlib
import json

from . import hint
from ..base.cmake_build import BUILD, HOMEWORK
from ..base.language import sentence
from .diagnosis import SYMPTOMS, UNSET, Verdict, cause_of


def hold_back(stage: dict, verdict: Verdict, threshold: int, content: bytes, counts: bool = True) -> Verdict:
    """The verdict on a file with this content as a student reads it, without its cause if the stage has not failed like this
    often enough.

    `counts` says whether this is a failure of its own, or only another look at one.
    """
    diagnosis = verdict.diagnosis if verdict.state == "wrong" else {}
    cause = cause_of(diagnosis)
    failure = json.dumps([diagnosis["stage"], diagnosis["check"], cause], ensure_ascii=False) if "check" in diagnosis else ""
    times = remember(stage["id"], failure, hashlib.sha256(content).hexdigest()[:16], counts)
    if not failure or times >= threshold or not cause or cause in SYMPTOMS + UNSET:
        return verdict
    section = hint.section_of(stage["id"], diagnosis.get("todo", ""), hint.handout("en"))
    why = (sentence("hint.named_second_time", section=section) if threshold == 2 else
           sentence("hint.named_at_failure", n=threshold, section=section))
    return verdict._replace(diagnosis={**{key: value for key, value in diagnosis.items() if key != "cause"}, "held_back": why})


def remember(stage_id: str, failure: str, digest: str, counts: bool) -> int:
    """How often the stage has failed like this in a row, each time with another content; "" is no failure."""
    path, key = BUILD / "failures.json", f"{HOMEWORK} {stage_id}"
    try:
        known = json.loads(path.read_text(encoding="utf-8"))
        known = {name: row for name, row in known.items() if len(row) == 3}
    except (OSError, ValueError, AttributeError, TypeError):
        known = {}
    last, last_digest, times = known.get(key, ["", "", 0])
    if last != failure:
        times = 0
    if not counts or (last, last_digest) == (failure, digest):
        return times
    times += 1
    known[key] = [failure, digest, times]
    try:
        path.write_text(json.dumps(known, ensure_ascii=False, indent=1), encoding="utf-8")
    except OSError:  # then causes are named at once, rather than never
        return 1 << 30
    return times
