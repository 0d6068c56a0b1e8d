"""Sample submissions: the mistakes that have a name, ch5_homework/mistakes/*.mistakes, each with what is said of it; and right
ways to do the homework, tests/homework/samples/*.samples. These lines tell them apart:

    // MISTAKE schur_sign formula.sign_added          a name of its own, and the id of its sentence (base/language)
    //   term: H_pm H_mm⁻¹ H_mp                       what the sentence leaves room for; if it is a sentence too, its id,
    //   it.n: 0                                      and what that leaves room for
    // MISTAKE beyond_H crashes eigen.block_outside   another state than wrong; of its cause at least this is said
    // MISTAKE float_step                             one that is wrong, whatever is said: tests/homework/samples/rules.samples
    // SAMPLE by_ldlt                                 one that is right
    // CHANGE 1.2b ) - tempH => ) + tempH             in the solution of this TODO, or of this stage, one text for another
    // REGION 1.1b                                    the code below stands in this TODO's region
    // STAGE 1.2                                      or in place of the stage's whole function
"""

import re
from dataclasses import dataclass, field
from pathlib import Path

from ..base.language import sentence, speaker
from .regions import FILES, ROOT, STAGES, fill, regions, solution_text, stage_of

MISTAKES = ROOT / "ch5_homework" / "mistakes"
OTHER_STATES = ("crashes", "times-out")
MARKER = re.compile(r"// (MISTAKE|SAMPLE|CHANGE|REGION|STAGE) (\S+) ?(.*)$")
ARGUMENT = re.compile(r"//   (?:(\w+)\.)?(\w+): (.*)$")


@dataclass
class Sample:
    name: str
    state: str = "right"
    cause: dict = field(default_factory=dict)  # what is said of it, as data
    code: dict = field(default_factory=dict)   # "REGION 1.1b" or "STAGE 1.2" → text
    todo: str = ""                             # the first TODO in which it differs, "" if it is a whole function

    @property
    def stages(self) -> list:
        """The stages of whose code it changes something; one that is wrong changes one."""
        places = {key.split()[1] for key in self.code}
        return [stage for stage in STAGES if places & {stage["id"], *stage["todos"], *stage.get("deep", [])}]

    def verdict(self, stage: dict) -> tuple:
        return (self.state, self.cause) if stage in self.stages else ("right", {})


def read_mistakes() -> list:
    found = [one for path in sorted(MISTAKES.glob("*.mistakes")) for one in read_samples(path)]
    if unsaid := [one.name for one in found if one.state == "wrong" and not one.cause]:
        raise ValueError(f"{MISTAKES}: which sentence is said of {', '.join(unsaid)}?")
    return found


def read_samples(path: Path) -> list:
    """The samples of a file; raises ValueError with the line that cannot be read."""
    samples, key = [], ""
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(keepends=True), 1):
        try:
            key = read_line(line, samples, key)
        except ValueError as error:
            raise ValueError(f"{path}:{number}: {error}") from error
    return samples


def read_line(line: str, samples: list, key: str) -> str:
    """Adds a line to the last sample, or begins one; returns the key of the code that goes on below, "" if none does."""
    marker, argument = MARKER.match(line), ARGUMENT.match(line)
    if argument and samples and not samples[-1].code:
        of, name, value = argument.groups()
        (samples[-1].cause[of] if of else samples[-1].cause)[name] = said(value)
        return ""
    if not marker:
        if key:
            samples[-1].code[key] += line
        elif line.strip() and not line.startswith("//"):
            raise ValueError(f"code outside of a region: {line.strip()}")
        return key
    kind, name, rest = marker.groups()
    if kind in ("MISTAKE", "SAMPLE"):
        samples.append(Sample(name, *verdict_of(rest)) if kind == "MISTAKE" else Sample(name))
        return ""
    one = samples[-1]
    one.todo = one.todo or (name if not one.code and kind != "STAGE" else "")
    if kind == "CHANGE":
        old, new = re.fullmatch(r"(.*?) =>(?: (.*))?", rest).groups(default="")
        change(one.code, name, old, new)
        return ""
    if kind == "REGION" and f"STAGE {stage_of(name)['id']}" in one.code:
        raise ValueError("a region of a stage that has a text of its own")
    one.code[f"{kind} {name}"] = ""
    return f"{kind} {name}"


def verdict_of(words: str) -> tuple:
    """(state, cause) of what stands behind a mistake's name."""
    state, _, name = words.partition(" ") if words.startswith(OTHER_STATES) else ("wrong", "", words)
    if not name:  # whatever ends the program, or is said
        return state, {}
    if name not in speaker("en").sentences:
        raise ValueError(f"there is no such sentence: {name}")
    return state, sentence(name)


def said(value: str):
    """A sentence's id is that sentence, anything else a word of the code."""
    return sentence(value) if value in speaker("en").sentences else value


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
        raise ValueError(f"the solution of {place} has this {text.count(old)} times, not once: {old}")
    code[key] = text.replace(old, new)


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
