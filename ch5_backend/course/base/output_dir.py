"""The folder that takes the results."""

import fcntl
import os
import sys
import tempfile
from contextlib import contextmanager, suppress
from pathlib import Path

from .errors import CourseError
from .progress import Progress


def result_places(paths, out: Path) -> dict:
    """{path: folder of its results}; each of the data needs a folder of its own, in which no input lies."""
    places = {path: out / Path(path).stem for path in paths}
    for path, place in places.items():
        others = [other for other in places if other != path and places[other] == place]
        if others:
            raise CourseError(f"{path} and {others[0]} would both write into {place}; run them with another --out")
        inside = [data for data in places if place.resolve() in Path(data).resolve().parents]
        if inside:
            raise CourseError(f"the results of {path} would be written into {place}, where they could overwrite the "
                              f"input {inside[0]}; run with another --out")
    return places


def hold(file, what: str) -> None:
    """Locks a file or descriptor until it is closed; waits for another ./course that does `what`, and says so."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        print(Progress.say.translate(f"waiting for another ./course that {what} …"), file=sys.stderr, flush=True)
        fcntl.flock(file, fcntl.LOCK_EX)
    except OSError:  # a file system without locks: then only the names of temporary files keep two runs apart
        pass


@contextmanager
def made_dir(out: Path):
    """Makes the folder, once a file can be written in it; at the end removes what it has made and is still empty, as when
    nothing came of it."""
    new = [folder for folder in (out, *out.parents) if not folder.exists()]
    try:
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=out) as probe:
            probe.write(b"probe")
    except OSError as error:
        raise CourseError(f"cannot write into {out}: {error.strerror}") from error
    try:
        yield
    finally:
        with suppress(OSError):  # not empty
            for folder in new:
                folder.rmdir()


@contextmanager
def locked_dir(out: Path):
    """Makes the folder ours while the block runs: two ./course at once would mix their results, so the second waits."""
    with made_dir(out):
        folder = os.open(out, os.O_RDONLY)
        try:
            hold(folder, f"writes into {out}")
            yield
        finally:
            os.close(folder)
