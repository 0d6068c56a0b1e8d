"""./course deep: the homework at its second depth."""

import subprocess
import sys

from .build import HOMEWORK, ROOT


def deepen(on: bool) -> int:
    """Writes each file of the homework at the depth asked for, unless a student has begun it; 1 if there is such a file."""
    command = [sys.executable, str(ROOT / "tests" / "homework" / "make_skeleton.py"), "--keep", "--output", str(HOMEWORK)]
    done = subprocess.run(command + ["--deep"] * on, check=False)
    if done.returncode == 0:
        print("All files are at the " + ("second depth; back: ./course deep --off" if on else "first depth."))
    return done.returncode
