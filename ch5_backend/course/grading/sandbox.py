"""A sandbox for untrusted programs, made of bubblewrap (namespaces), setpriv, prlimit and seccomp.

Inside there are the system's /usr, the files that are bound by name, and nothing else: no network, no home, no project,
no other process. Where it cannot be had, it says why and nothing is run.
"""

import errno
import glob
import mmap
import os
import resource
import shutil
import signal
import subprocess
import tempfile
import threading
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from ..base.processes import forget, start
from ..base.cmake_build import ROOT
from ..base.errors import CourseError
from ..base.scratch import scratch
from .watch import Watch

NOBODY = 65534
MIB = 1 << 20
TICKS = 0.1  # [s]: the limit counts in ticks, of which the sum afterwards may lack some

# Calls that no homework needs, and that reach other processes, the kernel or new namespaces, or take memory that no limit
# counts.
FORBIDDEN_CALLS = (
    "ptrace", "process_vm_readv", "process_vm_writev", "pidfd_getfd", "kcmp", "mount", "umount2", "pivot_root", "chroot",
    "unshare", "setns", "keyctl", "add_key", "request_key", "bpf", "perf_event_open", "userfaultfd", "io_uring_setup",
    "io_uring_enter", "io_uring_register", "kexec_load", "init_module", "finit_module", "delete_module", "swapon",
    "swapoff", "reboot", "settimeofday", "clock_settime", "socket", "socketpair", "fanotify_init", "open_by_handle_at",
    "shmget", "msgget", "semget", "mq_open", "memfd_create", "memfd_secret", "personality", "pkey_mprotect")
NEW_USER_NAMESPACE = 0x10000000  # CLONE_NEWUSER


class Limits(NamedTuple):
    """What a program may use; beyond it is ended, or its calls fail."""
    seconds: int = 10           # of processor time
    wall_seconds: float = 20.0
    memory: int = 2048 * MIB    # of addresses, a process
    processes: int = 16
    file_size: int = 64 * MIB
    output: int = MIB           # what is kept of its words


class Outcome(NamedTuple):
    exit_code: int       # negative: the signal that ended it
    output: str          # standard output and error together, cut at the limit
    in_time: bool
    cpu_seconds: float
    peak_mib: float
    stalled: bool = False  # its time ran out while it waited for the machine: this says nothing about it


