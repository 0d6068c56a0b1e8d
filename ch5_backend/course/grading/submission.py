"""What is taken from a submission: the homework's own files, by name, as bytes, and nothing else. What may hold an answer and
was not understood is named in `unread`: it is no mark, not even 0."""

import bz2
import gzip
import hashlib
import lzma
import mmap
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
ARCHIVES = (".zip", ".tar", ".tgz", ".gz", ".bz2", ".xz", ".rar", ".7z", ".zst", ".lzma")
SOURCES = (".cc", ".cpp", ".cxx", ".txt")
OTHER_KINDS = {b"Rar!\x1a\x07": "RAR", b"7z\xbc\xaf\x27\x1c": "7z", b"%PDF": "PDF", b"\xd0\xcf\x11\xe0": "Word"}  # by their first bytes
COMPRESSIONS = {b"\x1f\x8b": gzip.open, b"BZh": bz2.open, b"\xfd7zXZ": lzma.open}  # of a tar, by its first bytes


def refuse(arguments) -> None:
    """Raises CourseError where no submission is named and none was graded, or one is not there."""
    if not (arguments.submissions or arguments.list or arguments.prepare or arguments.class_file or arguments.rename
            or arguments.anonymous or arguments.earlier):
        raise CourseError("which submissions? Name files, folders, zips or tars; see ./course grade --help")
    for path in arguments.submissions:
        if not os.path.lexists(path):  # a link that leads nowhere is a submission, too
            raise CourseError(f"{path}: there is no such submission")


@dataclass
class Submission:
    """One student's work. `faults` are words for the student on what could not be taken, `unread` those of them behind which an
    answer may be."""
    name: str
    files: dict = field(default_factory=dict)   # {name: bytes}
    faults: list = field(default_factory=list)
    unread: list = field(default_factory=list)
    source: int = 0                             # of several paths, the newest first
    places: dict = field(default_factory=dict)  # {name: (whether misspelled, whether among solutions, depth, source)}
    found: dict = field(default_factory=dict)   # {name: {its path: digest}} of all at that place
    resembling: dict = field(default_factory=dict)  # {name: another one, found in its place}

    def key(self) -> str:
        """The same for the same content, independent of the student."""
        digest = hashlib.sha256()
        for name in sorted(self.files):
            digest.update(name.encode() + b"\0" + str(len(self.files[name])).encode() + b"\0" + self.files[name])
        return digest.hexdigest()

    def take(self, path: str, size: int, read) -> None:
        """Takes a member if it is one of the homework's files. Of two with one name, the one spelled right counts, then one that
        is not in a clone's folder solutions, then the one nearer to the top; of two with one path the last, as when unpacked.
        `read` is None where it is no usual file."""
        path = path.replace("\\", "/")  # as some programs on Windows write it into a zip
        given, folders = PurePosixPath(path).name, PurePosixPath(path).parts[:-1]
        name = meant(given)
        place = (given != name, "solutions" in folders, len(folders), self.source)
        if "__MACOSX" in folders or ".git" in folders:
            return
        if not name and (like := resembled(given)):
            self.resembling.setdefault(like, given)
        if given.lower().endswith(ARCHIVES):
            self.blame(sentence("submission.not_opened", file=short(given)), True)
        if not name:
            return
        if name in self.places and self.places[name] < place:
            self.blame(sentence("submission.file_twice", file=name))
            return
        try:
            content = read() if read and size <= LARGEST else None
        except Exception as error:  # encrypted, damaged: those behind it may be whole
            self.blame(sentence("submission.file_unreadable", file=name, reason=reason_of(error)), True)
            return
        if not read:
            self.blame(sentence("submission.file_no_file", file=name), True)
        elif content is None or len(content) > LARGEST:  # a size may lie
            self.blame(sentence("submission.file_too_large", file=name, n=LARGEST >> 10), True)
        else:
            if self.places.get(name) != place:
                self.found[name] = {}
            self.places[name], self.files[name] = place, content
            self.found[name][path] = hashlib.sha256(content).digest()

    def settle(self) -> None:
        """Of different files at places of equal rank none counts: nobody can tell which is meant."""
        for name, digests in self.found.items():
            if several := len(set(digests.values())) > 1:
                del self.files[name]
            if len(digests) > 1:
                one, other = list(digests)[:2]
                self.blame(sentence("submission.several", file=name, one=short(one), other=short(other)) if several else
                           sentence("submission.file_twice", file=name), several)

    def blame(self, fault: dict, unread: bool = False) -> None:
        """Says a fault once, though an archive may have it ten thousand times."""
        if fault not in self.faults:
            self.faults.append(fault)
            self.unread += [fault] * unread


def short(name: str) -> dict:
    return {"quoted": plain(name)[:80]}


def collect(*paths: Path) -> Submission:
    """Reads source files, folders, zips and tars, of one student. Nothing is unpacked; links, devices and other names are not
    touched. An archive in a folder is opened, one in an archive is not.

    Raises CourseError if there is no such path; a submission without files of the homework is one with a fault.
    """
    first = paths[0]
    for path in paths:
        if not os.path.lexists(path):
            raise CourseError(f"{path}: there is no such submission")
    submission = Submission(first.name if first.is_dir() or is_source(first) else first.stem)
    for submission.source, path in enumerate(paths):
        if len(paths) == 1 or is_source(path) or path.name.lower().endswith(ARCHIVES):  # beside others, a report is not one
            collect_path(path, submission)
    submission.settle()
    for name, found in sorted(submission.resembling.items()):
        taken = name in submission.files
        submission.blame(sentence("submission.beside" if taken else "submission.resembling", file=name, found=short(found)), not taken)
    if not submission.files and not submission.unread:
        submission.blame(sentence("submission.holds_nothing", files=", ".join(FILES)), True)
    return submission


