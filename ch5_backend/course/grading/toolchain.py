"""Compiles a file of a submission and links it with the worker of its stages, all inside the sandbox."""

import hashlib
import json
import math
import os
import re
import shutil
import stat
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from ch5_backend.figures.atomic_write import write_whole

from ..base.cmake_build import BUILD, build_or_fail
from ..base.errors import CourseError
from ..homework.compiler import does_not_compile
from ..homework.diagnosis import Verdict, because
from ..homework.make_skeleton import skeleton
from ..homework.regions import fill, solution_text
from ..base.scratch import scratch
from . import likeness, provenance
from .outputs import short_hash
from .sandbox import MIB, Limits

# A compiler needs two seconds and half a gigabyte for the solutions.
COMPILING = Limits(seconds=30, wall_seconds=120.0, memory=3072 * MIB, processes=16, file_size=128 * MIB)
COMPILERS_SECONDS = 60.0  # of the processor, for all compilations of a submission; the solutions need twelve
COMPILERS_WALL = 120.0
MADE_SIZE = 16 * MIB  # of what the first step writes, which is then read word by word; the largest solution has 6 MB
# In a separate process, so that the driver survives a crash of the compiler and reports it.
MAKES, MADE = (("-S", "-emit-llvm", "-fno-integrated-cc1"), ("-E",)), ("/out/made.ll", "/out/made.ii")
LONGEST_LINE = 2000  # of the compiler's words: patterns take the square of it
# The compiler's or the linker's own words about the file that it was given.
BLAMES_THE_FILE = re.compile(r"[Ee]rror: |undefined reference|multiple definition|terminated by signal|out of memory|"
                             r"virtual memory exhausted|File size limit|PLEASE submit a (full )?bug report")


class Infrastructure(Exception):
    """Something of ours has failed, and says nothing about the submission."""


@dataclass
class Clock:
    """The time that a submission has left [s]: its checks' processor time; its compilers' processor time and wall time.
    If only wall time has run out, the machine is to blame."""
    left: float = 240.0  # its checks need 193 where a loop in each stage does not end
    compiler: float = COMPILERS_SECONDS
    wall: float = COMPILERS_WALL


def stalled(seconds: float) -> str:
    return (f"the machine was too busy, or stopped: in {seconds:g} s it gave the compiler too little of its processor. "
            "The same command judges this submission again")


class Built(NamedTuple):
    """`verdict` is the reason where there is no worker; `functions` are its own (likeness.py), None of the second compiler."""
    worker: Path
    verdict: Verdict
    cpu_seconds: float
    peak_mib: float
    functions: dict = None