@dataclass
class Sandbox:
    """Files that a program sees: {inside: outside}."""
    read_only: dict = field(default_factory=dict)
    writable: dict = field(default_factory=dict)
    limits: Limits = Limits()

    def wrap(self, command: list) -> list:
        """The command line that runs `command` inside. The parent watches the wall clock: killing it ends all inside."""
        binds = [word for inside, outside in self.read_only.items() for word in ("--ro-bind", str(outside), inside)]
        binds += [word for inside, outside in self.writable.items() for word in ("--bind", str(outside), inside)]
        bubble = ["bwrap", "--unshare-all", "--die-with-parent", "--new-session", "--cap-drop", "ALL", "--clearenv",
                  "--setenv", "PATH", "/usr/bin", "--setenv", "LC_ALL", "C.UTF-8", "--setenv", "HOME", "/tmp",
                  "--ro-bind", "/usr", "/usr", *hiding(installed()), "--symlink", "usr/bin", "/bin", "--symlink", "usr/lib", "/lib",
                  "--symlink", "usr/lib64", "/lib64", *(("--proc", "/proc") if self.writable else ()), "--dev", "/dev",
                  "--size", str(64 * MIB), "--tmpfs", "/tmp", *binds,
                  "--remount-ro", "/dev", "--remount-ro", "/",  # they have no limit of size
                  # What is graded can write no file that it then loads or starts, and not into its own code.
                  *(() if self.writable else ("--remount-ro", "/tmp")),
                  "--chdir", "/tmp", "--hostname", "sandbox",
                  "--as-pid-1", "--seccomp", "9"]
        some = self.limits
        # nproc counts per user, so it is set inside, where the user is a new one. The shell waits, so that times add up; it is
        # limited too, since the program may write into its memory.
        inside = ["prlimit", f"--cpu={some.seconds}:{some.seconds + 1}", f"--as={some.memory}", f"--nproc={some.processes}",
                  f"--fsize={some.file_size}", "--core=0", "--nofile=64", "--", "sh", "-c", '"$@"; exit $?', "sh", *map(str, command)]
        drop = ["setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups", "--no-new-privs"]
        # The shell opens the filter before rights are dropped, and closes what it has inherited. Where memory runs out, the
        # system takes what runs inside first, and not the grader or a neighbor.
        opened = ["sh", "-c", 'exec 3>&- 4>&- 5>&- 6>&- 7>&- 8>&- 9<"$0"; { echo 1000 >/proc/self/oom_score_adj; } 2>/dev/null; exec "$@"',
                  str(call_filter())]
        return [*opened, *(drop if os.geteuid() == 0 else []), *bubble, "--", *inside]

    def run(self, command: list, words: bytes = b"") -> Outcome:
        """Runs it to its end, or to that of its time; nothing of it is left then."""
        mark = next((str(outside) for places in (self.writable, self.read_only) for outside in places.values()), "bwrap")
        with tempfile.TemporaryFile() as given, tempfile.TemporaryFile() as printed, Watch(mark) as watch:
            given.write(words)
            given.seek(0)
            process = start(self.wrap(command), stdin=given, stdout=printed, stderr=subprocess.STDOUT,
                            preexec_fn=self._limit_output)
            late = threading.Event()
            clock = threading.Timer(self.limits.wall_seconds, lambda: (late.set(), kill(process)))
            clock.start()
            try:
                _, status, used = os.wait4(process.pid, 0)  # with the times of all inside
                process.returncode = os.waitstatus_to_exitcode(status)
            finally:
                clock.cancel()
                kill(process)
                forget(process)
            printed.seek(0)
            output = printed.read(self.limits.output).decode("utf-8", "replace")
        # Of what was ended by the clock, the system counts nothing.
        cpu, code = max(used.ru_utime + used.ru_stime, watch.spent if late.is_set() else 0.0), process.returncode
        if code > 128 and code - 128 in signal.valid_signals():  # as bwrap and shells say it
            code = 128 - code
        # A program that used up its seconds was ended for that, even if it caught the signal and ended with a message of its own.
        in_time = not late.is_set() and code != -signal.SIGXCPU and cpu < self.limits.seconds - TICKS
        stalled = late.is_set() and cpu < self.limits.seconds and watch.own() < self.limits.wall_seconds / 2
        return Outcome(code, output, in_time, cpu, used.ru_maxrss / 1024, stalled)

    def _limit_output(self) -> None:
        """Of files that are open already, such as standard output, which no size inside limits."""
        allowed = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
        most = self.limits.file_size if allowed == resource.RLIM_INFINITY else min(allowed, self.limits.file_size)
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))


@lru_cache
def installed(root: str = "/usr") -> tuple:
    """What holds the solutions below /usr: the course's library, if an engineer has installed it, and the project, if it
    lies there."""
    places = [f"{root}{local}/lib{below}" for local in ("", "/local") for below in ("", "/*", "/*/*-packages")]
    project = [str(ROOT)] if ROOT.is_relative_to(root) else []
    return (*sorted(found for place in places for found in glob.glob(f"{place}/*ch5_backend*")), *project)


def hiding(paths) -> list:
    """Words for bubblewrap that put nothing in the place of these files and folders."""
    return [word for path in paths for word in (("--size", str(MIB), "--tmpfs", path) if os.path.isdir(path) else
                                         ("--ro-bind", "/dev/null", path))]


class Unguarded(Sandbox):
    """No sandbox: for code that one trusts as one's own. Only the limits hold."""

    def wrap(self, command: list) -> list:
        some, places = self.limits, {**self.read_only, **self.writable}
        limits = ["prlimit", f"--cpu={some.seconds}:{some.seconds + 1}", f"--as={some.memory}",
                  f"--fsize={some.file_size}", "--core=0", "--"]
        return [*limits, *(self._outside(str(word), places) for word in command)]

    @staticmethod
    def _outside(word: str, places: dict) -> str:
        for inside, outside in places.items():
            if word == inside or word.startswith(inside + "/"):
                return str(outside) + word[len(inside):]
        return word


