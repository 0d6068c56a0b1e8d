"""What students read, by id and in their language: sentences are made here, where they are printed, and nowhere before.

en.json and zh.json hold {topic: {name: sentence}}; a sentence's id is topic.name, and {words} in braces are placeholders.
Until it is printed, a message is data: {"id": id, word: value, …}, a plain string that is the same in every
language, or {"quoted": words} of a compiler, the library or the skeleton, which zh.json's topic "quoted" translates by their English.
"""

import json
import os
import re
import shutil
import unicodedata
import zlib
from functools import lru_cache
from pathlib import Path

LANGUAGES = ("en", "zh")
PLACEHOLDER = re.compile(r"\{(\w+)\}")
NUMBER = r"-?(?:\d[\d.e+-]*|inf|nan)"


def sentence(name: str, /, **arguments) -> dict:
    """What is said, as data; the arguments may be such data, strings and numbers."""
    return {"id": name, **arguments}


def spoken() -> str:
    """The language of the terminal."""
    locale = next((os.environ[name] for name in ("LC_ALL", "LC_MESSAGES", "LANG") if os.environ.get(name)), "")
    return "zh" if locale.startswith("zh") else "en"


@lru_cache
def speaker(language: str) -> "Speaker":
    return Speaker(language)


def store(language: str) -> dict:
    """The sentences of a language; the students' archive has them packed, so that a search does not find causes before a check does."""
    path = Path(__file__).parent / f"{language}.json"
    if path.exists():
        return json.loads(path.read_text(encoding="utf-8"))
    return json.loads(zlib.decompress(path.with_suffix(".json.z").read_bytes()))


def pad(text: str, columns: int) -> str:
    """Filled with blanks to so many columns of a terminal, of which a Chinese letter takes two."""
    return text + " " * (columns - width(text))


def width(text: str) -> int:
    """In columns of a terminal."""
    return sum(2 if unicodedata.east_asian_width(letter) in "WF" else 1 for letter in text)


def fold(text: str, columns: int) -> str:
    """Sentences that are too long for a terminal go on below, and no word is cut; rows of numbers stay as they are."""
    return "\n".join(fold_line(line, columns) for line in text.splitlines())


def fitted(text: str, out) -> str:
    """For a terminal of this width; in a pipe the lines stay as they are."""
    return fold(text, shutil.get_terminal_size().columns) if out.isatty() else text


def fold_line(line: str, columns: int) -> str:
    head = re.match(r"\s*(?:\S+(?: \S+){0,3}\s{2,})?", line)[0]  # the part before a sentence, such as a label
    if width(line) <= columns or "  " in line[len(head):] or width(head) > columns // 2:
        return line
    lines, room = [head], columns
    for word in re.findall(r"\s*(?:[\u2e80-\u9fff\uff00-\uffef][，。；：、！？）”]*|[^\s\u2e80-\u9fff\uff00-\uffef]+[，。；：、！？）”]*)", line[len(head):]):
        if width(lines[-1] + word) > room and lines[-1].strip():
            lines.append(" " * width(head) + word.lstrip())
        else:
            lines[-1] += word
    return "\n".join(lines)


def aligned(rows: list, columns: float) -> str:
    """Rows of cells, the first to the left and the others to the right; the last columns only as far as there is room."""
    widths = [max(map(width, column)) for column in zip(*rows)]
    while len(widths) > 1 and sum(widths) + 2 * (len(widths) - 1) > columns:
        widths.pop()
    return "\n".join("  ".join([pad(row[0], widths[0]), *(" " * (wide - width(cell)) + cell for cell, wide in zip(row[1:], widths[1:]))]).rstrip()
                     for row in rows)


class Speaker:
    """say("topic.name", word=value, …) and say.text(data) are sentences in a language."""

    def __init__(self, language: str):
        self.language = language
        topics = store(language)
        quoted = topics.pop("quoted", {})
        self.sentences = {f"{topic}.{name}": text for topic, texts in topics.items() for name, text in texts.items()}
        # A template with more fixed words fits better.
        self.quoted = [(pattern_of(words), quoted[words])
                       for words in sorted(quoted, key=lambda words: len(PLACEHOLDER.sub("", words)), reverse=True)]

    def __call__(self, name: str, /, **arguments) -> str:
        return self.sentences[name].format(**{key: self.text(value) for key, value in arguments.items()})

    def text(self, text) -> str:
        if not isinstance(text, dict):
            return str(text)
        if "quoted" in text:
            return self.translate(text["quoted"])
        return self(text["id"], **{key: value for key, value in text.items() if key != "id"})

    def knows(self, text) -> bool:
        """Whether it has each sentence of something said, perhaps by another version of the course, and what that wants."""
        try:
            self.text(text)
        except KeyError:
            return False
        return True

    def translate(self, words: str) -> str:
        """Words that are not ours, as far as they are known."""
        for pattern, template in self.quoted:
            if found := pattern.fullmatch(words):
                return template.format(**{name: self.translate(value) for name, value in found.groupdict().items()})
        return words


def pattern_of(template: str) -> re.Pattern:
    """What a template fits, with a group for each of its placeholders; a single letter means a number."""
    pieces = PLACEHOLDER.split(template)  # text, name, text, …
    groups = [f"(?P<{name}>{NUMBER if len(name) == 1 else '.*?'})" for name in pieces[1::2]]
    return re.compile("".join(re.escape(text) + group for text, group in zip(pieces[::2], groups + [""])), re.DOTALL)
