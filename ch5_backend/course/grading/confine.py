"""Runs a program as a user of its own that may only compute: python3 -I -S confine.py USER WORD… -- COMMAND…, started by root.

The words are read=PATH, hidden=PATH (below one of those), write=FOLDER, the limits by their names, CPU=10:11 (soft and hard), and
filter=FILE, of the calls that fail. Whatever is not named cannot be opened. The process that was started stays root, so that nothing
inside reaches it; it takes over what loses its parent, ends everything of this user with the command, and exits as that did, or with
128 + the signal. `confine.py USER` only ends.
"""

import _signal as signal  # what Python's own loads takes as long as all the rest
import ctypes
import os
import resource
import struct
import sys
import time

# Users that neither Debian nor systemd gives to anybody; each even one is followed by the one that may end it. The few are for
# containers that have no more, whose users are their own; in others, the many keep containers of one machine apart.
USERS = (range(0x70000000, 0x70100000), range(60706, 61182))

LANDLOCK_CREATE, LANDLOCK_ADD, LANDLOCK_RESTRICT = 444, 445, 446  # system calls, of all architectures
SET_PDEATHSIG, SET_SECCOMP, SET_CHILD_SUBREAPER, SET_NO_NEW_PRIVS = 1, 22, 36, 38  # of prctl
EXECUTE, WRITE_FILE, READ_FILE, READ_DIR, REMOVE_FILE, MAKE_REG, TRUNCATE = 1 << 0, 1 << 1, 1 << 2, 1 << 3, 1 << 5, 1 << 8, 1 << 14
# In its own folder it makes usual files only: no link, pipe or socket, and no folder, so that all it holds is one list.
READ, WRITE = EXECUTE | READ_FILE | READ_DIR, READ_FILE | WRITE_FILE | TRUNCATE | READ_DIR | REMOVE_FILE | MAKE_REG
OF_FILES = EXECUTE | WRITE_FILE | READ_FILE | TRUNCATE

libc = ctypes.CDLL(None, use_errno=True)


def system(call, *words) -> int:
    result = call(*(word if isinstance(word, bytes) else ctypes.c_long(word) for word in words))
    if result < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return result


def landlock_version() -> int:
    """0 where the kernel has none, or does not use it."""
    try:
        return system(libc.syscall, LANDLOCK_CREATE, 0, 0, 1)
    except OSError:
        return 0


def file_rules(rights: dict, version: int) -> int:
    """A descriptor of {path: what may be done there and below}, for LANDLOCK_RESTRICT. Before version 3 the filter of calls stands
    in for TRUNCATE."""
    known = (1 << 13) - 1 | sum(1 << bit for bit, since in ((13, 2), (14, 3), (15, 5)) if version >= since)
    handled = struct.pack("=QQQ", known, 3 * (version >= 4), 3 * (version >= 6))  # and TCP, and abstract sockets and signals
    rules = system(libc.syscall, LANDLOCK_CREATE, handled, len(handled), 0)
    for path, allowed in rights.items():
        place = os.open(path, os.O_PATH | os.O_CLOEXEC)
        allowed &= known if os.path.isdir(path) else known & OF_FILES
        system(libc.syscall, LANDLOCK_ADD, rules, 1, struct.pack("=Qi", allowed, place), 0)
        os.close(place)
    return rules


def below(root: str, hidden) -> list:
    """The paths to allow so that `root` can be read without the hidden ones: Landlock's rules only allow, none takes back."""
    if root in hidden:
        return []
    if not any(path.startswith(root + "/") for path in hidden):
        return [root]
    entries = (f"{root}/{entry}" for entry in os.listdir(root))
    return [path for entry in entries if not os.path.islink(entry) for path in below(entry, hidden)]


def become(user: int, ended_by: int = None) -> None:
    """This process is that user from now on, without groups and rights."""
    ended_by = user if ended_by is None else ended_by
    os.setgroups([])
    os.setresgid(user, user, user)
    os.setresuid(ended_by, user, ended_by)
    with open("/proc/self/status", "rb") as file:
        rights = dict(line.split(b":", 1) for line in file)
    if os.getresuid() != (ended_by, user, ended_by) or int(rights[b"CapEff"], 16) or int(rights[b"CapPrm"], 16):
        raise PermissionError("rights are left after they were given up")


