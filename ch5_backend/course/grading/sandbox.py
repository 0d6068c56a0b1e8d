"""A sandbox for untrusted programs, whichever engine makes it (engines.py): what a program sees, what it may use, and how it runs.

Where none can be had, `engines.choose` says why and nothing is run.
"""

import os
import resource
import signal
import subprocess
import tempfile
import threading
from dataclasses import dataclass, field
from typing import NamedTuple

from ..base.processes import forget, start
from .watch import Watch

MIB = 1 << 20
COUNTED = 0.8  # of the seconds that a limit has counted, in ticks: the sum afterwards was up to a tenth less on a busy machine


class Limits(NamedTuple):
    """What a program may use, with all that it starts; beyond it is ended, or its calls fail."""
    seconds: int = 10           # of processor time
    wall_seconds: float = 20.0
    memory: int = 2048 * MIB    # of addresses, a process; of pages, all together
    processes: int = 16
    file_size: int = 64 * MIB
    scratch: int = 512 * MIB    # of disk below what is writable
    files: int = 1000           # there
    output: int = MIB           # what is kept of its words


EXCEEDED = {"memory": "out of memory: all processes together took more than {} MB", "seconds": "", "": "",
            "scratch": "File size limit exceeded: all files together are more than they may be"}


class Outcome(NamedTuple):
    exit_code: int       # negative: the signal that ended it
    output: str          # standard output and error together, cut at the limit
    in_time: bool
    cpu_seconds: float
    peak_mib: float
    stalled: bool = False  # its time ran out while it waited for the machine: this says nothing about it


@dataclass
class Sandbox:
    """Files that a program sees: {inside: outside}. An engine has a name, and says what `wrap`, `clear` and `stop` do."""
    read_only: dict = field(default_factory=dict)
    writable: dict = field(default_factory=dict)
    limits: Limits = Limits()
    name = "none"

    @classmethod
    def preflight(cls) -> None:
        """Raises CourseError with what is wrong, unless a program runs inside and is cut off from the outside."""

    @classmethod
    def group(cls) -> int:
        """That of the programs which this thread runs inside."""
        return os.getegid()

    def wrap(self, command: list) -> list:
        """The command line that runs `command` inside."""
        raise NotImplementedError

    def clear(self) -> None:
        """Ends what of it is left."""

    def stop(self, process: subprocess.Popen) -> None:
        """Ends the program with all that it has started."""
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass

    def watch(self, mark: str) -> Watch:
        """Of what runs by `wrap` from now on; `mark` is in its command line."""
        return Watch(mark, self.limits, self.writable.values(), self.clear)

    def run(self, command: list, words: bytes = b"") -> Outcome:
        """Runs it to its end, or to that of its time; nothing of it is left then."""
        wrapped = self.wrap(command)
        mark = next((str(outside) for places in (self.writable, self.read_only) for outside in places.values()), str(command[-1]))
        with tempfile.TemporaryFile() as given, tempfile.TemporaryFile() as printed, self.watch(mark) as watch:
            given.write(words)
            given.seek(0)
            process = start(wrapped, stdin=given, stdout=printed, stderr=subprocess.STDOUT, preexec_fn=self._limit_output)
            late = threading.Event()
            clock = threading.Timer(self.limits.wall_seconds, lambda: (late.set(), self.stop(process)))
            clock.start()
            try:
                _, status, used = os.wait4(process.pid, 0)  # with the times of all inside
                process.returncode = os.waitstatus_to_exitcode(status)
            finally:
                clock.cancel()
                self.stop(process)
                forget(process)
            printed.seek(0)
            output = printed.read(self.limits.output).decode("utf-8", "replace")
        # Of what was ended by force, the system may count nothing.
        cpu, code = max(used.ru_utime + used.ru_stime, watch.spent if late.is_set() or watch.exceeded else 0.0), process.returncode
        if code > 128 and code - 128 in signal.valid_signals():  # as engines and shells say it
            code = 128 - code
        if why := EXCEEDED[watch.exceeded]:
            output += f"\nerror: {why.format(self.limits.memory // MIB)}\n"
        # A program that used up its seconds was ended for that, even if it caught the signal and ended with a message of its own.
        in_time = not late.is_set() and watch.exceeded != "seconds" and code != -signal.SIGXCPU and cpu < COUNTED * self.limits.seconds
        stalled = late.is_set() and cpu < self.limits.seconds and watch.own() < self.limits.wall_seconds / 2
        return Outcome(code, output, in_time, cpu, used.ru_maxrss / 1024, stalled)

    def _limit_output(self) -> None:
        """Of files that are open already, such as standard output, which no size inside limits."""
        allowed = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
        most = self.limits.file_size if allowed == resource.RLIM_INFINITY else min(allowed, self.limits.file_size)
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))

    def outside(self, word: str) -> str:
        """A word of a command where files have no other name inside."""
        for inside, outside in {**self.read_only, **self.writable}.items():
            if word == inside or word.startswith(inside + "/"):
                return str(outside) + word[len(inside):]
        return word


class Unguarded(Sandbox):
    """No sandbox: for code that one trusts as one's own. Only the limits hold."""

    def wrap(self, command: list) -> list:
        some = self.limits
        limits = ["prlimit", f"--cpu={some.seconds}:{some.seconds + 1}", f"--as={some.memory}",
                  f"--fsize={some.file_size}", "--core=0", "--"]
        return [*limits, *(self.outside(str(word)) for word in command)]
