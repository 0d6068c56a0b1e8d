"""Solutions with their graded regions marked, and the stage table.

A region of solutions/NAME.cc reads

    // BEGIN SOLUTION <todo> <place>
    the solution
    // BLANK
    // the hints that stand in the skeleton instead
    // END SOLUTION

At the second depth, deep, a region becomes its throw alone; and regions between // BEGIN DEEP and // END DEEP, whose
solution everybody else is given, become blank too. At the third depth nothing is left of a function with a blank but the
names of its tasks and their throws.

The students' archive has solutions/NAME.cc.blank instead: the same text without what the first depth asks for.
"""

import json
import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
STAGE_TABLE = ROOT / "ch5_homework" / "stages.json"
TABLE = json.loads(STAGE_TABLE.read_text(encoding="utf-8"))
STAGES, NAME_CAUSE_AT_FAILURE = TABLE["stages"], TABLE["name_cause_at_failure"]
FILES = sorted({stage["file"] for stage in STAGES})


def title_of(stage: str, say) -> str:
    return next(row["title"] for row in STAGES if row["id"] == stage)[say.language]


def worth(stage: dict) -> float:
    """The points of all checks of a stage; 0 of one that has none yet."""
    return sum(check["points"] for check in stage.get("checks", {}).values())


def check_in_words(stage: str, check: str, say) -> str:
    """A check of another version of the course keeps its name."""
    return next((row.get("checks", {}).get(check, {}) for row in STAGES if row["id"] == stage), {}).get(say.language, check)


def sections_of(stage: dict) -> list:
    """The handout's sections on a stage: one, unless the table says otherwise."""
    return stage.get("sections", [stage["id"]])


def covers(name: str, stage: dict) -> bool:
    """Whether a name means this stage: "1" means 1.1 and 1.2, and a section or a file its stages."""
    return stage["id"].startswith(name + ".") or name in [stage["id"], *sections_of(stage)] or name.lower() == stage["file"]


@dataclass(frozen=True)
class Region:
    kind: str      # "SOLUTION" or "DEEP"
    todo: str      # "1.1a"
    place: str     # "MakeHessian, the block (v_i, v_j)"
    indent: str
    solution: str  # lines, each with its newline
    hints: str     # likewise

    def blank(self, deep: bool = False) -> str:
        """What a student finds here."""
        hints = "" if deep and self.kind == "SOLUTION" else self.hints
        return f'{hints}{self.indent}throw HomeworkMissing("{self.todo} {self.place}");\n'


_REGION = re.compile(
    r"^(?P<indent> *)// BEGIN (?P<kind>SOLUTION|DEEP) (?P<todo>\S+) (?P<place>[^\n]+)\n"
    r"(?P<solution>.*?)^ *// BLANK\n(?P<hints>.*?)^ *// END (?P=kind)\n", re.MULTILINE | re.DOTALL)


def solution_text(name: str) -> str:
    path = ROOT / "solutions" / name
    return (path if path.exists() else path.with_name(name + ".blank")).read_text(encoding="utf-8")


def regions(text: str) -> list:
    """The regions of a solution, in order. Raises ValueError where a marker has lost its partners."""
    found = [Region(**match.groupdict()) for match in _REGION.finditer(text)]
    for marker in ("// BEGIN ", "// BLANK", "// END "):
        if text.count(marker) != len(found):
            raise ValueError(f"{text.count(marker)} × '{marker}', but {len(found)} whole regions")
    return found


def fill(text: str, content) -> str:
    """The solution with each region replaced by content(region)."""
    return _REGION.sub(lambda match: content(Region(**match.groupdict())), text)


_FUNCTION = re.compile(r"^(?P<head>(?!namespace|//|#)\S(?:[^\n]*[^\n;{]\n)*?[^\n]*\{\n)(?P<body>.*?)^\}\n", re.MULTILINE | re.DOTALL)
_TASK = re.compile(r'(throw HomeworkMissing\("(\S+) ([^"]*)"\);\n)')
_FORMULA_ABOVE = re.compile(r"(?m)^(?P<heading>// (?:---- )?Stage [\w.]+)(?=:[^\n]*=)[^\n]*|^(?://\n)?// [^\n]*\|[^\n]*\n")


def emptied(text: str) -> str:
    """The skeleton of the second depth at the third: no function with a blank keeps a line, nor a formula above it."""
    def only_tasks(function) -> str:
        tasks = [f"  // TODO:: home work {todo}. {place}.\n  {throw}" for throw, todo, place in _TASK.findall(function["body"])]
        return function["head"] + "\n".join(tasks) + "}\n" if tasks else function[0]
    return _FORMULA_ABOVE.sub(r"\g<heading>", _FUNCTION.sub(only_tasks, text))


def blanked(text: str) -> str:
    """The text with its markers, whose skeletons are the same at both depths, and without the solutions of the first."""
    return re.sub(r"(// BEGIN SOLUTION [^\n]+\n).*?(^ *// BLANK\n)", r"\1\2", text, flags=re.MULTILINE | re.DOTALL)


def todos_of(stage: dict) -> list:
    """Those of both depths."""
    return stage["todos"] + stage.get("deep", [])


def stage_of(todo: str) -> dict:
    """The stage that a TODO belongs to."""
    return next(stage for stage in STAGES if todo in todos_of(stage))