def is_source(path: Path) -> bool:
    return path.suffix.lower() in SOURCES


def collect_path(path: Path, submission: Submission, above: str = "") -> None:
    try:
        kind = path.lstat()
        if stat.S_ISDIR(kind.st_mode):
            collect_members(list_folder(path), submission)
            for member in archives_in(path):
                collect_path(member, submission, f"{member.relative_to(path)}/")
        elif not stat.S_ISREG(kind.st_mode):  # a link may lead anywhere, a pipe may never end
            submission.blame(sentence("submission.link_or_device"), True)
        elif is_source(path):
            collect_file(path, submission)
        elif kind.st_size > LARGEST_ARCHIVE:
            submission.blame(sentence("submission.too_large", n=LARGEST_ARCHIVE >> 20), True)
        elif other := other_kind(path):
            submission.blame(sentence("submission.other_kind", file=short(path.name), kind=other), True)
        else:
            members = list_zip(path) if zipfile.is_zipfile(path) else list_tar(path)
            collect_members(((above + name, size, read) for name, size, read in members), submission)
    except Exception as error:  # whatever an archive holds that Python's modules do not expect
        submission.blame(sentence("submission.unreadable", file=short(path.name), reason=reason_of(error)), True)


def reason_of(error: Exception):
    return error.message if isinstance(error, CourseError) else plain(str(error))


def archives_in(folder: Path):
    for _, member in zip(range(MOST_MEMBERS), sorted(folder.rglob("*"))):
        if member.name.lower().endswith(ARCHIVES) and "__MACOSX" not in member.parts and stat.S_ISREG(member.lstat().st_mode):
            yield member


def other_kind(path: Path) -> str:
    """What a file is that nothing here opens, in a word; "" of a zip or tar."""
    with open(path, "rb") as file:
        first = file.read(8)
    if zipfile.is_zipfile(path) and zip_has_too_many(path):
        raise CourseError(sentence("submission.too_many_members", n=MOST_MEMBERS))
    return next((kind for magic, kind in OTHER_KINDS.items() if first.startswith(magic)), "")


def zip_has_too_many(path: Path) -> bool:
    """By its entries' signatures: Python's module holds all of them in memory before the first is seen."""
    with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        at = -1
        for _ in range(20 * MOST_MEMBERS):
            if (at := content.find(b"PK\1\2", at + 1)) < 0:
                return False
    return True


def handed_in(*paths: Path) -> str:
    """When the newest was last written, as far as the file or what lies in the folder says, else now; a copy may have another
    time."""
    try:
        members = [member for path in paths if path.is_dir() for _, member in zip(range(MOST_MEMBERS), path.rglob("*"))]
        times = [member.lstat().st_mtime for member in members if meant(member.name) or resembled(member.name) or member.name.lower().endswith(ARCHIVES)]
        when = datetime.fromtimestamp(max(times or [path.lstat().st_mtime for path in paths])).astimezone()
    except (OSError, ValueError, OverflowError):  # folders too deep for a path, a year that no calendar has
        when = datetime.now().astimezone()
    return when.isoformat(timespec="seconds")


def collect_file(path: Path, submission: Submission) -> None:
    """A single file counts by its name, or by the beginning of its name, such as "problem (2).cc", with Canvas after
    student and numbers, "doejane_12345_678_problem-1.cc"."""
    given = path.name.lower()
    names = (given, re.sub(r"^\w+_\d+_\d+_", "", given), re.sub(r"^.*_assignsubmission_file_", "", given))
    fitting = [name for name in FILES if any(given.startswith(Path(name).stem) for given in names)]
    name = max(fitting, key=len, default=min(names, key=len))
    submission.take(name, path.stat().st_size, lambda: read_regular(path))


def collect_members(members, submission: Submission) -> None:
    """Takes from (path, size, read) of each member, without a read where it is no usual file."""
    for count, (path, size, read) in enumerate(members):
        if count >= MOST_MEMBERS:
            submission.blame(sentence("submission.too_many_members", n=MOST_MEMBERS), True)
            return
        submission.take(path, size, read)


def list_folder(folder: Path):
    """Its files without archives, which are opened."""
    for member in sorted(folder.rglob("*")):
        kind = member.lstat()
        if not (member.name.lower().endswith(ARCHIVES) and stat.S_ISREG(kind.st_mode)):
            yield str(member.relative_to(folder)), kind.st_size, partial(read_regular, member) if stat.S_ISREG(kind.st_mode) else None


def read_regular(path: Path) -> bytes:
    with open(path, "rb") as file:
        return file.read(LARGEST + 1)


def list_zip(path: Path):
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist():
            usual = stat.S_IFMT(member.external_attr >> 16) in (0, stat.S_IFREG) and \
                member.compress_type in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
            yield member.filename, member.file_size, partial(read_in_zip, archive, member) if usual else None


def read_in_zip(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> bytes:
    if member.flag_bits & 1:
        raise CourseError(sentence("submission.encrypted"))
    with archive.open(member) as file:  # reads no more than requested, however much it unpacks to
        return file.read(LARGEST + 1)


def list_tar(path: Path):
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
