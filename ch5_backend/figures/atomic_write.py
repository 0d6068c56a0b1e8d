"""Files that appear whole or not at all."""
import errno
import os
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def atomic_write(path):
    """Gives a path to write to, of the same ending, which becomes `path` at the end of the block.

    Its name is this process's own, so that two runs into one folder do not write the same file; after an exception
    it is removed. A device or a pipe is refused, since it would be replaced: /dev/null, for root.
    """
    path = Path(path)
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise OSError(errno.EINVAL, "not a regular file", str(path))
    partial = path.with_name(f".ch5-{os.getpid()}-{path.name}")
    try:
        yield partial
        partial.replace(path)
    except OSError as error:
        if error.filename in (None, str(partial)):  # a full disk does not say where
            error.filename = str(path)
        raise
    finally:
        with suppress(OSError):
            partial.unlink()


def write_whole(path, text, errors="strict"):
    """The text as a file that appears whole or not at all; `errors` as of str.encode."""
    with atomic_write(path) as partial:
        partial.write_text(text, encoding="utf-8", errors=errors)
