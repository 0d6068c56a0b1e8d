"""Writes what pages list of each stage, from ch5_homework/stages.json: python3 -m ch5_backend.course.homework.stage_tables"""

import re

from .regions import ROOT, STAGES, worth

PAGES = {ROOT / f"{page}{ending}.md": language for page in ("README", "ch5_homework/README", "ch5_homework/INSTRUCTORS")
         for ending, language in (("", "en"), (".zh", "zh"))}
ROWS = re.compile(r"(?:^\| \[[\d.]+\]\(handout/[^\n]+\n)+", re.MULTILINE)
POINTS = re.compile(r"(?:^\| [\d.]+ \| [\d.]+ \|\n)+", re.MULTILINE)
LECTURE = re.compile(r"^(?P<lecture>\| (?P<number>\d) \| [^|]+ \| \d\d \|)[^|\n]+\|(?= [^|\n]+ \|$)", re.MULTILINE)  # its number, name and minutes


def link(stage: dict, language: str, folder: str) -> str:
    return f"[{stage['id']}]({folder}/stage_{stage['id']}{'' if language == 'en' else f'.{language}'}.md)"


def with_stages(page: str, language: str) -> str:
    """The page with today's rows in the table of the homework and in that of its points, and with each lecture's stages."""
    rows = "".join(f"| {link(stage, language, 'handout')} | {', '.join(stage['todos'])} | `{stage['file']}` | {stage['title'][language]} |\n"
                   for stage in STAGES)
    points = "".join(f"| {stage['id']} | {worth(stage):g} |\n" for stage in STAGES)

    def of_lecture(row) -> str:
        links = [link(stage, language, "ch5_homework/handout") for stage in STAGES if stage["lecture"] == int(row["number"])]
        return f"{row['lecture']} {(', ' if language == 'en' else '、').join(links) or '–'} |"
    return LECTURE.sub(of_lecture, POINTS.sub(points, ROWS.sub(lambda _: rows, page)))


if __name__ == "__main__":
    for path, language in PAGES.items():
        path.write_text(with_stages(path.read_text(encoding="utf-8"), language), encoding="utf-8")
