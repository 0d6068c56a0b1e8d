"""./course hint: the handout's folded hints, one at a time, so that a terminal hides them as a browser does."""

import re

from ..base.build import ROOT
from ..base.errors import CourseError
from ..base.language import sentence, spoken

HANDOUTS = {"en": "README.md", "zh": "README.zh.md"}


def show(name: str, number: str, language: str = "") -> int:
    """Prints one hint of a section, or of the section that treats a TODO; 0. Raises CourseError(2)."""
    sections = handout(language or spoken())
    section = find(name, sections)
    hints = hints_of(sections[section])
    if number not in hints:
        raise CourseError(sentence("hint.unknown_number", stage=section, numbers=", ".join(hints), number=number,
                                   command=f"./course hint {section} 1"))
    title, text = hints[number]
    print(f"Stage {section} · {title}\n\n{text}\n")
    following = str(int(number) + 1)
    print(f"./course check {section}" + (f"   ./course hint {section} {following}" if following in hints else ""))
    return 0


def handout(language: str) -> dict:
    """{"1.1": its section of the handout}, in order."""
    text = (ROOT / "ch5_homework" / HANDOUTS[language]).read_text(encoding="utf-8")
    parts = re.split(r"^## Stage (\S+) ·.*$", text, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2]))


def hints_of(section: str) -> dict:
    """{"1": (title, text)}"""
    found = re.findall(r"<details><summary>((?:Hint|提示) (\d)[^<]*)</summary>\n\n(.*?)\n</details>", section, re.DOTALL)
    return {number: (title, text) for title, number, text in found}


def find(name: str, sections: dict) -> str:
    """The section of this name, or the one with a row on this TODO."""
    row = re.compile(rf"^\| {re.escape(name)} \|", re.MULTILINE)
    for section, text in sections.items():
        if name == section or row.search(text):
            return section
    raise CourseError(sentence("hint.unknown_stage" if name else "hint.needs_a_stage", name=name, stages=", ".join(sections)))
