#!/usr/bin/env python3
"""Sample submissions as C++: `samples.py FOLDER FILE…` writes those of mistakes/*.mistakes and samples/*.samples, and every single
blank TODO. A translation unit for each stage compiles its templates once: each sample in a namespace of its own holds only
the functions that it changes, in classes derived from the reference's; so hundreds of them share one executable. Those that are
judged by night alone are in units of their own.
"""

import re
import sys
from pathlib import Path

from ch5_backend.course.base.language import sentence
from ch5_backend.course.homework.regions import FILES, STAGE_TABLE, regions, solution_text, stage_of
from ch5_backend.course.homework.samples import Sample, filled, read_mistakes, read_samples, sections

RIGHT = Path(__file__).parent / "samples"
CHECKS = STAGE_TABLE.parent / "judge" / "checks"

# Judged by day in any case: other tests ask for them.
ASKED_FOR = {"schur_sign", "schur_never_written"}

# Whose functions students write, the others being free.
CLASSES = ("Problem", "MarginalizationError", "MarginalizationInfo", "PlainBlockSolver")


def all_samples() -> list:
    """The mistakes, then what is right."""
    return read_mistakes() + [one for path in sorted(RIGHT.glob("*.samples")) for one in read_samples(path)]


def by_day(samples: list) -> list:
    """Those of a file that are judged by day: every third."""
    return [one for k, one in enumerate(samples) if k % 3 == 0 or one.name in ASKED_FOR]


def blank_samples() -> list:
    """One sample for each TODO that is left blank."""
    blanks = []
    for region in (region for name in FILES for region in regions(solution_text(name))):
        blanks.append(Sample("blank_" + region.todo.replace(".", "_"), "not-started", sentence("judge.not_started", todo=region.todo),
                             {f"REGION {region.todo}": region.blank()}, region.todo))
    return blanks


def functions(section: str) -> tuple:
    """A section's helpers, with their nameless namespace, and its functions one by one."""
    helpers, end, rest = section.rpartition("}  // namespace\n")
    return helpers + end, re.findall(r".*?^\}\n", rest, re.MULTILINE | re.DOTALL)


def places(text: str) -> set:
    """Under which keys a sample has code for this part of a solution."""
    todos = [region.todo for region in regions(text)]
    return {f"STAGE {stage_of(todo)['id']}" for todo in todos} | {f"REGION {todo}" for todo in todos}


def code_of(one: Sample) -> str:
    """The text of the changed functions; a function without a region of its own changes with the helpers."""
    text, changed = "", one.code.keys()
    for section in (section for name in FILES for section in sections(solution_text(name))):
        if places(section) & changed:
            helpers, parts = functions(section)
            text += filled(helpers + "".join(part for part in parts if (places(part) or places(helpers)) & changed), one.code)
    if unused := changed - set().union(*(places(solution_text(name)) for name in FILES)):
        raise ValueError(f"sample {one.name}: no such region: {', '.join(sorted(unused))}")
    return text


def derived_class(name: str, text: str) -> str:
    """A class of the same name as the reference's, with the functions that the text defines its own; without any the name
    means the reference's, whose templates all samples share."""
    functions = re.findall(rf"^(\S+) {name}::((\w+)\([^)]*\)(?: const)?)\s*\{{", text, re.MULTILINE)
    if not functions:
        return ""
    members = "\n  ".join(f"static {returned} {signature};" if function == "TestMarginalize" else f"{returned} {signature} override;"
                          for returned, signature, function in functions)
    return f"class {name} : public ch5::{name} {{\n public:\n  using ch5::{name}::{name};\n  {members}\n}};"


def linked_functions(name: str) -> list:
    """[("open_tasks", "{&UpdateDamping, …}")]: which functions of a file its checks call."""
    return re.findall(r"Linked\(\)->(\w+) = (.*?),\s+(?=Linked|AddChecks)", (CHECKS / name).read_text(encoding="utf-8"), re.DOTALL)


def translation_unit(samples: list) -> str:
    includes = sorted({line for name in FILES for line in re.findall(r"^#include .*$", solution_text(name), re.MULTILINE)})
    linked = "\n  ".join(f"own.{member} = {functions};" for name in FILES for member, functions in linked_functions(name))
    parts = ["// Written by tests/homework/samples.py.", *includes, '#include "ch5_homework/judge/submission.h"']
    for one in samples:
        text = code_of(one)
        classes = "\n".join(derived_class(name, text) for name in CLASSES)
        parts.append(f"""
namespace ch5::sample_{one.name} {{
{classes}
{text}
[[maybe_unused]] const bool registered = homework::Register("{one.name}", [] {{
  using homework::Make;
  homework::Submission own;
  {linked}
  return own;
}}());
}}  // namespace ch5::sample_{one.name}""")
    return "\n".join(parts) + "\n"


def main(folder: str, paths: list) -> None:
    corpus = {}
    for path in map(Path, paths):
        samples = read_samples(path)
        day = by_day(samples)
        corpus.setdefault(f"samples_{path.stem}", []).extend(day)
        corpus.setdefault(f"samples_by_night_{path.stem}", []).extend(one for one in samples if one not in day)
    for blank in blank_samples():
        corpus[f"samples_stage_{blank.stages[0]['id'].replace('.', '_')}"].append(blank)
    samples = [one for part in corpus.values() for one in part]
    names = [one.name for one in samples]
    if len(set(names)) < len(names):
        raise ValueError("two samples of one name: " + ", ".join(sorted({name for name in names if names.count(name) > 1})))
    for name, part in corpus.items():
        output, text = Path(folder, f"{name}.cc"), translation_unit(part)
        if not output.exists() or output.read_text(encoding="utf-8") != text:  # what is unchanged need not be compiled
            output.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
