"""What the compiler and the linker say of a student's file, in a student's words."""

import os
import re
from pathlib import Path

from ..base.build import HOMEWORK, ROOT
from .judge import SHOWN_LINES, Verdict

# The compiler's words on braces. A function that begins inside of another, or a file that ends inside of one:
OPEN_BRACE = r"qualified-id in declaration before|function-definition is not allowed here|function definition is not " \
             r"allowed here|expected ['‘]}['’] at end of input|expected '}'"
SPARE_BRACE = r"expected declaration before ['‘]}['’]|extraneous closing brace"
UNDEFINED = r"undefined (?:reference to|symbol:) [`'‘]?(?:ch5::)?((?!vtable|typeinfo)[\w:]+)\("


def shown(path: Path) -> str:
    """A path as a reader finds it: from the project's folder, else from where the reader stands, else whole."""
    for folder in (ROOT, Path.cwd()):
        if path.is_relative_to(folder):
            return str(path.relative_to(folder))
    return str(path)


def anew(file: str) -> str:
    """The command that begins a file anew, in the folder that is judged."""
    elsewhere = "" if HOMEWORK == ROOT / "ch5_homework" else f" --output {shown(HOMEWORK)}"
    return f"python3 -m ch5_backend.course.homework.make_skeleton {file}{elsewhere}"


def shorten(line: str) -> str:
    """Without the project's folder, in which everything lies."""
    line = line.replace(str(HOMEWORK) + os.sep, shown(HOMEWORK) + os.sep)
    return line.replace(str(ROOT) + os.sep, "").strip("\n")


def does_not_compile(file: str, output: str, content) -> Verdict:
    """The verdict on `file`, which holds these bytes (None: there is no such file), from all that the build has printed."""
    lines = [line for line in output.splitlines() if not line.startswith("ninja: build stopped")]
    patterns = [rf"{re.escape(file)}:\d+:(\d+:)? (fatal )?error: ", r"\d: (fatal )?error: ", "multiple definition|undefined reference", "error: ",
                "FAILED|ninja: "]
    first = next((i for pattern in patterns for i, line in enumerate(lines) if re.search(pattern, line)), 0)
    told = lines[first:first + SHOWN_LINES]
    hint = of_the_file(file, content) or of_the_linker(file, output, content)
    if not hint and lines:
        calling = where_called(file, lines, first) if not re.search(patterns[0], lines[first]) else ""
        hint = (f"{calling}: " + re.sub(r"^.*?error: ", "", lines[first]) if calling else
                of_braces(file, lines) or lines[first])
    story = "\n".join(shorten(line) for line in told)
    return Verdict("does-not-compile", shorten(hint or "the compiler said nothing"), story)


def of_the_file(file: str, content) -> str:
    """What is wrong with the file as a whole, or ""."""
    if content is None:
        return f"{file} is missing; {anew(file)} writes it anew."
    if b"\0" in content[:200] or content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return f"{file} is saved as UTF-16, which compilers do not read; save it as UTF-8."
    return "" if content.strip() else f"{file} is empty; {anew(file)} writes it anew."


def of_the_linker(file: str, output: str, content: bytes) -> str:
    """Which function is there twice, or not at all, or ""."""
    if "multiple definition of `main'" in output:
        return f"{file} has a main of its own; remove it, the check brings one."
    missing = re.search(UNDEFINED, output)
    if not missing or re.search(r":\d+: (fatal )?error: ", output):
        return ""
    name = missing[1]
    if re.search(rf"\b{re.escape(name)}\(", content.decode("utf-8", "replace")):
        return f"the function {name} in {file} is not the skeleton's: its arguments, its class or a const have changed."
    return f"the function {name} is missing in {file}; it was there in the skeleton, which {anew(file)} writes anew."


def where_called(file: str, lines: list, error: int) -> str:
    """The line of the student's file from which a library's own code was asked for, when the error stands there: GCC tells
    it above the error, Clang below."""
    words = rf"({re.escape(file)}:\d+:\d+): (?: *required from here|note: in instantiation of .* requested here)"
    for line in (*reversed(lines[:error]), *lines[error:]):
        if found := re.search(words, line):
            return found[1]
    return ""


def of_braces(file: str, lines: list) -> str:
    """A brace that is missing or too many, with the line where it shows, or ""."""
    for line in lines:
        found = re.search(rf"({re.escape(file)}:(\d+)):\d+: error: (.*)", line)
        if found and re.search(OPEN_BRACE, found[3]):
            return f"{found[1]}: a closing brace is missing above line {found[2]}: what begins there is inside of what was before."
        if found and re.search(SPARE_BRACE, found[3]):
            return f"{found[1]}: one closing brace too many above line {found[2]}, or an opening one is missing."
        if found:
            return ""
    return ""
