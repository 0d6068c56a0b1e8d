"""The corpus of hostile submissions: wrong homework of stage 3, which does something else as well.

attacks/*.attacks hold them, each behind a line "// ATTACK name", and around.attacks what stands around them. START is what an
attack does before main, ACT in the graded function; any other code stands in front of that.
"""

import re
from pathlib import Path

FOLDER = Path(__file__).with_name("attacks")
ATTACK = re.compile(r"^// ATTACK (\w+)\n", re.MULTILINE)


def read_attacks(name: str) -> dict:
    """{name: its code}"""
    pieces = ATTACK.split((FOLDER / f"{name}.attacks").read_text(encoding="utf-8"))
    return dict(zip(pieces[1::2], pieces[2::2]))


HEAD, TAIL, DECLARATIONS = read_attacks("around").values()
