"""What is left of the English where Chinese was asked for."""

import re

from ch5_backend.course.base.language import speaker

CHINESE = speaker("zh")
QUOTED = re.compile(r"`[^`]*`|“[^”]*”|dt dt")
SENTENCE = re.compile(r"(?<![\w./])[A-Z]?[a-z']+[,;:]? [a-z']{2,}(?![\w(./])")  # two plain words, which is no code


def english_in(text: str) -> str:
    """The first line that holds a piece of an English sentence, or ""."""
    return next((line.strip() for line in text.splitlines() if SENTENCE.search(QUOTED.sub("", line))), "")
