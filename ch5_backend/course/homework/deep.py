"""./course deep: the homework at its second depth."""

from ..base.build import HOMEWORK
from ..base.language import speaker
from .make_skeleton import write
from .regions import FILES


def deepen(on: bool, language: str) -> int:
    """Writes each file of the homework at the depth asked for, unless a student has begun it; 1 if there is such a file."""
    say = speaker(language)
    HOMEWORK.mkdir(parents=True, exist_ok=True)
    written = [write(name, HOMEWORK, None, on, True, say) for name in FILES]
    if all(written):
        print(say("skeleton.second_depth" if on else "skeleton.first_depth"))
    return 0 if all(written) else 1