def end_all_of(user: int) -> None:
    """Ends all that this user runs, at one blow: nothing can fork away from it, nor end first who does it."""
    helper = os.fork()
    if helper == 0:
        try:
            become(user, ended_by=user + 1)
            os.kill(-1, signal.SIGKILL)
        except OSError:  # there is nothing to end
            pass
        finally:
            os._exit(0)
    os.waitpid(helper, 0)


def confine(user: int, plan: dict, command: list) -> None:
    """Does not return; what fails is raised before anything has run."""
    parent = os.getppid()
    os.setsid()
    with open("/proc/self/oom_score_adj", "wb") as file:
        file.write(b"1000")
    with open(*plan["filter"], "rb") as file:
        calls = ctypes.create_string_buffer(file.read())
    read = [path for place in plan["read"] for path in below(place, plan.get("hidden", ()))]
    rules = file_rules({**dict.fromkeys(read, READ), **dict.fromkeys(plan.get("write", ()), WRITE),
                        "/dev/null": READ_FILE | WRITE_FILE, "/dev/urandom": READ_FILE},
                       min(landlock_version(), *map(int, plan.get("landlock", ["100"]))))  # an older one, for tests
    home = plan.get("write", ["/"])[0]
    os.umask(0o022)
    os.chdir(home)
    for name in plan.keys() - {"read", "hidden", "write", "filter", "landlock"}:
        limit = getattr(resource, "RLIMIT_" + name)
        soft, _, hard = plan[name][0].partition(":")
        allowed = resource.getrlimit(limit)[1]
        resource.setrlimit(limit, [min(int(most), allowed if allowed >= 0 else int(most)) for most in (soft, hard or soft)])
    become(user)
    try:
        os.kill(-1, signal.SIGKILL)  # what is left of an earlier run, in which this program was ended by force
    except ProcessLookupError:
        pass
    system(libc.prctl, SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:
        os._exit(126)
    for number in (signal.SIGPIPE, signal.SIGXFSZ, signal.SIGINT):
        signal.signal(number, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_SETMASK, ())
    system(libc.prctl, SET_NO_NEW_PRIVS, 1, 0, 0, 0)
    system(libc.syscall, LANDLOCK_RESTRICT, rules, 0)
    program = struct.pack("@HP", (len(calls) - 1) // 8, ctypes.addressof(calls))
    system(libc.prctl, SET_SECCOMP, 2, program, 0, 0)
    for _ in range(500):
        try:
            os.execvpe(command[0], command, {"PATH": "/usr/bin", "LC_ALL": "C.UTF-8", "HOME": home, "TMPDIR": home})
        except BlockingIOError:  # until the processes of the earlier run are gone, which count
            time.sleep(0.01)


def close_inherited() -> None:
    for descriptor in map(int, os.listdir("/proc/self/fd")):
        try:
            os.close(descriptor if descriptor > 2 else -1)
        except OSError:  # the one that has listed them
            pass


def run(user: int, plan: dict, command: list) -> int:
    """The command's exit code, once nothing of it is left."""
    close_inherited()
    system(libc.prctl, SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
    begun, begins = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            confine(user, plan, command)
        except BaseException as error:
            os.write(2, f"{command[0]}: {error}\n".encode())
        finally:
            os._exit(126)
    os.close(begins)
    for standard in range(3):
        os.dup2(os.open(os.devnull, os.O_RDWR), standard)
    os.read(begun, 1)  # until it is that user, and runs
    signal.signal(signal.SIGTERM, lambda *_: end_all_of(user))
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
    ended, code = 0, 0
    while ended != child:
        ended, status = os.wait()
        code = os.waitstatus_to_exitcode(status)
    try:
        if os.waitpid(-1, os.WNOHANG):  # all that is left has become this process's
            end_all_of(user)
        while True:
            os.wait()
    except ChildProcessError:
        return code if code >= 0 else 128 - code


if __name__ == "__main__":
    if len(sys.argv) == 2:
        end_all_of(int(sys.argv[1]))
    else:
        end, words = sys.argv.index("--"), {}
        for word in sys.argv[2:end]:
            key, _, value = word.partition("=")
            words.setdefault(key, []).append(value)
        os._exit(run(int(sys.argv[1]), words, sys.argv[end + 1:]))
