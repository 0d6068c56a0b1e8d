"""What a program in the sandbox takes, with all that it has started: it is looked at ten times a second.

What its processes take together beyond a limit ends them; the system limits each alone. And whose time it was that ran out: a
wall clock blames the wrong one where a machine is overloaded, or a program is stopped from outside. What a program spends of the
processor is its own time, and so is the time in which it sleeps, as in a deadlock; that in which it would run and may not, or
waits for a disk, is the machine's.
"""

import bisect
import os
import signal
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from .confine import USERS

PERIOD = 0.1  # seconds
TICKS = os.sysconf("SC_CLK_TCK")
ASLEEP = ("S", "I", "Z", "X")  # of the states in /proc/PID/stat; R runs or would, D waits for a disk, T is stopped


class Watch:
    """own(a, b) are the seconds of the program's own time in [a, b], counted from the beginning."""

    def __init__(self, mark: str, limits=None, folders=(), clear=lambda: None):
        """`mark` is in the command line of this program and of no other. `folders` are those that it may write into; `clear` is
        called once it has ended. `exceeded` will be the limit, "seconds", "memory" or "scratch", that ended it, or ""."""
        self.mark, self.limits, self.folders, self.clear, self.exceeded = mark.encode(), limits, list(folders), clear, ""
        self.begin, self.times, self.owns = time.monotonic(), [0.0], [0.0]
        self.spent = 0.0  # seconds of the processor, as far as they were seen
        self.done = threading.Event()
        self.thread = threading.Thread(target=self._look, daemon=True)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.done.set()
        self.thread.join()
        self.clear()
        self.end = time.monotonic() - self.begin

    def own(self, first: float = 0.0, last: float = None) -> float:
        """Between and behind the looks as between the last two; a program that was never seen has slept."""
        return self._until(self.end if last is None else last) - self._until(first)

    def _until(self, at: float) -> float:
        k = min(bisect.bisect_right(self.times, at), len(self.times) - 1)
        if k == 0:
            return at
        slope = (self.owns[k] - self.owns[k - 1]) / (self.times[k] - self.times[k - 1])
        return self.owns[k - 1] + slope * (at - self.times[k - 1])

    def _look(self) -> None:
        before = 0
        while not self.done.wait(PERIOD):
            now = time.monotonic() - self.begin
            tree = processes_of(self.mark)
            if self.limits:
                self._hold(tree)
            total = sum(one.ticks + one.reaped for one in tree.values())  # what has ended is in its parent's
            used, passed = max(0, total - before) / TICKS, now - self.times[-1]
            self.spent, before = self.spent + used, total
            parents = {one.parent for one in tree.values()}  # one of them may wait for its vfork, as for a disk
            asleep = all((state := state_of_threads(pid, one.state)) in ASLEEP or (state == "D" and pid in parents)
                         for pid, one in tree.items())
            self.times.append(now)
            self.owns.append(self.owns[-1] + (passed if asleep else min(used, passed)))

    def _hold(self, tree: dict) -> None:
        """Ends all that is inside if it takes more than it may. Of one process, the system sees to the same limits first."""
        inside = {pid: status for pid in tree if is_inside(status := status_of(pid))}
        around = {tree[pid].parent for pid in inside} & tree.keys() - inside.keys()  # has the times of those that have ended
        ticks = sum(tree[pid].ticks + tree[pid].reaped for pid in inside) + sum(tree[pid].reaped for pid in around)
        files, size = used_below(self.folders, self.limits.files) if inside else (0, 0)
        if ticks / TICKS > self.limits.seconds + 1:
            self.exceeded = "seconds"
        elif memory_of(inside, self.limits.memory) > self.limits.memory:
            self.exceeded = "memory"
        elif files > self.limits.files or size > self.limits.scratch:
            self.exceeded = "scratch"
        else:
            return
        for pid in inside:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)


class Process(NamedTuple):
    parent: int
    state: str
    ticks: int   # of the processor, its own
    reaped: int  # and of those that it has waited for


_last_look = (-1.0, {})
_one_looks = threading.Lock()


def all_processes() -> dict:
    """{pid: Process} of this machine; many submissions share a look."""
    global _last_look
    with _one_looks:
        if time.monotonic() - _last_look[0] > PERIOD / 4:
            found = {}
            for pid in filter(str.isdigit, os.listdir("/proc")):
                with suppress(OSError):  # it has just ended
                    fields = read_at_once(f"/proc/{pid}/stat").rpartition(b")")[2].split()
                    user, system, users, systems = map(int, fields[11:15])
                    found[int(pid)] = Process(int(fields[1]), fields[0].decode(), user + system, users + systems)
            _last_look = (time.monotonic(), found)
        return _last_look[1]


def read_at_once(path: str) -> bytes:
    """What a small file of the system has, in half of the time that a file object needs; there are hundreds in each look."""
    file = os.open(path, os.O_RDONLY)
    try:
        return os.read(file, 4096)
    finally:
        os.close(file)


def processes_of(mark: bytes) -> dict:
    """{pid: Process} of the processes that are called by the mark, and of all that they have started."""
    processes, ours = all_processes(), set()
    parents = {pid: one.parent for pid, one in processes.items()}
    for pid in below(os.getpid(), parents):
        with suppress(OSError):
            if mark in Path(f"/proc/{pid}/cmdline").read_bytes():
                ours |= {pid, *below(pid, parents)}
    return {pid: processes[pid] for pid in ours}


def status_of(pid: int) -> dict:
    with suppress(OSError):
        return dict(line.split(":", 1) for line in Path(f"/proc/{pid}/status").read_text(encoding="latin-1").splitlines() if ":" in line)
    return {}


def is_inside(status: dict) -> bool:
    """Whether it is in a namespace of its own, or one of the users of confine.py."""
    user = int(status.get("Uid", "0").split()[0])
    return len(status.get("NSpid", "").split()) > 1 or any(user in users for users in USERS)


def memory_of(inside: dict, most: int) -> int:
    """Bytes of these processes together; what they share counts once, where it would be too much otherwise. That is looked at
    twice: of those that end meanwhile the others take over the share."""
    total = sum(kilobytes(status, "VmRSS", "VmSwap") for status in inside.values()) << 10
    return total if total <= most else min(sum(shares_of(pid, status) for pid, status in inside.items()) for _ in range(2)) << 10


def kilobytes(table: dict, *names) -> int:
    return sum(int(table.get(name, "0").split()[0]) for name in names)


def shares_of(pid: int, status: dict) -> int:
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text(encoding="latin-1").splitlines()[1:]
    except (FileNotFoundError, ProcessLookupError):  # it has ended
        return 0
    except OSError:
        return kilobytes(status, "VmRSS", "VmSwap")
    return kilobytes(dict(line.split(":", 1) for line in lines), "Pss", "SwapPss")


def used_below(folders: list, most: int) -> tuple:
    """(files, bytes) of these folders; files beyond `most` are not counted."""
    files = size = 0
    folders = list(folders)
    while folders and files <= most:
        with suppress(OSError), os.scandir(folders.pop()) as entries:
            for entry in entries:
                files, size = files + 1, size + entry.stat(follow_symlinks=False).st_blocks * 512
                if entry.is_dir(follow_symlinks=False):
                    folders.append(entry.path)
                if files > most:
                    break
    return files, size


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