class Toolchain:
    """What ch5_homework/judge/remote/grader.cmake has made: compilers, precompiled header, archives, judge."""

    def __init__(self, box):
        self.box = box
        build_or_fail(["homework_grader"])
        table = json.loads((BUILD / "grader" / "toolchain.json").read_text(encoding="utf-8"))
        self.compilers, self.judge = table["compile"], Path(table["judge"])
        self.include, self.archives = Path(table["include"]), Path(table["archives"])
        self.header, self.object = map(Path, table["precompiled"])
        self.digest, self._usual = self._digest(), None
        self._copies = None if everyone_reaches(self.include) else tempfile.TemporaryDirectory(dir=scratch())
        if self._copies and box.name == "landlock":
            raise CourseError(f"only root may enter a folder on the way to {self.include}: the sandbox landlock cannot show it "
                              "elsewhere, so the project must lie where others may read it. Nothing was run.")

    def _digest(self) -> str:
        """Changes with whatever a verdict may depend on."""
        digest = hashlib.sha256(json.dumps(self.compilers).encode())
        for path in [self.judge, self.object, *sorted(self.archives.glob("libworker_*.a"))]:
            with open(path, "rb") as file:
                for piece in iter(lambda: file.read(MIB), b""):
                    digest.update(piece)
        return digest.hexdigest()[:16]

    def _seen(self, path: Path) -> Path:
        """The file or folder where the sandbox's user can read it: a copy, if the project lies in a closed folder."""
        if self._copies is None:
            return path
        os.chmod(self._copies.name, 0o755)
        copy = Path(self._copies.name) / path.name
        if not copy.exists():
            shutil.copytree(path, copy) if path.is_dir() else shutil.copyfile(path, copy)
        return copy

    def prepare(self) -> None:
        """Compiles an empty file and runs a program from the same place, so that a fault of ours is found before any submission
        is blamed."""
        with tempfile.TemporaryDirectory(dir=scratch()) as folder:
            for compiler in self.compilers:
                outcome = self._run([*compiler, "-c", "/submission/empty.cc", "-o", "/out/empty.o"], "empty.cc", b"",
                                    Path(folder), ())
                if outcome.exit_code:
                    raise Infrastructure(f"{compiler[0]} does not compile an empty file: "
                                         f"{outcome.output.strip() or 'it was stopped; the machine may be too busy'}")
            worker = shutil.copy(shutil.which("true"), Path(folder) / "out" / "worker")
            outcome = self.box({"/worker": worker}).run(["/worker"])
            if outcome.exit_code:
                raise Infrastructure(f"no program can be run in {scratch().parent}, perhaps mounted as noexec: "
                                     f"{outcome.output.strip()}; TMPDIR names another place")

    def compile(self, file: str, content: bytes, folder: Path, clock=None) -> Built:
        """The worker of this file in `folder`, which is the caller's to remove. `clock` has what is left of the submission's time
        for all its compilations. A compiler works in two steps, between which provenance.py looks at what it has made. Raises
        Infrastructure."""
        clock = clock or Clock()
        name = Path(file).stem
        archives = [self.archives / f"libworker_{name}.a", self.archives / f"libworker_layers_{name}.a"]
        # Of the header's functions only those in use are linked; the others call layers that this worker has not.
        rest = [str(self.object), "-Wl,--whole-archive", str(archives[0]), "-Wl,--no-whole-archive", str(archives[1]),
                "-lpthread", "-Wl,--gc-sections"]
        cpu, peak, code = 0.0, 0.0, ""
        for number in range(len(self.compilers)):
            if clock.compiler <= 0.0:
                return Built(None, Verdict("does-not-compile", because("compiler.took_too_long_in_all", n=f"{COMPILERS_SECONDS:g}")), cpu, peak)
            if clock.wall <= 0.0:
                raise Infrastructure(stalled(COMPILERS_WALL))
            for step, most in ((self._first_step(number, file), MADE_SIZE), (self._second_step(number, rest[number:]), COMPILING.file_size)):
                limits = COMPILING._replace(file_size=most, seconds=max(1, min(COMPILING.seconds, math.ceil(clock.compiler))),
                                            wall_seconds=max(1.0, min(COMPILING.wall_seconds, clock.wall)))
                begin = time.monotonic()
                outcome = self._run(step, file, content, folder, (self.object, *archives), limits)
                clock.compiler, clock.wall = clock.compiler - outcome.cpu_seconds, clock.wall - (time.monotonic() - begin)
                if outcome.stalled:
                    raise Infrastructure(stalled(limits.wall_seconds))
                cpu, peak = cpu + outcome.cpu_seconds, max(peak, outcome.peak_mib)
                if outcome.exit_code or not outcome.in_time:
                    break
                if most == MADE_SIZE:
                    begin = time.thread_time()
                    code = read_made(folder / "out" / Path(MADE[number]).name)
                    refused = self._refused(number, code, folder / "out")
                    clock.compiler -= time.thread_time() - begin  # what reads for long is no less of the submission's doing
                    if refused:
                        return Built(None, Verdict("does-not-compile", refused), cpu, peak)
            worker = folder / "out" / "worker"
            if outcome.exit_code == 0 and worker.is_file() and not worker.is_symlink():
                return Built(taken_over(worker), None, cpu, peak, None if number else likeness.functions_in(code))
            if not outcome.in_time:  # a second compiler would take as long
                break
        return Built(None, self._verdict(file, outcome, content, folder / "submission"), cpu, peak)

    def _first_step(self, number: int, file: str) -> list:
        """Clang's ends with intermediate code, GCC's with preprocessed text."""
        return [*self.compilers[number], *MAKES[number], f"/submission/{file}", "-MD", "-MF", "/out/rule", "-o", MADE[number]]

    def _second_step(self, number: int, rest: list) -> list:
        compiler = self.compilers[number]
        before = compiler[:-2] if "-include" in compiler else compiler  # what it names is in the text already
        return [*before, MADE[number], *rest, "-Wl,-z,noexecstack", "-o", "/out/worker"]

    def solved(self, file: str) -> dict:
        """{function: hash} of those functions of the solution that a student writes lines of."""
        texts = fill(solution_text(file), lambda region: region.solution), skeleton(file)
        path = BUILD / "grader" / f"solved.{short_hash(self.digest + ''.join(texts))}.json"
        with suppress(OSError, ValueError):  # it takes a second a file
            return json.loads(path.read_text(encoding="utf-8"))
        solved, begun = (likeness.functions_in(self._made(0, file, text.encode())) for text in texts)
        found = {name: its for name, its in solved.items() if begun.get(name) != its}
        with suppress(OSError):
            write_whole(path, json.dumps(found))
        return found

    def _made(self, number: int, file: str, content: bytes) -> str:
        """What the first step makes of a text of ours."""
        with tempfile.TemporaryDirectory(dir=scratch()) as folder:
            self._run(self._first_step(number, file), file, content, Path(folder), ())
            return read_made(Path(folder) / "out" / Path(MADE[number]).name)

    def _refused(self, number: int, code: str, out: Path):
        """Why what the first step has made may not be linked, or None."""
        if number and self._usual is None:
            self._usual = provenance.usual_code(self._made(number, "empty.cc", b""))
        if word := provenance.foreign_code(code, number == 0, self._usual or frozenset()):
            return because("compiler.machine_code", word=word)
        given = out.with_name("submission")  # without a sandbox, in which it has another name
        own = tuple(f"{path}{end}" for path, end in ((self.include, "/"), (self.header, ""), (given, "/"), (given.resolve(), "/")))
        if other := provenance.foreign_file(read_made(out / "rule"), own):
            return because("compiler.foreign_file", file={"quoted": other[:200]})
        return None

    def _verdict(self, file: str, outcome, content: bytes, given: Path) -> Verdict:
        require_room()
        words = outcome.output
        for folder in (f"{given}/", "/submission/", f"{self.include}/"):  # without a sandbox the first
            words = words.replace(folder, "")
        words = "\n".join(line[:LONGEST_LINE] for line in words.splitlines())
        if not outcome.in_time:
            return Verdict("does-not-compile", because("compiler.took_too_long", n=COMPILING.seconds))
        if not BLAMES_THE_FILE.search(outcome.output):  # in whole lines: #line gives files names of any length
            raise Infrastructure(f"the compiler ended with code {outcome.exit_code}: {words.strip()[-500:]}")
        return does_not_compile(file, words, content)

    def _run(self, command: list, file: str, content: bytes, folder: Path, more: tuple, limits: Limits = COMPILING):
        """One run of a compiler, which sees this file, the headers and `more`, and writes into folder/out."""
        given, out = folder / "submission", folder / "out"
        for place, mode in ((folder, 0o750), (given, 0o750), (out, 0o770)):
            place.mkdir(exist_ok=True)
            os.chown(place, -1, self.box.group())
            os.chmod(place, mode)
        (given / file).write_bytes(content)
        os.chmod(given / file, 0o644)
        bound = [self.include, self.header, *more]
        box = self.box({"/submission": given, **{str(path): self._seen(path) for path in bound}}, {"/out": out}, limits)
        return box.run(command)


