"""Progress on standard error: a living line on a terminal; in a pipe or a log file a line every ten seconds at most."""

import re
import shutil
import sys
import time
from collections import deque

from .language import speaker

QUIET_SECONDS = 10.0   # between two lines in a pipe
LIGHT_STEP = 0.1       # of a link or a copy, in units of a file that is compiled
RECENT = 10            # files that show the pace: earlier ones were in ccache
FIRST_GUESS = 3.0      # seconds of compiling before the first guess of the time left


class Progress:
    """One phase of work, such as "build", of perhaps `expected` seconds. Use as a context; call step() as often as you like."""
    say = speaker("en")  # the command's language

    def __init__(self, phase: str, out=None, clock=time.monotonic, expected=0.0):
        self.phase, self.out, self.clock = self.say.translate(phase), out or sys.stderr, clock
        self.start = self.told = clock()
        self.alive = self.out.isatty()
        self.done = 0.0  # work so far, in units of a compiled file, or in expected seconds
        self.recent = deque([(0.0, 0.0)], RECENT)  # seconds and work at the last steps
        self.expected, self.pace = expected, 1.0  # the pace: true seconds to an expected one

    def __enter__(self):
        self.step("…")
        return self

    def step(self, text: str, in_pipes: bool = False) -> None:
        """Replaces the living line. In a pipe it says nothing, or at most a line every ten seconds."""
        text = self.say.translate(text)
        if self.alive:
            width = shutil.get_terminal_size().columns - 1
            self.out.write("\r\033[K" + f"{self.phase}: {text}"[:width])
            self.out.flush()
        elif in_pipes and self.clock() - self.told >= QUIET_SECONDS:
            self.told = self.clock()
            print(f"{self.phase}: {text}", file=self.out, flush=True)

    def ninja_step(self, line: str) -> None:
        """A line of ninja's, "[done/all] what": adds how long the rest may take, at the pace of the last ones."""
        counted = re.match(r"\[(\d+)/(\d+)\] (.*)", line)
        if not counted or counted[1] == "0":  # the build tool's messages, and a look for new files
            return self.step("…")
        number, total, what = int(counted[1]), int(counted[2]), counted[3]
        self.done += 1.0 if what.startswith("Building") else LIGHT_STEP
        left = (total - number) * self.done / number  # the files to come are taken to be like those done
        seconds = self.clock() - self.start
        seconds_then, done_then = self.recent[0]
        self.recent.append((seconds, self.done))
        pace = (seconds - seconds_then) / (self.done - done_then)
        guess = f", about {duration(pace * left)} left" if seconds > FIRST_GUESS and left else ""
        name = re.sub(r"^.*CMakeFiles/|\.o$", "", what.split()[-1]) if what.startswith("Building") else what
        self.step(f"{number} of {total}{guess}: {name}", in_pipes=True)

    def expected_step(self, text: str) -> None:
        """Adds how long the rest of `expected` may take, at the pace until now."""
        left = self.pace * self.expected - (self.clock() - self.start)
        self.step(f"about {duration(left)} left: {text}", in_pipes=True)

    def finished(self, seconds: float) -> None:
        self.done += seconds  # that it was expected to take
        self.pace = (self.clock() - self.start) / self.done

    def __exit__(self, kind, value, trace):
        self.out.write("\r\033[K" if self.alive else "")
        seconds = self.clock() - self.start
        if kind is None and seconds >= 1.0:
            print(f"{self.phase}: {seconds:.1f} s", file=self.out)
        self.out.flush()


def duration(seconds: float) -> str:
    """"40 s", "3 min"."""
    return f"{max(1, round(seconds / 10)) * 10} s" if seconds < 95 else f"{round(seconds / 60)} min"
