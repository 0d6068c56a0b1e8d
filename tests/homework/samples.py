#!/usr/bin/env python3
"""Sample submissions: right and wrong ways to do the homework, each with the verdict that it must get.

samples/*.samples hold them, told apart by these lines:

    // SAMPLE name                                    one that is right
    // SAMPLE name wrong assembly.mirror_missing           or the verdict on its stage: its state, ids and values of its cause
    // CHANGE 1.2b - tempH => + tempH                 in the solution of this TODO, or of this stage, one text for another
    // REGION 1.1b                                    the code below stands in this TODO's region
    // STAGE 1.2                                      or in place of the stage's whole function

Every single blank TODO is a sample too. `samples.py FOLDER FILE.samples…` writes them as C++, a translation unit for each
file, which holds the blanks of its stage too and so compiles their templates once: each sample in a namespace of its own
holds only the functions that it changes, in classes derived from the reference's; so hundreds of them share one executable.
"""

import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

from ch5_backend.course.homework.regions import FILES, STAGES, fill, regions, solution_text, stage_of

# Whose functions students write, the others being free.
CLASSES = ("Problem", "MarginalizationError", "MarginalizationInfo", "PlainBlockSolver")


@dataclass
class Sample:
    name: str
    state: str = "right"
    cause: str = ""                           # ids and values
    code: dict = field(default_factory=dict)  # "REGION 1.1b" or "STAGE 1.2" → text

    @property
    def stages(self) -> list:
        """The stages of whose code it changes something; one that is wrong changes one."""
        places = {key.split()[1] for key in self.code}
        return [stage for stage in STAGES if places & {stage["id"], *stage["todos"], *stage.get("deep", [])}]

    def verdict(self, stage: dict) -> tuple:
        return (self.state, self.cause) if stage in self.stages else ("right", "")


def present(code: dict, place: str) -> tuple:
    """The key of a TODO or of a stage, and the text there: so far the sample's, otherwise the solution's. Once a stage has
    a text of its own, its TODOs are a part of that."""
    for section in (section for name in FILES for section in sections(solution_text(name))):
        found = {region.todo: region.solution for region in regions(section)}
        stage = stage_of(next(iter(found)))["id"]
        if place in found and f"STAGE {stage}" not in code:
            return f"REGION {place}", code.get(f"REGION {place}", found[place])
        if place in found or place == stage:
            return f"STAGE {stage}", filled(section, code)
    raise ValueError(f"no such region: {place}")


def change(code: dict, place: str, old: str, new: str) -> None:
    """One text for another, which must be there once."""
    key, text = present(code, place)
    if text.count(old) != 1:
        raise ValueError(f"{place}: {text.count(old)} × {old}")
    code[key] = text.replace(old, new)


def read_samples(path: Path) -> list:
    """The samples of a file; raises ValueError with the line that cannot be read."""
    samples, key = [], ""
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(keepends=True), 1):
        marker = re.match(r"// (SAMPLE|CHANGE|REGION|STAGE) (\S+) ?(.*)$", line)
        if marker:
            key = ""
        if not marker:
            if key:
                samples[-1].code[key] += line
            elif line.strip() and not line.startswith("//"):
                raise ValueError(f"{path}:{number}: code outside of a region")
        elif marker[1] == "SAMPLE":
            state, _, cause = marker[3].partition(" ")
            samples.append(Sample(marker[2], state or "right", cause))
        elif marker[1] == "CHANGE":
            old, new = re.fullmatch(r"(.*?) =>(?: (.*))?", marker[3]).groups(default="")
            change(samples[-1].code, marker[2], old, new)
        else:
            key = f"{marker[1]} {marker[2]}"
            if marker[1] == "REGION" and f"STAGE {stage_of(marker[2])['id']}" in samples[-1].code:
                raise ValueError(f"{path}:{number}: a region of a stage that has a text of its own")
            samples[-1].code[key] = ""
    return samples


def blank_samples() -> list:
    """One sample for each TODO that is left blank."""
    blanks = []
    for region in (region for name in FILES for region in regions(solution_text(name))):
        blanks.append(Sample("blank_" + region.todo.replace(".", "_"), "not-started", f"judge.not_started {region.todo}",
                             {f"REGION {region.todo}": region.blank()}))
    return blanks


def sections(text: str) -> list:
    """The functions of a solution: what stands in its namespace, parted at the lines `// ---- …`."""
    body = re.search(r"^namespace ch5 \{\n(.*)^\}  // namespace ch5$", text, re.MULTILINE | re.DOTALL)[1]
    return [part for part in re.split(r"^(?=// ---- )", body, flags=re.MULTILINE) if regions(part)]


def filled(section: str, code: dict) -> str:
    """A function, with this code in its place or in its regions."""
    return code.get(f"STAGE {stage_of(regions(section)[0].todo)['id']}") or fill(
        section, lambda region: code.get(f"REGION {region.todo}", region.solution))


def source(file: str, code: dict = {}) -> str:
    """A file of the homework: the solution, but for this code."""
    text = solution_text(file)
    for section in sections(text):
        text = text.replace(section, filled(section, code))
    return text


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


def translation_unit(samples: list) -> str:
    includes = sorted({line for name in FILES for line in re.findall(r"^#include .*$", solution_text(name), re.MULTILINE)})
    parts = ["// Written by tests/homework/samples.py.", *includes, '#include "ch5_homework/judge/submission.h"']
    for one in samples:
        text = code_of(one)
        classes = "\n".join(derived_class(name, text) for name in CLASSES)
        parts.append(f"""
namespace ch5::sample_{one.name} {{
{classes}
{text}
[[maybe_unused]] const bool registered = homework::Register(
    "{one.name}", {{&homework::Make<ch5::Problem, Problem>, &Problem::TestMarginalize, &AddMonoBaEdges,
                   {{&GaugeNullSpace, &GaugeProjection, &GaugeMotionJacobian, &TransformCovariance}},
                   &homework::Make<ch5::MarginalizationError, MarginalizationError>,
                   &homework::Make<ch5::MarginalizationInfo, MarginalizationInfo>,
                   {{&DropSetOfMarginOld, &DropSetOfMarginSecondNew, &SlideWindow, &DetectFailure}},
                   &homework::Make<ch5::PlainBlockSolver, PlainBlockSolver>,
                   {{&UpdateDamping, &LinearizeProjection, &IntegrateImu, &LinearizeRange}}}});
}}  // namespace ch5::sample_{one.name}""")
    return "\n".join(parts) + "\n"


def main(folder: str, paths: list) -> None:
    corpus = {Path(path).stem: read_samples(Path(path)) for path in paths}
    for blank in blank_samples():
        corpus[f"stage_{blank.stages[0]['id'].replace('.', '_')}"].append(blank)
    samples = [one for part in corpus.values() for one in part]
    names = [one.name for one in samples]
    if len(set(names)) < len(names):
        raise ValueError("two samples of one name: " + ", ".join(sorted({name for name in names if names.count(name) > 1})))
    for name, part in corpus.items():
        output, text = Path(folder, f"samples_{name}.cc"), translation_unit(part)
        if not output.exists() or output.read_text(encoding="utf-8") != text:  # what is unchanged need not be compiled
            output.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
