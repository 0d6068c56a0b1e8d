"""A program on a terminal."""

import fcntl
import os
import pty
import struct
import subprocess
import termios


def on_terminal(command, columns: int, **options) -> tuple:
    """(exit code, what is shown) on a terminal of so many columns, at which nobody types."""
    terminal, side = pty.openpty()
    fcntl.ioctl(side, termios.TIOCSWINSZ, struct.pack("HHHH", 200, columns, 0, 0))
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=side, stderr=side, start_new_session=True, **options)
    os.close(side)
    shown = b""
    with os.fdopen(terminal, "rb", buffering=0) as screen:
        try:
            while part := screen.read(65536):
                shown += part
        except OSError:  # the terminal's other side is closed
            pass
    return process.wait(), shown.decode("utf-8", "replace")
