"""The system calls that fail in the sandbox: a seccomp program for both engines."""

import errno
import mmap
import os
import signal
from pathlib import Path

from ..base.errors import CourseError
from ..base.scratch import scratch

# Calls that no homework needs, and that reach other processes, the kernel or new namespaces, or take memory that no limit
# counts.
FORBIDDEN_CALLS = (
    "ptrace", "process_vm_readv", "process_vm_writev", "pidfd_open", "pidfd_getfd", "kcmp", "rt_sigqueueinfo",
    "rt_tgsigqueueinfo", "mount", "umount2", "pivot_root", "chroot", "unshare", "setns", "keyctl", "add_key", "request_key", "bpf", "perf_event_open", "userfaultfd", "io_uring_setup",
    "io_uring_enter", "io_uring_register", "kexec_load", "init_module", "finit_module", "delete_module", "swapon",
    "swapoff", "reboot", "settimeofday", "clock_settime", "socket", "socketpair", "fanotify_init", "open_by_handle_at",
    "shmget", "msgget", "semget", "mq_open", "memfd_create", "memfd_secret", "vmsplice", "personality", "pkey_mprotect",
    "inotify_init", "inotify_init1", "name_to_handle_at", "syslog", "truncate",
    "utimensat", "utime", "utimes", "futimesat", "setxattr", "lsetxattr", "fsetxattr",  # a word to the next check, on whatever all may write
    "timer_create")  # whose signal may be SIGSTOP, see below
NEW_USER_NAMESPACE = 0x10000000  # CLONE_NEWUSER
SET_SIGNAL = 10  # F_SETSIG


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
        rules.add_rule(seccomp.ERRNO(errno.EPERM), "fcntl", seccomp.Arg(1, seccomp.MASKED_EQ, 0xFFFFFFFF, SET_SIGNAL))
        # Who does not wait for its children lets their time vanish, see watch.py.
        rules.add_rule(seccomp.ERRNO(errno.EPERM), "rt_sigaction", seccomp.Arg(0, seccomp.MASKED_EQ, 0xFFFFFFFF, signal.SIGCHLD),
                       seccomp.Arg(1, seccomp.NE, 0))
        # No bytes that a program has made or brought become code, not even in its own copy of a file's pages.
        executable = seccomp.Arg(2, seccomp.MASKED_EQ, mmap.PROT_EXEC, mmap.PROT_EXEC)
        changeable = mmap.PROT_WRITE | mmap.PROT_EXEC
        rules.add_rule(seccomp.ERRNO(errno.EPERM), "mmap", seccomp.Arg(2, seccomp.MASKED_EQ, changeable, changeable))
        rules.add_rule(seccomp.ERRNO(errno.EPERM), "mprotect", executable)
        rules.add_rule(seccomp.ERRNO(errno.EPERM), "mmap", executable,
                       seccomp.Arg(3, seccomp.MASKED_EQ, mmap.MAP_ANONYMOUS, mmap.MAP_ANONYMOUS))
        # Pages that others share stay while no process has them, where nobody's memory shows them.
        shared = mmap.MAP_ANONYMOUS | mmap.MAP_SHARED
        rules.add_rule(seccomp.ERRNO(errno.EPERM), "mmap", seccomp.Arg(3, seccomp.MASKED_EQ, shared, shared))
        for call, argument in (("open", 1), ("openat", 2)):  # to cut what it may only read; early versions of Landlock let it
            rules.add_rule(seccomp.ERRNO(errno.EPERM), call, seccomp.Arg(argument, seccomp.MASKED_EQ, os.O_TRUNC | os.O_ACCMODE, os.O_TRUNC))
        for call in ("clone3", "openat2"):  # what they ask for cannot be seen; libc then takes the older one
            rules.add_rule(seccomp.ERRNO(errno.ENOSYS), call)
        _filter = scratch() / "calls.bpf"
        with open(_filter, "wb") as file:
            rules.export_bpf(file)
    return _filter
