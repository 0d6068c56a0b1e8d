"""The engines of the sandbox: bubblewrap, where user namespaces may be made, and Landlock with a user for each submission, where one
is root, as in a container. `choose` takes the first that works here.

Inside either there are the system's /usr, the files that are bound by name, and nothing else: no network, no home, no project,
no other process. With the second, the names of other files can be seen, though nothing in them.
"""

import glob
import grp
import os
import pwd
import random
import resource
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

from ..base.cmake_build import ROOT
from ..base.errors import CourseError
from ..base.scratch import scratch
from . import confine
from .calls import call_filter
from .sandbox import MIB, Limits, Sandbox

NOBODY = 65534
LAUNCHER = [sys.executable, "-I", "-S", confine.__file__]


class Namespaces(Sandbox):
    """Bubblewrap, setpriv, prlimit and seccomp."""
    name = "bubblewrap"

    @classmethod
    def group(cls) -> int:
        return NOBODY if os.geteuid() == 0 else os.getegid()

    def wrap(self, command: list) -> list:
        """The parent watches the wall clock: killing it ends all inside."""
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

    @classmethod
    def preflight(cls) -> None:
        for tool, package in (("bwrap", "bubblewrap"), ("setpriv", "util-linux"), ("prlimit", "util-linux")):
            if shutil.which(tool) is None:
                raise CourseError(f"{tool} is missing (Debian's package {package})")
        try_out(cls, 'test ! -e "$0" && test ! -e /etc && test ! -e /home', "bubblewrap cannot make one here ({}). User namespaces "
                "may be forbidden, by AppArmor or in a container")


class OwnUser(Sandbox):
    """confine.py: a user for each submission, which Landlock and seccomp hold. The thread that grades it has this user for itself
    as long as it lives, and no other grader on this machine has it."""
    name = "landlock"
    _thread = threading.local()

    @classmethod
    def user(cls) -> int:
        if not hasattr(cls._thread, "user"):
            users = next(filter(are_there, confine.USERS), confine.USERS[-1])[::2]
            for user in random.sample(users, min(1000, len(users))):
                held = socket.socket(socket.AF_UNIX)
                try:
                    held.bind(f"\0ch5-sandbox-{user}")
                except OSError:  # another grader's
                    continue
                if not is_somebody(user) and not processes_of_user(user):
                    cls._thread.user = user
                    held.detach()  # until the grader ends
                    break
            else:
                raise CourseError(f"all users from {users[0]} to {users[-1]} are taken")
        return cls._thread.user

    @classmethod
    def group(cls) -> int:
        return cls.user()

    def wrap(self, command: list) -> list:
        some = self.limits
        read, hidden, write = ["/usr", *self.read_only.values()], installed(), self.writable.values()
        places = [f"{what}={path}" for what, paths in (("read", read), ("hidden", hidden), ("write", write)) for path in paths]
        return [*LAUNCHER, str(self.user()), f"filter={call_filter()}", *places, f"CPU={some.seconds}:{some.seconds + 1}", f"AS={some.memory}",
                f"NPROC={some.processes}", f"FSIZE={some.file_size}", "NOFILE=64", "CORE=0", "MSGQUEUE=0", "MEMLOCK=0", "--",
                *(self.outside(str(word)) for word in command)]

    def stop(self, process: subprocess.Popen) -> None:
        if process.returncode is None:  # Popen's own way would wait for it, as `run` does
            with suppress(ProcessLookupError):
                os.kill(process.pid, signal.SIGTERM)  # it ends all inside first

    def clear(self) -> None:
        if processes_of_user(self.user()):
            subprocess.run([*LAUNCHER, str(self.user())], check=True)
        if left := processes_of_user(self.user()):
            raise RuntimeError(f"processes of user {self.user()} cannot be ended: {left}")

    @classmethod
    def preflight(cls) -> None:
        if os.geteuid() != 0:
            raise CourseError("only root can run programs as a user of their own")
        if not confine.landlock_version():
            raise CourseError("the kernel has no Landlock, or does not use it")
        try_out(cls, '! cat "$0" /etc/passwd && ! true >/tmp/"$$" && ! true >/dev/shm/"$$" && test "$(id -u)" != 0',
                "Landlock does not hold here ({})")


def are_there(users: range) -> bool:
    """Whether a process may become one of them: a container may have fewer users than the machine."""
    lines = [tuple(map(int, line.split())) for line in Path("/proc/self/uid_map").read_text(encoding="ascii").splitlines()]
    return any(first <= users[0] and users[-1] < first + count for first, _, count in lines)


def is_somebody(user: int) -> bool:
    for look in (pwd.getpwuid, grp.getgrgid):
        for number in (user, user + 1):
            try:
                look(number)
                return True
            except KeyError:
                pass
    return False


def processes_of_user(user: int) -> list:
    """Those that still run."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            if path.stat().st_uid == user and path.joinpath("stat").read_bytes().rpartition(b")")[2].split()[0] not in b"ZX":
                found.append(int(path.name))
        except OSError:  # it has just ended
            pass
    return found


ENGINES = (Namespaces, OwnUser)
NEEDED = {"-f, of a file's size": (resource.RLIMIT_FSIZE, 128 * MIB), "-n, of open files": (resource.RLIMIT_NOFILE, 64),
          "-v, of addresses": (resource.RLIMIT_AS, 3072 * MIB), "-t, of seconds": (resource.RLIMIT_CPU, 60)}


def choose(name: str = ""):
    """The first engine that works here, or the one of this name. Raises CourseError with what is wrong with each."""
    for limited, (limit, needed) in NEEDED.items():
        allowed = resource.getrlimit(limit)[1]
        if allowed not in (resource.RLIM_INFINITY, -1) and allowed < needed:
            raise CourseError(f"the shell's limit ulimit {limited}, is {allowed}, and a submission may need {needed}. Nothing was run.")
    reasons = []
    for engine in ENGINES:
        if name in ("", engine.name):
            try:
                engine.preflight()
                return engine
            except CourseError as error:
                reasons.append(f"{engine.name}: {error}")
    raise CourseError(f"there is no sandbox. {'; '.join(reasons)}. Nothing was run.")


def try_out(engine, question: str, failed: str) -> None:
    """Raises CourseError unless the question, of a file outside, is answered by yes inside."""
    with tempfile.NamedTemporaryFile(dir=scratch()) as outside:
        os.chmod(outside.name, 0o644)
        outcome = engine(limits=Limits(seconds=5, wall_seconds=10)).run(["sh", "-c", 'eval "$1" 2>/dev/null && echo inside', outside.name, question])
    if outcome.exit_code != 0 or outcome.output != "inside\n":
        raise CourseError(failed.format(outcome.output.strip() or f"exit code {outcome.exit_code}"))


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
