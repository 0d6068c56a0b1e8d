"""The chapter's programs, run for a command."""

import os
import signal
import subprocess
import sys
from pathlib import Path

from ..base import language
from ..base.cmake_build import BIN
from ..base.errors import CourseError
from ..base.processes import running
from .layouts.convert import as_euroc

TRACKER = "ch5_track"


def run_programs(commands: list, as_json: bool) -> None:
    """Runs them one after the other. With --json its standard output goes to standard error, which must stay readable.

    Raises CourseError with the program's exit code and, with --json, its last message.
    """
    for command in commands:
        command = [str(word) for word in command]
        sys.stdout.flush()
        message = "its message is above"
        with running(command, env={**os.environ, "MPLBACKEND": "Agg", "PYTHONUTF8": "1"}, text=True, errors="replace",
                     stdout=sys.stderr if as_json else None, stderr=subprocess.PIPE if as_json else None) as process:
            for line in process.stderr or ():
                sys.stderr.write(line)
                message = line.strip() or message
            code = process.wait()
        check_exit(command, code, message)


def check_exit(command: list, code: int, message: str) -> None:
    """Raises CourseError with the program's exit code, and KeyboardInterrupt if it was stopped by Ctrl-C."""
    if code == -signal.SIGINT:
        raise KeyboardInterrupt
    if code < 0:
        raise CourseError(f"{Path(command[0]).name} was killed by {signal.Signals(-code).name}", 128 - code)
    if code:
        name = next(Path(word).name for word in command if word not in (sys.executable, "-m"))
        raise CourseError(f"{name} failed with exit code {code}; {message}", code)


def tracking(folder: str, out: Path, arguments) -> list:
    """Makes a recording, `out`, of a folder of images, which is first written in EuRoC's layout into out/mav0 if it is in another."""
    return [BIN / TRACKER, as_euroc(folder, out), "--out", out, *(f"--{name}" for name in ("mono", "strict") if getattr(arguments, name, False))]


def figures(kind: str, *words) -> list:
    """Draws with figures/KIND.py."""
    return [sys.executable, "-m", f"ch5_backend.figures.{kind}", *words]


def tell(texts: list, arguments) -> None:
    """Lines in the user's language; with --json, standard output is not their place."""
    for text in texts:
        print(language.speaker(arguments.language).text(text), file=sys.stderr if arguments.json else sys.stdout)
