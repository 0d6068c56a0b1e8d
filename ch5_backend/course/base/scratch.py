"""A folder for what a run of ./course needs for itself. It goes with the process; if that was killed, with the next run."""

import atexit
import fcntl
import os
import shutil
import tempfile
from pathlib import Path

PREFIX = "course-scratch."

_folder = None
_held = None  # the folder's lock, which ends with this process, however that ends


def scratch() -> Path:
    """This process's folder, which others may enter, but not list."""
    global _folder, _held
    while _folder is None:
        folder = Path(tempfile.mkdtemp(prefix=PREFIX))
        held = lock(folder, 0)
        if folder.exists():  # or another run has taken it for a dead one's
            os.chmod(folder, 0o711)
            _folder, _held = folder, held
            atexit.register(shutil.rmtree, folder, ignore_errors=True)
            remove_dead()
    return _folder


def lock(folder: Path, mode: int):
    """A descriptor that holds the folder, or None: it is gone, held elsewhere, or its file system has no locks."""
    try:
        held = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    except OSError:
        return None
    try:
        fcntl.flock(held, fcntl.LOCK_EX | mode)
        return held
    except OSError:
        os.close(held)
        return None


def remove_dead() -> None:
    """Removes our own folders that no process holds any more."""
    for folder in Path(tempfile.gettempdir()).glob(PREFIX + "*"):
        try:
            ours = folder.lstat().st_uid == os.geteuid()
        except OSError:
            continue
        held = lock(folder, fcntl.LOCK_NB) if ours and folder != _folder else None
        if held is not None:
            shutil.rmtree(folder, ignore_errors=True)
            os.close(held)
