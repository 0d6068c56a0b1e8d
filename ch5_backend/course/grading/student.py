"""./course pack student: the project as students get it. The solutions are in it as objects, as ./course run, the stages
that build on one another and the tests of the library need them, and so is what the judge knows to be right; what would show them
as text is left out. No grader links these objects, and a graded file can carry no code but C++: provenance.py."""

import gzip
import io
import platform
import posixpath
import re
import shutil
import subprocess
import tarfile
import tempfile
import zlib
from pathlib import Path

from ch5_backend.figures.atomic_write import atomic_write

from ..base import prebuilt
from ..base.cmake_build import BUILD, ROOT, build_or_fail
from ..base.errors import CourseError, warn
from .outputs import short_hash

from ..homework.make_skeleton import skeleton
from ..homework.regions import FILES, blanked, solution_text

TOP = "chapter5"  # the folder that the archive unpacks to
LEFT_OUT = (
    ".ci/", ".github/", "solutions/",
    "slides/",  # students read the PDFs, and the reading edition
    "ch5_homework/GRADING", "ch5_homework/INSTRUCTORS", "ch5_backend/experiments/EVIDENCE", "ch5_backend/experiments/evidence.json",
    "ch5_backend/course/grading/", "tests/grading/", "ch5_homework/judge/remote/",
    "tests/homework/workers.cmake", "tests/homework/wire_test.cc", "tests/homework/judge_and_worker_test.py",
    "tests/docs/", "tests/conventions/", "tests/sanitizers/", "tests/fuzz/", "tests/lab/", "tests/look/",  # of those who change the project
    # what fills the blanks, rightly or wrongly
    "ch5_homework/mistakes/", "ch5_backend/course/homework/samples.py", "tests/homework/samples", "tests/homework/run_samples.py",
    "tests/homework/reference.cmake", "tests/homework/answers_test.py",
    "tests/homework/end_to_end_test.py",
    "tests/homework/leftover_throw_test.py", "tests/homework/compiler_words_test.py", "tests/homework/languages_test.py")
KEPT = ("slides/figures/", "slides/reading/", "ch5_homework/mistakes/answers.csv")  # the picture of the front page; the lectures; mistakes' answers, as numbers
# Of the front page: the rows for graders, instructors and contributors, and how to build the slides.
NOT_GIVEN = re.compile(r"^(?:\|[^|\n]*\|[^|\n]*(?:ch5_homework/(?:GRADING|INSTRUCTORS)|\.github/CONTRIBUTING)\..*\n|`\./course slides`.*\n\n)", re.MULTILINE)
LINK = re.compile(r"(?<!!)\[([^\]\n]+)\]\((?!https?:)([^)#\s]+)(#[^)\s]*)?\)")
STORE = re.compile(r"ch5_backend/course/base/language/\w+\.json")
SYMBOL = re.compile(r"(?<!\w)_Z[\w$]+")
# As a label, as a weak name of one, or as the name of a group of which the linker takes one. A type is known by its name.
DEFINED = re.compile(r"^(_Z(?!T)[\w$]+)[\w$.]*:$|^\t\.weak\t(_Z(?!T)[\w$]+)$|,(_Z(?!T)[\w$]+),comdat$", re.MULTILINE)
GLOBAL = re.compile(r"^\t\.globl\t(\S+)$", re.MULTILINE)


def pack_student(path: Path, out: Path = ROOT / "out") -> None:
    """Writes the archive, with the pages built in OUT; the same files and compiler give the same bytes. Raises CourseError."""
    with atomic_write(path) as partial, open(partial, "wb") as file:  # first, so that a wrong place is refused before a build
        files = student_files(tracked_files(), compiled_solutions(), built_pages(out))
        write_tar(file, {f"{TOP}/{name}": content for name, content in files.items()})


def write_tar(file, files: dict) -> None:
    """{name: bytes}; the same files give the same bytes."""
    with gzip.GzipFile("", "wb", 9, file, mtime=0) as zipped, tarfile.open(fileobj=zipped, mode="w") as archive:
        for name in sorted(files):
            member = tarfile.TarInfo(name)
            member.size, member.mode = len(files[name]), 0o755 if files[name].startswith(b"#!") else 0o644
            archive.addfile(member, io.BytesIO(files[name]))