def kill(process: subprocess.Popen) -> None:
    """Ends the program with all that it has started: with the first process of its namespace the others go."""
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass


_filter = None


def call_filter() -> Path:
    """The seccomp program, made once and readable by all."""
    global _filter
    if _filter is None:
        try:
            import seccomp
        except ImportError as error:
            raise CourseError("the sandbox needs Debian's python3-seccomp; ./course grade installs it") from error
        rules = seccomp.SyscallFilter(defaction=seccomp.ALLOW)
        for call in FORBIDDEN_CALLS:
            rules.add_rule(seccomp.ERRNO(errno.EPERM), call)
        rules.add_rule(seccomp.ERRNO(errno.EPERM), "clone",
                       seccomp.Arg(0, seccomp.MASKED_EQ, NEW_USER_NAMESPACE, NEW_USER_NAMESPACE))
        for call, argument in (("kill", 1), ("tkill", 1), ("tgkill", 2)):  # so a stopped process was stopped from outside: see watch.py
            for number in (signal.SIGSTOP, signal.SIGTSTP, signal.SIGTTIN, signal.SIGTTOU):
                rules.add_rule(seccomp.ERRNO(errno.EPERM), call, seccomp.Arg(argument, seccomp.MASKED_EQ, 0xFFFFFFFF, number))
        # No bytes that a program has made or brought become code.
        executable = seccomp.Arg(2, seccomp.MASKED_EQ, mmap.PROT_EXEC, mmap.PROT_EXEC)
        rules.add_rule(seccomp.ERRNO(errno.EPERM), "mprotect", executable)
        rules.add_rule(seccomp.ERRNO(errno.EPERM), "mmap", executable,
                       seccomp.Arg(3, seccomp.MASKED_EQ, mmap.MAP_ANONYMOUS, mmap.MAP_ANONYMOUS))
        rules.add_rule(seccomp.ERRNO(errno.ENOSYS), "clone3")  # its flags cannot be seen; libc then takes clone
        _filter = scratch() / "calls.bpf"
        with open(_filter, "wb") as file:
            rules.export_bpf(file)
    return _filter


NEEDED = {"-f, of a file's size": (resource.RLIMIT_FSIZE, 128 * MIB), "-n, of open files": (resource.RLIMIT_NOFILE, 64),
          "-v, of addresses": (resource.RLIMIT_AS, 3072 * MIB), "-t, of seconds": (resource.RLIMIT_CPU, 60)}


def preflight() -> None:
    """Raises CourseError with what is wrong, unless a program runs inside and is cut off from the outside."""
    for name, (limit, needed) in NEEDED.items():
        allowed = resource.getrlimit(limit)[1]
        if allowed not in (resource.RLIM_INFINITY, -1) and allowed < needed:
            raise CourseError(f"the shell's limit ulimit {name}, is {allowed}, and a submission may need {needed}. Nothing was run.")
    for tool, package in (("bwrap", "bubblewrap"), ("setpriv", "util-linux"), ("prlimit", "util-linux")):
        if shutil.which(tool) is None:
            raise CourseError(f"there is no sandbox: {tool} is missing (Debian's package {package}). Nothing was run.")
    with tempfile.NamedTemporaryFile(dir=scratch()) as outside:
        question = f"test ! -e {outside.name} && test ! -e /etc && test ! -e /home && echo inside"
        outcome = Sandbox(limits=Limits(seconds=5, wall_seconds=10)).run(["sh", "-c", question])
    if outcome.exit_code != 0 or outcome.output != "inside\n":
        words = outcome.output.strip() or f"exit code {outcome.exit_code}"
        raise CourseError(f"there is no sandbox: bubblewrap cannot make one here ({words}). User namespaces may be "
                          "forbidden, by AppArmor or in a container. Nothing was run.")
