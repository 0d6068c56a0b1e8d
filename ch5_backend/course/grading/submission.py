"""What is taken from a submission: the homework's own files, by name, as bytes, and nothing else."""

import bz2
import gzip
import hashlib
import lzma
import os
import re
import stat
import tarfile
import zipfile
from dataclasses import dataclass, field
from datetime import datetime
from functools import partial
from pathlib import Path, PurePosixPath

from ..base.errors import CourseError
from ..base.language import sentence
from ..homework.names import meant, resembled
from ..homework.regions import FILES
from .outputs import plain

LARGEST = 256 << 10       # bytes of a file; the largest solution has 20,000
LARGEST_ARCHIVE = 64 << 20  # bytes, and of what a tar unpacks to
MOST_MEMBERS = 10_000     # of an archive or folder that are looked at
COMPRESSIONS = {b"\x1f\x8b": gzip.open, b"BZh": bz2.open, b"\xfd7zXZ": lzma.open}  # of a tar, by its first bytes


def refuse(arguments) -> None:
    """Raises CourseError where no submission is named, or one is not there."""
    if not arguments.submissions and not arguments.prepare:
        raise CourseError("which submissions? Name files, folders, zips or tars; see ./course grade --help")
    for path in arguments.submissions:
        if not os.path.lexists(path):  # a link that leads nowhere is a submission, too
            raise CourseError(f"{path}: there is no such submission")


@dataclass
class Submission:
    """One student's work. `faults` are words for the student on what could not be taken."""
    name: str
    files: dict = field(default_factory=dict)   # {name: bytes}
    faults: list = field(default_factory=list)
    resembling: dict = field(default_factory=dict)  # {name: another one, found in its place}

    def key(self) -> str:
        """The same for the same content, whoever hands it in."""
        digest = hashlib.sha256()
        for name in sorted(self.files):
            digest.update(name.encode() + b"\0" + str(len(self.files[name])).encode() + b"\0" + self.files[name])
        return digest.hexdigest()

    def take(self, path: str, size: int, read, places: dict) -> None:
        """Takes a member if it is one of the homework's files. Of two with one name, the one spelled right counts, or the one
        nearer to the top."""
        path = path.replace("\\", "/")  # as some programs on Windows write it into a zip
        given, depth = PurePosixPath(path).name, len(PurePosixPath(path).parts)
        name = meant(given)
        place = (given != name, depth)
        if not name and (like := resembled(given)):
            self.resembling.setdefault(like, given)
        if not name or "__MACOSX" in path:
            return
        if name in places and places[name] <= place:
            self.blame(sentence("submission.file_twice", file=name))
            return
        content = read() if size <= LARGEST else None
        if content is None or len(content) > LARGEST:  # a size may lie
            self.blame(sentence("submission.file_too_large", file=name, n=LARGEST >> 10))
            return
        places[name], self.files[name] = place, content

    def blame(self, fault: dict) -> None:
        """Says a fault once, though an archive may have it ten thousand times."""
        if fault not in self.faults:
            self.faults.append(fault)


def collect(path: Path) -> Submission:
    """Reads a source file, a folder, a zip or a tar. Nothing is unpacked; links, devices and other names are not touched.

    Raises CourseError if there is no such path; a submission without files of the homework is one with a fault.
    """
    if not os.path.lexists(path):
        raise CourseError(f"{path}: there is no such submission")
    is_source = path.suffix.lower() in (".cc", ".cpp", ".cxx", ".txt")
    submission = Submission(path.name if path.is_dir() or is_source else path.stem)
    try:
        kind = path.lstat()
        if stat.S_ISDIR(kind.st_mode):
            collect_members(in_folder(path), submission)
        elif not stat.S_ISREG(kind.st_mode):  # a link may lead anywhere, a pipe may never end
            submission.faults.append(sentence("submission.link_or_device"))
        elif is_source:
            collect_file(path, submission)
        elif kind.st_size > LARGEST_ARCHIVE:
            submission.faults.append(sentence("submission.too_large", n=LARGEST_ARCHIVE >> 20))
        elif zipfile.is_zipfile(path):
            collect_members(in_zip(path), submission)
        else:
            collect_members(in_tar(path), submission)
    except Exception as error:  # whatever an archive holds that Python's modules do not expect
        reason = error.message if isinstance(error, CourseError) else plain(str(error))
        submission.faults.append(sentence("submission.unreadable", reason=reason))
    for name in sorted(submission.resembling.keys() - submission.files.keys()):
        submission.faults.append(sentence("submission.resembling", file=name, found={"quoted": plain(submission.resembling[name])}))
    if not submission.files and not submission.faults:
        submission.faults.append(sentence("submission.holds_nothing", files=", ".join(FILES)))
    return submission


