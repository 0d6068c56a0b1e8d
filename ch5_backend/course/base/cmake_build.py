"""Configures and builds the project out of source, in Release, in build/release."""

import os
import re
import shutil
import subprocess
from contextlib import contextmanager
from pathlib import Path

from .processes import running
from .errors import CourseError
from .language import sentence
from .output_dir import hold
from .progress import Progress

for name in ("CH5_BUILD_DIR", "CH5_DATA_DIR", "CH5_HOMEWORK_DIR"):
    if os.environ.get(name):  # relative to the user's folder; ctest and what it starts run elsewhere
        os.environ[name] = os.path.abspath(os.environ[name])

ROOT = Path(__file__).resolve().parents[3]
CXX = os.environ.get("CXX", "").split()  # the compiler that the user asks for, perhaps with a launcher or flags


def build_folder() -> Path:
    """Each compiler that CXX names has a folder of its own, so that no folder holds objects of two compilers."""
    suffix = "".join("-" + re.sub(r"[^\w.+-]", "_", Path(word).name) for word in CXX)
    return Path(os.environ.get("CH5_BUILD_DIR") or ROOT / "build" / f"release{suffix}")


BUILD = build_folder()
HOMEWORK = Path(os.environ.get("CH5_HOMEWORK_DIR") or ROOT / "ch5_homework")  # the student's files
BIN = BUILD / "bin"
CORES = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def configure() -> None:
    """Runs CMake if the build folder is new, was made elsewhere or by another compiler, or should read other data.

    Raises CourseError with CMake's first error and the log's name; or for another checkout's folder in CH5_BUILD_DIR.
    """
    wanted, cached = _cache_entries(), cached_entries(BUILD)
    if was_moved(cached) and os.environ.get("CH5_BUILD_DIR"):  # it may be in use there
        raise CourseError(f"CH5_BUILD_DIR names {BUILD}, which was made by {cached['CMAKE_HOME_DIRECTORY']}; name another folder")
    if _is_foreign(cached):
        shutil.rmtree(BUILD)
    elif (BUILD / "build.ninja").exists() and wanted.items() <= cached.items() and not _lacks_a_part(cached):
        return
    with Progress("configure") as progress, build_lock():
        command = ["cmake", "--preset", "release", "-B", str(BUILD), *(f"-D{key}={value}" for key, value in wanted.items())]
        done = run_logged(command, "configure.log", lambda line: progress.step("…"))  # CMake's own words are in the log
    if done.returncode:
        raise failure("CMake could not configure the project", done.stdout, r"CMake Error|[Ee]rror", "configure.log")


def _is_foreign(cached: dict) -> bool:
    """Whether CMake would refuse this folder, or go on with another compiler than the one asked for."""
    if was_moved(cached):
        return True
    compiler = cached.get("CMAKE_CXX_COMPILER")
    return bool(CXX and compiler) and shutil.which(CXX[0]) != shutil.which(compiler)


def was_moved(cached: dict) -> bool:
    """Whether a build folder with this cache was made when the project was elsewhere."""
    return cached.get("CMAKE_HOME_DIRECTORY", str(ROOT)) != str(ROOT)


def _lacks_a_part(cached: dict) -> bool:
    """Whether GoogleTest, OpenCV, libpng or libjpeg has been installed since CMake did not find it."""
    headers = {"GTest_DIR": "gtest/gtest.h", "CH5_OPENCV_INCLUDE": "opencv4/opencv2/video/tracking.hpp",
               "CH5_PNG_INCLUDE": "png.h", "CH5_JPEG_INCLUDE": "jpeglib.h"}
    return any(cached.get(entry, "").endswith("-NOTFOUND") and Path("/usr/include", header).exists()
               for entry, header in headers.items())


def build(targets=()) -> subprocess.CompletedProcess:
    """Builds the targets (default: all); configures first if needed.

    Returns what ninja returned and all that it printed, in stdout; a failed build is not an exception here, but a full disk is:
    it is no fault of the code.
    """
    configure()
    with Progress("build") as progress, build_lock():
        done = run_logged(["ninja", "-C", str(BUILD), "-j", str(CORES), *targets], "build.log", progress.ninja_step)
    full = re.search("^.*No space left on device.*$", done.stdout, re.M)
    if done.returncode and full:
        raise CourseError(sentence("compiler.disk_full", line=full[0].strip()))
    return done


def build_or_fail(targets=()) -> None:
    """Builds the targets; raises CourseError with the first error and the log's name."""
    done = build(targets)
    if done.returncode:
        raise failure("the build failed", done.stdout, r"error:|^FAILED|ninja: error", "build.log")


def data_folder() -> Path:
    """Where the recordings and large problems are: as the environment says, or as the configured build knows it."""
    configured = cached_entries(BUILD).get("CH5_DATA_DIR")
    return Path(os.environ.get("CH5_DATA_DIR") or configured or ROOT.parent / "shared" / "data")


def run_logged(command, log_name: str, step) -> subprocess.CompletedProcess:
    """Runs a command in ROOT, keeps its output (both streams) in BUILD/log_name, hands each line to `step`."""
    BUILD.mkdir(parents=True, exist_ok=True)
    lines = []
    with open(BUILD / log_name, "w", encoding="utf-8", buffering=1) as log:
        english = {**os.environ, "LC_ALL": "C.UTF-8"}  # compiler.py knows a compiler's words in this language
        with running(command, cwd=ROOT, env=english, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                     text=True, errors="replace", bufsize=1) as process:
            for line in process.stdout:
                lines.append(line)
                log.write(line)
                if line.strip():
                    step(line.strip())
    return subprocess.CompletedProcess(command, process.wait(), "".join(lines))


def failure(what: str, output: str, pattern: str, log_name: str) -> CourseError:
    lines = output.splitlines()
    first = next((i for i, line in enumerate(lines) if re.search(pattern, line)), max(0, len(lines) - 6))
    shown = "\n".join("  " + line for line in lines[first:first + 6])
    return CourseError(f"{what}; the first error is\n{shown}\nThe whole log: {BUILD / log_name}", exit_code=1)


def _cache_entries() -> dict:
    """What the environment asks CMake for; without it CMake's own default holds, and the homework of this folder.

    CMake itself reads CXX, in a new folder.
    """
    entries = {"CH5_HOMEWORK_DIR": str(HOMEWORK)}
    if data := os.environ.get("CH5_DATA_DIR"):
        entries["CH5_DATA_DIR"] = data
    return entries


def cached_entries(folder: Path) -> dict:
    """The entries of the folder's CMakeCache.txt; none if there is no cache."""
    try:
        text = (folder / "CMakeCache.txt").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return {}
    return dict(re.findall(r"^([^#/\s][^:\n]*):[A-Z]+=(.*)$", text, re.MULTILINE))


@contextmanager
def build_lock():
    """Two ./course at once must not write the same build folder; the second one waits."""
    try:
        BUILD.mkdir(parents=True, exist_ok=True)
        file = open(BUILD / ".lock", "w", encoding="utf-8")
    except OSError as error:
        raise CourseError(sentence("compiler.no_folder", folder=str(BUILD))) from error
    with file:
        hold(file, "builds")
        yield
