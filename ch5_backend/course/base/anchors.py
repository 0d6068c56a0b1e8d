"""Where a link into a Markdown file leads."""

import re


def anchor(words: str) -> str:
    """What GitHub makes of a heading."""
    return re.sub(r"[^\w\- ]", "", words.lower()).replace(" ", "-")
