"""Whose time it was that ran out: the program's, or the machine's.

A wall clock blames the wrong one where a machine is overloaded, or a program is stopped from outside. So a program that runs
longer than a second is looked at four times a second, with all that it has started. What it spends of the processor is its
own time, and so is the time in which it sleeps, as in a deadlock; that in which it would run and may not, or waits for a disk,
is the machine's.
"""

import bisect
import os
import threading
import time
from contextlib import suppress
from pathlib import Path

PERIOD = 0.25  # seconds
TICKS = os.sysconf("SC_CLK_TCK")
ASLEEP = ("S", "I", "Z", "X")  # of the states in /proc/PID/stat; R runs or would, D waits for a disk, T is stopped


class Watch:
    """own(a, b) are the seconds of the program's own time in [a, b], counted from the beginning."""

    def __init__(self, mark: str):
        """`mark` is in the command line of this program and of no other."""
        self.mark = mark.encode()
        self.begin, self.times, self.owns = time.monotonic(), [0.0], [0.0]
        self.ticks = 0
        self.done = threading.Event()
        self.thread = threading.Thread(target=self._look, daemon=True)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.done.set()
        self.thread.join()
        self.end = time.monotonic() - self.begin

    def own(self, first: float = 0.0, last: float = None) -> float:
        """Between and behind the looks as between the last two; a program that was never seen has slept."""
        return self._until(self.end if last is None else last) - self._until(first)

    @property
    def spent(self) -> float:
        """Seconds of the processor, as far as they were seen."""
        return self.ticks / TICKS

    def _until(self, at: float) -> float:
        k = min(bisect.bisect_right(self.times, at), len(self.times) - 1)
        if k == 0:
            return at
        slope = (self.owns[k] - self.owns[k - 1]) / (self.times[k] - self.times[k - 1])
        return self.owns[k - 1] + slope * (at - self.times[k - 1])

    def _look(self) -> None:
        wait, spent = 4 * PERIOD, {}
        while not self.done.wait(wait):
            wait, now = PERIOD, time.monotonic() - self.begin
            tree = processes_of(self.mark)
            before = sum(spent.values())
            spent.update({pid: ticks for pid, (_, ticks) in tree.items()})  # what has ended keeps its own
            self.ticks = sum(spent.values())
            used, passed = (self.ticks - before) / TICKS, now - self.times[-1]
            asleep = all(state in ASLEEP for state, _ in tree.values())
            self.times.append(now)
            self.owns.append(self.owns[-1] + (passed if asleep else min(used, passed)))


def processes_of(mark: bytes) -> dict:
    """{pid: (state, ticks of the processor)} of the processes that are called by the mark, and of all that they have started."""
    parents, states = {}, {}
    for name in os.listdir("/proc"):
        if name.isdigit():
            try:
                fields = Path(f"/proc/{name}/stat").read_text(encoding="latin-1").rpartition(")")[2].split()
            except OSError:  # it has just ended
                continue
            parents[int(name)], states[int(name)] = int(fields[1]), (fields[0], int(fields[11]) + int(fields[12]))
    ours = set()
    for pid in below(os.getpid(), parents):
        with suppress(OSError):
            if mark in Path(f"/proc/{pid}/cmdline").read_bytes():
                ours |= {pid, *below(pid, parents)}
    return {pid: (state_of_threads(pid, states[pid][0]), states[pid][1]) for pid in ours}


def state_of_threads(pid: int, state: str) -> str:
    """That of a thread which does not sleep, if there is one: the first of them may only wait for the others."""
    with suppress(OSError):
        for thread in os.listdir(f"/proc/{pid}/task") if state in ASLEEP else ():
            other = Path(f"/proc/{pid}/task/{thread}/stat").read_text(encoding="latin-1").rpartition(")")[2].split()[0]
            if other not in ASLEEP:
                return other
    return state


def below(root: int, parents: dict) -> set:
    children = {}
    for pid, parent in parents.items():
        children.setdefault(parent, []).append(pid)
    found, open_ones = set(), list(children.get(root, ()))
    while open_ones:
        pid = open_ones.pop()
        found.add(pid)
        open_ones += children.get(pid, ())
    return found
