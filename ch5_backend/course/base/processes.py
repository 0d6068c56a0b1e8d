"""The programs that ./course starts: none outlives it, whichever signal ends it."""

import os
import signal
import subprocess
from contextlib import contextmanager

GRACE = 5.0  # seconds that a program has to end after it is asked to

_running = []         # the programs that have been started and not yet waited for
_undisturbed = False  # signals wait
_stopped_by = None    # the first signal's number
_ending = False       # the programs are being ended: no further signal may disturb that


class Stopped(KeyboardInterrupt):
    """Raised by Ctrl-C, a kill and a closed terminal."""


def listen() -> None:
    """From now on, the signals that end or pause ./course do so with its programs."""
    # ./course runs this in the background, where Ctrl-C is ignored. The programs must not inherit that.
    signal.signal(signal.SIGINT, _on_stop)
    for number, handler in ((signal.SIGTERM, _on_stop), (signal.SIGHUP, _on_stop), (signal.SIGTSTP, _on_pause)):
        if signal.getsignal(number) != signal.SIG_IGN:  # as nohup wants it
            signal.signal(number, handler)


def start(command, **options) -> subprocess.Popen:
    """Starts a program, with Popen's options, in a session of its own; to be followed by forget() or end()."""
    with undisturbed():  # it must be known before it can be ended
        process = subprocess.Popen(command, start_new_session=True, **options)
        _running.append(process)
    return process


@contextmanager
def undisturbed():
    """A signal raises Stopped behind this block, not inside of it."""
    global _undisturbed
    _undisturbed = True
    try:
        yield
    finally:
        _undisturbed = False
    if _stopped_by is not None:
        raise Stopped


def forget(process: subprocess.Popen) -> None:
    """To be called once a program has ended by itself."""
    if process in _running:
        _running.remove(process)


@contextmanager
def running(command, **options):
    """Starts a program, as start() does; gives the Popen.

    If an exception leaves the block, the program is ended first, with all that it has started.
    """
    process = start(command, **options)
    try:
        yield process
    except BaseException:
        end(process)
        raise
    forget(process)


def end(process: subprocess.Popen) -> None:
    """Ends a program that running() has started, by force if it has not followed after GRACE seconds."""
    global _ending
    _ending = _ending or _stopped_by is not None
    try:
        if process.poll() is None:
            _signal(process, signal.SIGTERM)
            process.wait(GRACE)
    except subprocess.TimeoutExpired:
        pass
    _signal(process, signal.SIGKILL)  # also what a program has left behind
    process.wait()
    forget(process)


def stopped_by():
    """The number of the signal that has stopped ./course; None as long as none has."""
    return _stopped_by


def end_all() -> None:
    """Ends what is running; from now on, signals are ignored."""
    global _ending
    _ending = True
    while _running:
        end(_running[-1])


def _signal(process: subprocess.Popen, number: int) -> None:
    try:
        os.killpg(process.pid, number)
    except (ProcessLookupError, PermissionError):  # macOS answers with the latter
        pass


def _on_stop(number, _frame) -> None:
    """The first signal counts. The next ones only help where an exception is lost, as in Python's own callbacks."""
    global _stopped_by
    _stopped_by = _stopped_by or number
    if not _undisturbed and not _ending:
        raise Stopped


def _on_pause(_number, _frame) -> None:
    """Ctrl-Z: the programs rest too, until the shell's fg or bg."""
    for process in _running:
        _signal(process, signal.SIGSTOP)
    os.kill(os.getpid(), signal.SIGSTOP)
    for process in _running:
        _signal(process, signal.SIGCONT)
