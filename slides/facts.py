"""What the modules of facts share: gathering their parts, and reading what is typed in a source of the project."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def gathered(*parts):
    """facts(tables) of a deck, {name: text}: those of all its parts."""
    return lambda tables: {name: text for part in parts for name, text in part(tables).items()}


def typed_in(path, pattern):
    """What the groups of a pattern are in a file of the project: words, or one word for one group."""
    found = re.search(pattern, (ROOT / path).read_text(encoding="utf-8"), re.DOTALL).groups()
    return found if len(found) > 1 else found[0]
