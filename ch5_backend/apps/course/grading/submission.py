"""What is taken from a submission: the homework's own files, by name, as bytes, and nothing else."""

import hashlib
import json
import stat
import tarfile
import zipfile
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from ..build import ROOT
from ..errors import CourseError

LARGEST = 256 << 10       # bytes of a file; the largest solution has 20,000
MOST_MEMBERS = 10_000     # of an archive or folder that are looked at


def homework_files() -> tuple:
    """The names that count, from the table of stages."""
    stages = json.loads((ROOT / "ch5_homework" / "stages.json").read_text(encoding="utf-8"))["stages"]
    return tuple(dict.fromkeys(stage["file"] for stage in stages))


@dataclass
class Submission:
    """One student's work. `faults` are words for the student on what could not be taken."""
    name: str
    files: dict = field(default_factory=dict)   # {name: bytes}
    faults: list = field(default_factory=list)

    def key(self) -> str:
        """The same for the same content, whoever hands it in."""
        digest = hashlib.sha256()
        for name in sorted(self.files):
            digest.update(name.encode() + b"\0" + str(len(self.files[name])).encode() + b"\0" + self.files[name])
        return digest.hexdigest()

    def take(self, path: str, size: int, read, places: dict) -> None:
        """Takes a member if it is one of the homework's files. Of two with one name, the one nearer to the top counts."""
        name, depth = PurePosixPath(path).name, len(PurePosixPath(path).parts)
        if name not in homework_files() or "__MACOSX" in path:
            return
        if name in places and places[name] <= depth:
            self.faults.append(f"{name} is there more than once; the one nearest to the top counts")
            return
        if size > LARGEST:
            self.faults.append(f"{name} has more than {LARGEST >> 10} KB and is not taken")
            return
        content = read()
        if len(content) > LARGEST:
            self.faults.append(f"{name} has more than {LARGEST >> 10} KB and is not taken")
            return
        places[name], self.files[name] = depth, content


def collect(path: Path) -> Submission:
    """Reads a .cc file, a folder, a zip or a tar. Nothing is unpacked; links, devices and other names are not touched.

    Raises CourseError if there is no such path; a submission without files of the homework is one with a fault.
    """
    if not path.exists():
        raise CourseError(f"{path}: there is no such submission")
    submission = Submission(path.name if path.is_dir() or path.suffix == ".cc" else path.stem)
    try:
        if path.is_dir():
            collect_folder(path, submission)
        elif zipfile.is_zipfile(path):
            collect_zip(path, submission)
        elif tarfile.is_tarfile(path):
            collect_tar(path, submission)
        elif path.suffix == ".cc":
            collect_file(path, submission)
        else:
            submission.faults.append("this is no .cc file, folder, zip or tar")
    except (zipfile.BadZipFile, tarfile.TarError, EOFError, OSError, RuntimeError, NotImplementedError, ValueError) as error:
        submission.faults.append(f"it cannot be read: {error}")
    if not submission.files and not submission.faults:
        submission.faults.append(f"it holds none of {', '.join(homework_files())}")
    return submission


def collect_file(path: Path, submission: Submission) -> None:
    """A single file counts by its name, or by the name that its own begins with, such as "problem (2).cc"."""
    fitting = [name for name in homework_files() if path.name.startswith(Path(name).stem)]
    name = max(fitting, key=len, default=path.name)
    submission.take(name, path.stat().st_size, lambda: read_regular(path), {})


def collect_folder(folder: Path, submission: Submission) -> None:
    places = {}
    for count, member in enumerate(sorted(folder.rglob("*"))):
        if count >= MOST_MEMBERS:
            submission.faults.append(f"only its first {MOST_MEMBERS} members were looked at")
            return
        if stat.S_ISREG(member.lstat().st_mode):
            size = member.lstat().st_size
            submission.take(str(member.relative_to(folder)), size, lambda member=member: read_regular(member), places)


def read_regular(path: Path) -> bytes:
    with open(path, "rb") as file:
        return file.read(LARGEST + 1)


def collect_zip(path: Path, submission: Submission) -> None:
    places = {}
    with zipfile.ZipFile(path) as archive:
        for count, member in enumerate(archive.infolist()):
            if count >= MOST_MEMBERS:
                submission.faults.append(f"only its first {MOST_MEMBERS} members were looked at")
                return
            kind = stat.S_IFMT(member.external_attr >> 16)
            if kind not in (0, stat.S_IFREG):
                continue

            def read(member=member):
                with archive.open(member) as file:  # reads no more than is asked for, however much it unpacks to
                    return file.read(LARGEST + 1)
            submission.take(member.filename, member.file_size, read, places)


def collect_tar(path: Path, submission: Submission) -> None:
    places = {}
    with tarfile.open(path, "r|*") as archive:  # as a stream: nothing is sought, and little is held
        for count, member in enumerate(archive):
            if count >= MOST_MEMBERS or archive.offset > 64 * LARGEST * len(homework_files()):
                submission.faults.append("only its beginning was looked at; the archive is too large")
                return
            if member.isreg():
                submission.take(member.name, member.size,
                                lambda member=member: archive.extractfile(member).read(LARGEST + 1), places)
