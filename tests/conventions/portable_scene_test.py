"""The course's scene is the same to the bit with every compiler, optimization and standard library.

Each setting is compared with the committed portable_scene.golden, hence all with one another.
"""

import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

from tests.project import CXX, EIGEN, ROOT, run

HERE = Path(__file__).parent


def compile_object(compiler: str, flags: list, target: Path):
    """Through ccache if there is one: the second run of the tests costs nothing."""
    launcher = [shutil.which("ccache")] if shutil.which("ccache") else []
    command = [*launcher, compiler, "-std=c++17", "-ffp-contract=off", f"-I{ROOT}", "-isystem", EIGEN,
               "-ffunction-sections", "-fdata-sections", *flags, "-c", str(HERE / "portable_scene.cc"), "-o", str(target)]
    return run(*command, cwd=ROOT)


class PortableScene(unittest.TestCase):
    def check(self, compiler: str, *flags):
        if not shutil.which(compiler):
            self.skipTest(f"{compiler} is not installed")
        library = [flag for flag in flags if flag.startswith("-stdlib")]
        if library and not self.has_library(compiler, library):
            self.skipTest(f"{compiler} cannot link with {library[0]}: libc++-dev and libc++abi-dev are not installed")
        with tempfile.TemporaryDirectory() as folder:
            target, program = Path(folder, "scene.o"), Path(folder, "scene")
            done = compile_object(compiler, list(flags), target)
            self.assertEqual(done.returncode, 0, done.stderr)
            # What the headers bring along of graphs is dropped by the linker, so that the graph need not be compiled.
            done = run(compiler, *library, "-Wl,--gc-sections", target, "-o", program)
            self.assertEqual(done.returncode, 0, done.stderr)
            printed = run(program, check=True).stdout
        golden = (HERE / "portable_scene.golden").read_text(encoding="utf-8")
        self.assertEqual(printed.splitlines(), golden.splitlines())

    def has_library(self, compiler: str, library: list) -> bool:
        with tempfile.TemporaryDirectory() as folder:
            source = Path(folder, "main.cc")
            source.write_text("#include <string>\nint main() { return static_cast<int>(std::string().size()); }\n")
            command = [compiler, *library, str(source), "-o", str(Path(folder, "main"))]
            return subprocess.run(command, capture_output=True).returncode == 0

    def test_this_compiler_unoptimized(self):
        self.check(CXX, "-O0")

    def test_this_compiler_optimized(self):
        self.check(CXX, "-O2")

    def test_this_compiler_for_this_processor(self):
        self.check(CXX, "-O2", "-march=native")

    def test_clang_unoptimized(self):
        self.check("clang++", "-O0")

    def test_clang_optimized(self):
        self.check("clang++", "-O2")

    def test_clang_with_libcxx(self):
        self.check("clang++", "-O2", "-stdlib=libc++")
