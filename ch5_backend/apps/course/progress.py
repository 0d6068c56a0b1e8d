"""Progress on standard error: a living line on a terminal, one plain line per longer phase in a pipe."""

import shutil
import sys
import time


class Progress:
    """One phase of work, such as "build". Use as a context; call step() as often as you like."""

    def __init__(self, phase: str):
        self.phase = phase
        self.start = time.monotonic()
        self.alive = sys.stderr.isatty()

    def __enter__(self):
        self.step("…")
        return self

    def step(self, text: str) -> None:
        """Replaces the living line; says nothing in a pipe."""
        if self.alive:
            width = shutil.get_terminal_size().columns - 1
            sys.stderr.write("\r\033[K" + f"{self.phase}: {text}"[:width])
            sys.stderr.flush()

    def __exit__(self, kind, value, trace):
        if self.alive:
            sys.stderr.write("\r\033[K")
        seconds = time.monotonic() - self.start
        if kind is None and seconds >= 1.0:
            print(f"{self.phase}: {seconds:.1f} s", file=sys.stderr)
        sys.stderr.flush()
