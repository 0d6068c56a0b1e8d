"""The library as another project sees it: installed or as a subproject, compiled with flags of its own."""

import os
import re
import shlex
import shutil
import subprocess
import unittest
from functools import cache

from tests.project import BUILD, CXX, EIGEN, ROOT, run

HERE = BUILD / "tests" / "consumer"
CACHE = {"CCACHE_BASEDIR": str(ROOT), "CCACHE_NOHASHDIR": "1"}  # it knows them again wherever the project lies
SOURCE = ROOT / "tests" / "conventions" / "consumer"
LAUNCHER = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
COMPILER = ["ccache", CXX] if LAUNCHER else [CXX]
STRICT = ("-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wold-style-cast -Wdouble-promotion "
          "-Wnon-virtual-dtor -Woverloaded-virtual -Werror").split()
ALIGNMENT = ("-DEIGEN_MAX_ALIGN_BYTES=64", "-DEIGEN_MAX_STATIC_ALIGN_BYTES=16")
PROGRAMS = ("consumer", "consumer_mavx2", "consumer_march_native")


def call(*command, **environment) -> str:
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True,
                          errors="surrogateescape", env={**os.environ, **CACHE, **environment})  # pkg-config quotes each byte
    if done.returncode:
        raise AssertionError(f"{' '.join(map(str, command))} failed with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.stdout


@cache
def install(build):
    prefix = HERE / "prefix" / build.name
    shutil.rmtree(prefix, ignore_errors=True)
    call("cmake", "--install", build, "--prefix", prefix)
    return prefix


def configure(name: str, *words) -> str:
    shutil.rmtree(HERE / name, ignore_errors=True)
    return call("cmake", "-G", "Ninja", "-S", SOURCE, "-B", HERE / name, *LAUNCHER, *words)


def runs(name: str) -> list:
    """[(program, what went wrong or "")] of a build folder of the consumer."""
    outcomes = []
    for program in PROGRAMS:
        try:
            call("cmake", "--build", HERE / name, "--target", program)
            call(HERE / name / program)
            outcomes.append((program, ""))
        except AssertionError as error:
            outcomes.append((program, str(error)))
    return outcomes


class Consumer(unittest.TestCase):
    def test_another_project_uses_the_installed_library(self):
        configure("build", f"-DCMAKE_PREFIX_PATH={install(BUILD)}", f"-DCMAKE_CXX_COMPILER={CXX}", "-DCMAKE_CXX_FLAGS=-O0")
        for program, fault in runs("build"):
            self.assertEqual(fault, "", program)

    def test_a_program_may_have_an_eigen_of_its_own(self):
        """Without a package of Eigen."""
        for word in (f"-DCMAKE_PREFIX_PATH={install(BUILD)}", f"-DCH5_SOURCE={ROOT}"):
            configure("own_eigen", word, f"-DCMAKE_CXX_COMPILER={CXX}", f"-DOWN_EIGEN={EIGEN}", "-DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON")
            self.assertIn(f"-isystem {EIGEN}", call("ninja", "-C", HERE / "own_eigen", "-t", "commands", "consumer"))

    def test_what_an_installed_header_includes_is_installed(self):
        include = install(BUILD) / "include"
        headers = sorted(include.rglob("*.h"))
        self.assertGreater(len(headers), 50)
        for header in headers:
            for name in re.findall(r'#\s*include "([^"]+)"', header.read_text(encoding="utf-8")):
                self.assertTrue((include / name).is_file(), f"{header.relative_to(include)} includes {name}")

    def test_no_public_header_has_a_warning(self):
        """As a subproject's headers would, which are not the system's."""
        include = install(BUILD) / "include"
        every = HERE / "every_header.cc"
        every.write_text("".join(f'#include "{header.relative_to(include)}"\n' for header in sorted(include.rglob("*.h"))))
        call(*COMPILER, "-std=c++20", "-fsyntax-only", *STRICT, f"-I{include}", "-isystem", EIGEN, *ALIGNMENT, every)

    def test_a_program_without_cmake_takes_its_flags_from_pkg_config(self):
        if not shutil.which("pkg-config"):
            self.skipTest("pkg-config is not installed")
        prefix, program = install(BUILD), HERE / "by_hand"
        folder, = prefix.rglob("pkgconfig")
        cflags, libs = (shlex.split(call("pkg-config", kind, "ch5_backend", PKG_CONFIG_PATH=str(folder))) for kind in ("--cflags", "--libs"))
        call(*COMPILER, "-std=c++17", "-O0", "-march=native", *cflags, "-c", SOURCE / "main.cc", "-o", program.with_suffix(".o"))
        call(CXX, program.with_suffix(".o"), "-o", program, *libs)
        call(program)

    def test_a_debug_library_lies_beside_a_release_one(self):
        """Both are empty files here: nothing is linked, and compiling them takes minutes."""
        prefix = HERE / "prefix" / "both"
        shutil.rmtree(prefix, ignore_errors=True)
        for build_type, library in (("Release", "ch5_backend"), ("Debug", "ch5_backendd")):
            build = HERE / build_type
            call("cmake", "--preset", "library", "-S", ROOT, "-B", build, f"-DCMAKE_BUILD_TYPE={build_type}", f"-DCMAKE_CXX_COMPILER={CXX}")
            (build / "ch5_backend" / f"lib{library}.a").touch()
            call("cmake", "--install", build, "--prefix", prefix)
            package, = prefix.rglob(f"pkgconfig/{library}.pc")
            self.assertIn(f" -l{library} ", package.read_text(encoding="utf-8"))
        for build_type, library in (("", "ch5_backend"), ("RelWithDebInfo", "ch5_backend"), ("Release", "ch5_backend"), ("Debug", "ch5_backendd")):
            configure("either", f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_CXX_COMPILER={CXX}", f"-DCMAKE_BUILD_TYPE={build_type}")
            self.assertIn(f"/lib{library}.a", call("ninja", "-C", HERE / "either", "-t", "commands", "consumer"), build_type)

    def test_two_copies_in_one_program_share_no_variable(self):
        """As in two shared libraries that each hold ours: both would make it, and both destroy it."""
        library, = install(BUILD).rglob("libch5_backend*.a")
        symbols = call("nm", "-C", "--defined-only", library)
        self.assertIn(" T ch5::Graph::AddVertex", symbols)
        self.assertEqual(re.findall("(?m)^[^ ]+ [BCD] (ch5::.*)", symbols), [])

    def test_a_program_with_another_alignment_does_not_compile(self):
        for words in (["-DEIGEN_MAX_ALIGN_BYTES=32"], ["-DEIGEN_MAX_STATIC_ALIGN_BYTES=32"], ["-include", "Eigen/Core"]):
            done = run(CXX, "-std=c++17", "-fsyntax-only", f"-I{ROOT}", f"-I{EIGEN}", *words, "-x", "c++", ROOT / "ch5_backend/math/eigen_types.h")
            self.assertNotEqual(done.returncode, 0, words)
            self.assertIn(" ".join(ALIGNMENT), done.stderr)

    def test_an_older_language_is_named(self):
        done = run(CXX, "-std=c++14", "-fsyntax-only", f"-I{ROOT}", f"-I{EIGEN}", "-x", "c++", ROOT / "ch5_backend/math/eigen_types.h")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("compile with -std=c++17", done.stderr)

    def test_a_program_with_another_layout_of_vectors_or_strings_does_not_link(self):
        library, = install(BUILD).rglob("libch5_backend*.a")
        program = HERE / "layout.cc"
        program.write_text('#include "ch5_backend/math/eigen_types.h"\nint main() {}\n')
        for flag, links in (("-D_GLIBCXX_ASSERTIONS", True), ("-D_GLIBCXX_DEBUG", False), ("-D_GLIBCXX_USE_CXX11_ABI=0", False)):
            done = run(CXX, "-std=c++17", flag, f"-I{ROOT}", f"-I{EIGEN}", program, library, "-o", HERE / "layout")
            self.assertEqual((done.returncode == 0, "SameStandardLibrary" in done.stderr), (links, not links), flag)

    def test_a_subproject_leaves_its_parent_alone(self):
        said = configure("guest", f"-DCH5_SOURCE={ROOT}", f"-DCMAKE_CXX_COMPILER={CXX}", "-DCMAKE_CXX_FLAGS_RELEASE=-O1",
                         "-DCMAKE_CXX_FLAGS=-ffast-math", "-DCMAKE_UNITY_BUILD=ON")
        self.assertIn("build type: '', flags: '-O1'", said)
        added = re.search("added to the cache: (.*)", said)[1].split(";")
        foreign = [name for name in added if not re.match("CH5_|ch5_backend_|Eigen3_|FIND_PACKAGE_|CMAKE_HAVE_|CMAKE_PROJECT_VERSION|_", name)]
        self.assertEqual(foreign, [])
        targets = call("ninja", "-C", HERE / "guest", "-t", "targets", "all")
        names = re.findall(r"^cmake_object_order_depends_target_(\w+): phony", targets, re.MULTILINE)
        self.assertIn("ch5_layer_math", names)
        self.assertEqual([name for name in names if not name.startswith("ch5_") and name not in PROGRAMS], [])
        commands = call("ninja", "-C", HERE / "guest", "-t", "commands", "ch5_backend")
        self.assertNotIn("-fsanitize", commands)
        self.assertNotIn("/unity_", commands)
        for command in re.findall(".* -c .*", commands):  # the last word counts
            self.assertRegex(command, "-ffast-math .*-Werror .*-w -fno-fast-math ")
            self.assertIn(" -fPIC ", command, "the parent's shared libraries would not link")
