"""./course lab: the course's C++ as WebAssembly, in one page that needs nothing else; the students' archive has the page."""

import os
import re
import shlex
import shutil
from pathlib import Path

from ch5_backend.figures.atomic_write import write_whole

from ..base import prebuilt
from ..base.cmake_build import BUILD, CORES, ROOT, cached_entries, failure, run_logged, was_moved
from ..base.errors import CourseError, warn
from ..base.output_dir import made_dir
from ..base.progress import Progress

PAGE = ROOT / "ch5_backend" / "lab" / "page"
WASM = BUILD.parent / "wasm"
SCRIPTS = [PAGE / f"{name}.js" for name in ("draw", "formulas", "scene", "challenges", "state", "panels", "game", "ask", "tasks", "main")]
MOST_BYTES = 3_000_000


def lab(folder: str) -> int:
    """Writes FOLDER/lab.html, and beside it what it was made of; raises CourseError if emscripten is missing or the build fails."""
    if not (ROOT / "solutions" / "problem.cc").exists():  # assembly for one processor is no source for another
        return given()
    out, sources = Path(folder or "out"), prebuilt.lab_sources()  # as they are when the work begins
    with made_dir(out):
        page = assemble(build_wasm())
        if len(page.encode()) > MOST_BYTES:
            raise CourseError(f"the page has {len(page.encode())} bytes, more than {MOST_BYTES}", 1)
        write_whole(out / "lab.html", page)
    prebuilt.record_lab(out, sources)
    print(f"The lab: {out / 'lab.html'}")
    return 0


def given() -> int:
    """The page that came with the students' archive; says so if the library is no longer the one that it was made of.

    Raises CourseError if there is none.
    """
    page = ROOT / "lab.html"
    if not page.exists():
        raise CourseError("this is the students' archive, packed without the lab, which only the project itself can compile")
    if why_not := prebuilt.why_not_lab(ROOT):
        warn(f"the lab shows the library as it was packed: {why_not}")
    print(f"The lab: {page}   to open it: xdg-open {shlex.quote(str(page))}")
    return 0


def build_wasm() -> Path:
    """Compiles ch5_lab in a folder of its own, WASM; returns its JavaScript, which holds the WebAssembly."""
    if not shutil.which("em++"):
        raise CourseError("the lab needs emscripten; Debian and Ubuntu: apt-get install emscripten")
    # Another Node.js than Debian's does not look for modules where Debian puts them.
    os.environ["NODE_PATH"] = os.pathsep.join(filter(None, (os.environ.get("NODE_PATH"), "/usr/share/nodejs")))
    os.environ.pop("PYTHONSAFEPATH", None)  # emscripten's Python imports what lies beside it
    eigen = next(Path(folder) for folder in ("/usr/share", "/usr/local/share") if Path(folder, "eigen3/cmake").exists())
    commands = [["emcmake", "cmake", "--preset", "release", "-B", str(WASM), "-DBUILD_TESTING=OFF", "-DCH5_WERROR=OFF",
                 f"-DEigen3_DIR={eigen / 'eigen3/cmake'}"],
                ["ninja", "-C", str(WASM), "-j", str(CORES), "ch5_lab"]]
    if was_moved(cached_entries(WASM)):
        shutil.rmtree(WASM)
    with Progress("compile to WebAssembly") as progress:
        for command in commands[(WASM / "build.ninja").exists():]:
            done = run_logged(command, "lab.log", progress.ninja_step)
            if done.returncode:
                raise failure("the lab could not be compiled", done.stdout, r"[Ee]rror|^FAILED", "lab.log")
    return WASM / "bin" / "ch5_lab.js"


def assemble(program: Path) -> str:
    """The page with its style, texts and scripts inside."""
    def read(path: Path) -> str:
        return path.read_text(encoding="utf-8").replace("</script", "<\\/script")

    parts = {"ch5_lab.js": read(program), "scripts": "\n".join(read(script) for script in SCRIPTS),
             **{name: read(PAGE / name) for name in ("lab.css", "worker.js", "text.json")}}
    return re.sub(r"/\*([\w.]+)\*/(?=[;<])", lambda match: parts[match[1]], (PAGE / "lab.html").read_text(encoding="utf-8"))