def tracked_files() -> dict:
    """{name: bytes} of what version control knows, and nothing that merely lies about, such as last year's submissions."""
    names = listed_by_git()
    if names is None:
        raise CourseError("only git knows which files are the project's, in a clone that is yours")
    return {name: (ROOT / name).read_bytes() for name in names if (ROOT / name).is_file()}


def listed_by_git(*options):
    """The project's files, or None without git, without a clone, or in another user's."""
    if not shutil.which("git"):
        return None
    done = subprocess.run(["git", "-C", str(ROOT), "ls-files", "-z", *options], capture_output=True, check=False)
    return None if done.returncode else done.stdout.decode("utf-8").split("\0")[:-1]


def compiled_solutions() -> dict:
    """{"solutions/problem.cc": its assembly}, also of what the judge knows to be right."""
    build_or_fail(["solutions_as_assembly"])
    names = [f"solutions/{name}" for name in FILES]
    names += sorted(str(path.relative_to(ROOT)) for path in (ROOT / "ch5_homework/judge/right").glob("*.cc"))
    return {name: (BUILD / f"{name}.s").read_text(encoding="utf-8") for name in names}


def built_pages(out: Path) -> dict:
    """{name: bytes} of the lab and the decks as PDF, as far as they are what their sources would give; says what is left out."""
    files = {}
    if why_not := prebuilt.why_not_lab(out):
        warn(f"{out / 'lab.html'} is left out: {why_not}; ./course lab makes it")
    else:
        files = {name: (out / name).read_bytes() for name in ("lab.html", prebuilt.RECORD)}
    stale = prebuilt.stale_decks(out)
    for deck in sorted(path.stem for path in (ROOT / "slides").glob("[0-9]-*.md")):
        if deck in stale:
            warn(f"{out / 'slides' / deck}.pdf is left out: {stale[deck]}; ./course slides makes it")
        else:
            files[f"slides/{deck}.pdf"] = (out / "slides" / f"{deck}.pdf").read_bytes()
    return files


def student_files(files: dict, compiled: dict, built: dict) -> dict:
    """{name: bytes} of the archive, from the project's files, the solutions' assembly and the built pages."""
    given = {name: content for name, content in files.items() if not name.startswith(LEFT_OUT) or name.startswith(KEPT)}
    given |= {**built, "solutions/made_for": f"{platform.system()} {platform.machine()}".encode()}
    for name in FILES:
        given[f"ch5_homework/{name}"] = skeleton(name).encode()  # whatever somebody has filled in
        given[f"solutions/{name}.blank"] = blanked(solution_text(name)).encode()
    for name in compiled:
        given.pop(name, None)
        given[name.removesuffix("cc") + "o"] = assembled(without_formulas(compiled[name]))
    for name in [name for name in given if STORE.fullmatch(name)]:  # mistakes' sentences, which a check tells when it is time
        given[name + ".z"] = zlib.compress(given.pop(name), 9)
    for name in given:
        if name.endswith(".md"):
            given[name] = without_dead_links(name, NOT_GIVEN.sub("", given[name].decode("utf-8")), given).encode()
    return given


def assembled(assembly: str) -> bytes:
    """An object, with no names but those that a linker needs."""
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "given.o"
        subprocess.run(["as", "-o", made, "-"], input=assembly.encode(), check=True)
        subprocess.run(["strip", "--strip-unneeded", made], check=True)
        return made.read_bytes()


def without_formulas(assembly: str) -> str:
    """A template's name spells out what it is applied to, type by type: what Eigen's expressions have become is called by
    numbers. The same for the same name, so that the linker still takes each once; and none that another object has, which
    may be compiled otherwise."""
    defined = {name for names in DEFINED.findall(assembly) for name in names}
    formulas = {name for name in defined - set(GLOBAL.findall(assembly)) if "5Eigen" in name}
    return SYMBOL.sub(lambda match: f"given_{short_hash(match[0])}" if match[0] in formulas else match[0], assembly)


def without_dead_links(name: str, text: str, files: dict) -> str:
    """A link to what the archive has not becomes its words."""
    return LINK.sub(lambda link: link[0] if posixpath.normpath(posixpath.join(posixpath.dirname(name), link[2])) in files else link[1], text)
