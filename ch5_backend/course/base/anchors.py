"""Where a link into a deck of slides leads: its page, by the heading that GitHub's anchor names."""

import re


def anchor(words: str) -> str:
    """What GitHub makes of a heading."""
    return re.sub(r"[^\w\- ]", "", words.lower()).replace(" ", "-")


def page_of(deck: str, fragment: str) -> int:
    """The number of the page of this deck's Markdown whose heading has the anchor; the first without one. Raises ValueError."""
    pages = re.split(r"^---$", deck, flags=re.MULTILINE)[2:]  # the part before is the head of the file
    for number, page in enumerate(pages, 1):
        if not fragment or any(anchor(words) == fragment for words in re.findall(r"^#+ (.*)$", page, re.MULTILINE)):
            return number
    raise ValueError(f"no page of the deck is called #{fragment}")
