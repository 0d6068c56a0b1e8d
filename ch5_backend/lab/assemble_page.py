"""./course lab: the course's C++ as WebAssembly, in one page that needs nothing else."""

import os
import re
import shutil
from pathlib import Path

from ch5_backend.figures.atomic_write import write_whole

from ch5_backend.course.base.cmake_build import BUILD, CORES, ROOT, cached_entries, failure, run_logged, was_moved
from ch5_backend.course.base.errors import CourseError
from ch5_backend.course.base.output_dir import made_dir
from ch5_backend.course.base.progress import Progress

LAB = ROOT / "ch5_backend" / "lab"
WASM = BUILD.parent / "wasm"
SCRIPTS = ("draw.js", "formulas.js", "scene.js", "challenges.js", "state.js", "panels.js", "ask.js", "tasks.js", "main.js")
MOST_BYTES = 3_000_000


def lab(folder: str) -> int:
    """Writes lab.html; raises CourseError if emscripten is missing or the build fails."""
    out = Path(folder or "out")
    with made_dir(out):
        page = assemble(build_wasm())
        if len(page.encode()) > MOST_BYTES:
            raise CourseError(f"the page has {len(page.encode())} bytes, more than {MOST_BYTES}", 1)
        target = out / "lab.html"
        write_whole(target, page)
    print(f"The lab: {target}")
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

    page = LAB / "page"
    parts = {"lab.css": read(page / "lab.css"), "ch5_lab.js": read(program), "worker.js": read(page / "worker.js"),
             "text.json": read(page / "text.json"),
             "scripts": "\n".join(read(page / name) for name in SCRIPTS)}
    return re.sub(r"/\*([\w.]+)\*/(?=[;<])", lambda match: parts[match[1]], (page / "lab.html").read_text(encoding="utf-8"))
