"""What students read, in their language: made in English where a check is, translated here where it is printed.

zh/*.json hold {English: Chinese}. {Words} in braces stand for what varies: a single letter for a number, a longer word for
any text, which is translated in its turn if it has an entry. So a number or a name gets through as it is.
"""

import json
import os
import re
import unicodedata
from functools import lru_cache
from pathlib import Path

from ..errors import CourseError

LANGUAGES = ("en", "zh")
PLACEHOLDER = re.compile(r"\{(\w+)\}")
NUMBER = r"-?(?:\d[\d.e+-]*|inf|nan)"
LABELLED = re.compile(r"  (expected|got|cause|read|row \d+|column \d+) +(.*)")  # a line of a story: ch5_homework/judge/narrate.cc
LABEL_WIDTH = 10
SUBJECT = re.compile(r"Stage (\S+): (.*)")  # its first line
OURS = ("Stage ", "Value of: ", "Expected")  # how stories begin, GoogleTest's too; others are a compiler's words


def chosen(word: str) -> str:
    """The value of --language; "" means the terminal's. Raises CourseError."""
    if word and word not in LANGUAGES:
        raise CourseError(f"--language must be {' or '.join(LANGUAGES)}, got '{word}'")
    return word or spoken()


def spoken() -> str:
    """The language of the terminal."""
    locale = next((os.environ[name] for name in ("LC_ALL", "LC_MESSAGES", "LANG") if os.environ.get(name)), "")
    return "zh" if locale.startswith("zh") else "en"


@lru_cache
def speaker(language: str) -> "Speaker":
    return Speaker(language)


def pad(text: str, width: int) -> str:
    """Filled with blanks to so many columns of a terminal, of which a Chinese letter takes two."""
    return text + " " * (width - sum(2 if unicodedata.east_asian_width(letter) in "WF" else 1 for letter in text))


class Speaker:
    """say(text) is the text in a language; English, and what has no entry, stays as it is."""

    def __init__(self, language: str):
        self.language, self.entries = language, {}
        for path in sorted((Path(__file__).parent / language).glob("*.json")):
            self.entries.update(json.loads(path.read_text(encoding="utf-8")))
        templates = [english for english in self.entries if PLACEHOLDER.search(english)]
        # What has more words of its own fits better.
        templates.sort(key=lambda english: len(PLACEHOLDER.sub("", english)), reverse=True)
        self.templates = [(pattern_of(english), self.entries[english]) for english in templates]

    def __call__(self, text: str) -> str:
        if text in self.entries:
            return self.entries[text]
        for pattern, template in self.templates:
            if found := pattern.fullmatch(text):
                return template.format(**{name: self(value) for name, value in found.groupdict().items()})
        return text

    def story(self, story: str) -> str:
        """A story line by line: first what it is about, then labels, each with its text. A compiler's words stay."""
        return "\n".join(map(self.line, story.splitlines())) if self.entries and story.startswith(OURS) else story

    def line(self, line: str) -> str:
        if found := SUBJECT.fullmatch(line):
            return self.entries["Stage {id}: {what}"].format(id=found[1], what=self(found[2]))
        if found := LABELLED.fullmatch(line):
            return "  " + pad(self(found[1]), LABEL_WIDTH) + self(found[2])
        words = line.lstrip()
        return line[:len(line) - len(words)] + self(words)

    def hint(self, hint: str, story: str) -> str:
        """A verdict's one sentence: that of a story is its first line and perhaps the cause, see judge.cause."""
        what = story.partition("\n")[0]
        if not what.startswith("Stage ") or not hint.startswith(what):
            return self(hint)
        cause = hint[len(what):].removeprefix(": ").removesuffix(".")
        template = "{what}: {cause}." if cause else "{what}."
        return self.entries.get(template, template).format(what=self.story(what), cause=self(cause))


def pattern_of(template: str) -> re.Pattern:
    """What a template fits, with a group for each of its placeholders."""
    pieces = PLACEHOLDER.split(template)  # text, name, text, …
    groups = [f"(?P<{name}>{NUMBER if len(name) == 1 else '.*?'})" for name in pieces[1::2]]
    return re.compile("".join(re.escape(text) + group for text, group in zip(pieces[::2], groups + [""])), re.DOTALL)