def handed_in(path: Path) -> str:
    """When it was last written, as far as the file or what lies in the folder says, else now; a copy may have another time."""
    try:
        members = [member for count, member in zip(range(MOST_MEMBERS), path.rglob("*"))] if path.is_dir() else []
        times = [member.lstat().st_mtime for member in members if meant(member.name)]
        when = datetime.fromtimestamp(max(times, default=path.lstat().st_mtime)).astimezone()
    except (OSError, ValueError, OverflowError):  # folders too deep for a path, a year that no calendar has
        when = datetime.now().astimezone()
    return when.isoformat(timespec="seconds")


def collect_file(path: Path, submission: Submission) -> None:
    """A single file counts by its name, or by the name that its own begins with, such as "problem (2).cc", in Canvas behind
    student and numbers, "doejane_12345_678_problem-1.cc"."""
    names = (path.name.lower(), re.sub(r"^\w+_\d+_\d+_", "", path.name.lower()))
    fitting = [name for name in FILES if any(given.startswith(Path(name).stem) for given in names)]
    name = max(fitting, key=len, default=path.name)
    submission.take(name, path.stat().st_size, lambda: read_regular(path), {})


def collect_members(members, submission: Submission) -> None:
    """Takes from (path, size, read) of each member, without a read where it is no usual file."""
    places = {}
    for count, (path, size, read) in enumerate(members):
        if count >= MOST_MEMBERS:
            submission.faults.append(sentence("submission.too_many_members", n=MOST_MEMBERS))
            return
        if read:
            submission.take(path, size, read, places)


def in_folder(folder: Path):
    for member in sorted(folder.rglob("*")):
        kind = member.lstat()
        yield str(member.relative_to(folder)), kind.st_size, partial(read_regular, member) if stat.S_ISREG(kind.st_mode) else None


def read_regular(path: Path) -> bytes:
    with open(path, "rb") as file:
        return file.read(LARGEST + 1)


def in_zip(path: Path):
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist():
            usual = stat.S_IFMT(member.external_attr >> 16) in (0, stat.S_IFREG) and \
                member.compress_type in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
            yield member.filename, member.file_size, partial(read_in_zip, archive, member) if usual else None


def read_in_zip(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> bytes:
    with archive.open(member) as file:  # reads no more than is asked for, however much it unpacks to
        return file.read(LARGEST + 1)


def in_tar(path: Path):
    with open(path, "rb") as file:
        first = file.read(6)
    unpack = next((unpack for magic, unpack in COMPRESSIONS.items() if first.startswith(magic)), open)
    # As a stream: nothing is sought, and little is held.
    with unpack(path, "rb") as file, tarfile.open(fileobj=Bounded(file), mode="r|") as archive:
        for member in archive:
            yield member.name, member.size, (lambda: archive.extractfile(member).read(LARGEST + 1)) if member.isreg() else None


class Bounded:
    """A stream that refuses to give more than an archive may hold, or to be asked for more: also a member's name or padding
    can be a bomb, and one that claims a petabyte is skipped by reading on behind the end."""

    def __init__(self, file):
        self.file, self.left = file, LARGEST_ARCHIVE

    def read(self, size: int) -> bytes:
        self.left -= size
        if self.left < 0:
            raise CourseError(sentence("submission.unpacks_too_large", n=LARGEST_ARCHIVE >> 20))
        return self.file.read(size)
