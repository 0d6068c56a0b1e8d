"""./course hint: the handout's folded hints, one at a time, so that a terminal hides them as a browser does."""

import re
import sys
from pathlib import Path

from ..base.cmake_build import ROOT
from ..base.errors import CourseError
from ..base.language import fitted, sentence
from .names import plain
from .regions import STAGES, covers, sections_of

SUFFIX = {"en": ".md", "zh": ".zh.md"}
STAGE = {"en": "Stage", "zh": "阶段"}


def show(name: str, number: str, language: str) -> int:
    """Prints one hint of each section that the name means, as ./course check does, or of the one that treats a TODO; 0.
    Raises CourseError(2)."""
    sections = handout(language)
    for section in named(plain(name), sections):
        show_one(section, hints_of(sections[section]), number, language)
    return 0


def show_one(section: str, hints: dict, number: str, language: str) -> None:
    if number not in hints:
        raise CourseError(sentence("hint.unknown_number", stage=section, numbers=", ".join(hints), number=number,
                                   command=f"./course hint {section} 1"))
    title, text = hints[number]
    print(fitted(f"{STAGE[language]} {section} · {title}\n\n{text}\n".replace("`", ""), sys.stdout))
    following = str(int(number) + 1)
    print(f"./course check {section}" + (f"   ./course hint {section} {following}" if following in hints else ""))


def page(stage: dict, language: str) -> Path:
    return ROOT / "ch5_homework" / "handout" / f"stage_{stage['id']}{SUFFIX[language]}"


def handout(language: str) -> dict:
    """{"1.1": its section of the handout}, in order."""
    text = "".join(page(stage, language).read_text(encoding="utf-8") for stage in STAGES)
    parts = re.split(r"^##? (?:Stage|阶段) (\S+) ·.*$", text, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2]))


def hints_of(section: str) -> dict:
    """{"1": (title, text)}"""
    found = re.findall(r"<details><summary>((?:Hint|提示) (\d)[^<]*)</summary>\n\n(.*?)\n</details>", section, re.DOTALL)
    return {number: (title, text) for title, number, text in found}


def named(name: str, sections: dict) -> list:
    """The sections of the stages that a name covers, or the one that it finds. Raises CourseError(2)."""
    if name in sections:
        return [name]
    covered = [section for stage in STAGES if covers(name, stage) for section in sections_of(stage)]
    return covered or [find(name, sections)]


def find(name: str, sections: dict) -> str:
    """The section of this name, or the one with a row on this TODO; a TODO of the second depth is in its stage's last."""
    row = re.compile(rf"^\| {re.escape(name)} \|", re.MULTILINE)
    for section, text in sections.items():
        if name == section or row.search(text):
            return section
    for stage in STAGES:
        if name in stage.get("deep", []):
            return sections_of(stage)[-1]
    raise CourseError(sentence("hint.unknown_stage" if name else "hint.needs_a_stage", name=name, stages=", ".join(sections)))


def section_of(stage_id: str, todo: str, sections: dict) -> str:
    """The section that a diagnosis belongs to: by the TODO that it names, or by the stage."""
    try:
        return find(todo, sections)
    except CourseError:
        return named(stage_id, sections)[0]
