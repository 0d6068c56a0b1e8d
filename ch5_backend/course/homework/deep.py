"""./course deep: the homework at its second depth."""

import subprocess
import sys

from ..base.build import HOMEWORK
from ..base.language import speaker


def deepen(on: bool, language: str) -> int:
    """Writes each file of the homework at the depth asked for, unless a student has begun it; 1 if there is such a file."""
    command = [sys.executable, "-m", "ch5_backend.course.homework.make_skeleton", "--keep", "--output", str(HOMEWORK)]
    say = speaker(language)
    done = subprocess.run(command + ["--deep"] * on, stdout=subprocess.PIPE, text=True, check=False)
    for line in done.stdout.splitlines():
        print(say(line))
    if done.returncode == 0:
        print(say("All files are at the " + ("second depth; back: ./course deep --off" if on else "first depth.")))
    return done.returncode
