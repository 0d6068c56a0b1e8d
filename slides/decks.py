"""Which decks there are."""

from pathlib import Path

from .browser import BuildError


def decks():
    return sorted(Path(__file__).resolve().parent.glob("[0-9]-*.??.md"))


def choose(names):
    """Those whose names begin with one of `names`, all if there is none."""
    stems = [deck.stem for deck in decks()]
    for name in names:
        if not any(stem.startswith(name) for stem in stems):
            raise BuildError(f"there is no deck {name}; there are {', '.join(stems)}")
    return [deck for deck in decks() if not names or deck.stem.startswith(tuple(names))]
