#!/usr/bin/python3
"""What Doxygen reads in place of a file: filter.py FILE prints it, each line where the original has it.

Of a header, the comment at its head describes the file, and its main class unless that has a comment of its own.
Its formulas are written in Unicode, to be read in an editor, and become TeX here: formulas.py. Drawings stay as they are.
In a page, $formulas$ become Doxygen's, and the index of formulas leads to the functions.
"""

import re
import sys
from pathlib import Path

from ch5_backend.course.documents.formulas import set_block, set_line

BACKEND = Path(__file__).resolve().parents[2]
HEADERS = sorted(BACKEND.rglob("*.h"))
CLASS = re.compile(r"^(?!\s*///)(.*)\n(?=(?:template .*\n)?(?:class|struct) (\w+)[^;]*$)", re.M)
INDEX_ROW = re.compile(r"^(\|.*\| )`([\w/]+\.(?:h|cc))` \| (.*)$", re.M)
INDENTED = re.compile(r"(?:^ *///(?:   +.*)?\n)*^ *///   (?!       ).*\n", re.M)  # a block; continued words are further right
PROSE = re.compile(r"^( */// |.*///< )(?! )(.*)$", re.M)


def header(text: str, path: Path) -> str:
    name = path.relative_to(BACKEND)
    text = re.sub(r"^#pragma once$", f"/// @file {name}", text, count=1, flags=re.M)
    bare = list(CLASS.finditer(text))
    main = next((match for match in bare if match[2].lower() == path.stem.replace("_", "")), bare[0] if bare else None)
    if main:
        text = f"{text[:main.end()]}/** @copydoc {name} */ {text[main.end():]}"
    return PROSE.sub(lambda match: match[1] + set_line(match[2]), INDENTED.sub(lambda block: set_block(block[0]), text))


def page(text: str) -> str:
    text = re.sub(r"\$([^$\n]+)\$", r"\\f$\1\\f$", text)
    text = re.sub(r"\[([^]]+)\]\((?:\.\./)+[^)]*\)", r"\1", text)  # what lies outside has no page
    text = text.replace("](sparse/README.md)", "](@ref sparse/README.md)")
    return INDEX_ROW.sub(lambda row: row[1] + file_link(row[2]) + " | " +
                         re.sub(r"`([\w:]+)`", lambda name: function_link(name[1], row[2]), row[3]), text)


def file_link(file: str) -> str:
    """To the header that declares what the file defines."""
    declared = Path(file).with_suffix(".h")
    return f"[{file}](@ref {declared})" if (BACKEND / declared).exists() else f"`{file}`"


def function_link(name: str, file: str) -> str:
    """Of what is private, or local to a file, there is no page."""
    beside = (BACKEND / file).with_suffix(".h")
    last = name.rpartition("::")[2]
    declared = re.search(rf"(?:class|struct) {last}\b|\b{last}[<(]", public_text(*([beside] if beside.exists() else HEADERS)))
    return f"[{name}](@ref ch5::{name})" if declared else f"`{name}`"


def public_text(*headers) -> str:
    text = "".join(path.read_text(encoding="utf-8") for path in headers)
    return re.sub(r"^ private:.*?^};", "", text, flags=re.M | re.S)


if __name__ == "__main__":
    source = Path(sys.argv[1]).resolve()
    content = source.read_text(encoding="utf-8")
    sys.stdout.write(page(content) if source.suffix == ".md" else header(content, source))