def taken_over(worker: Path) -> Path:
    """The file as the grader's own, in the folder above, and the rest of its folder closed: an owner may change mode, times and
    attributes, and so leave word to the next check."""
    os.chmod(worker.parent, 0o700)
    worker = worker.rename(worker.parents[1] / "worker")
    os.chown(worker, os.geteuid(), os.getegid())
    os.chmod(worker, 0o755)
    return worker


def read_made(path: Path) -> str:
    """What a compiler has written, if it is a usual file: it may be somebody else's, who has taken over the compiler."""
    with open(os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK), encoding="utf-8", errors="replace") as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise OSError(f"{path} is no usual file")
        return file.read()


def require_room() -> None:
    """Raises Infrastructure where the disk is full: who did not compile there, or left no report, may have been right."""
    free = shutil.disk_usage(scratch()).free
    if free < COMPILING.file_size:
        raise Infrastructure(f"{scratch().parent} has {free // MIB} MB left, and {COMPILING.file_size // MIB} MB are needed; "
                             "TMPDIR names another place")


def everyone_reaches(path: Path) -> bool:
    """Whether another user may enter all folders on the way."""
    return os.geteuid() != 0 or all(folder.stat().st_mode & 0o005 == 0o005 for folder in [path, *path.resolve().parents])
