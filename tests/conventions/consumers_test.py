"""The library as many other projects see it: each compiler and instruction set against each library, and as a package."""

import itertools
import re
import shutil
import unittest

from tests.conventions.consumer_test import HERE, call, configure, install, runs
from tests.project import CXX, ROOT

COMPILERS = [name for name in ("g++-11", "g++-12", "clang++") if shutil.which(name)]
TABLE = HERE / "matrix.txt"


def library(*settings):
    """Build folder of the library alone."""
    folder = HERE / "-".join(["library", *settings]).replace("=", "-")
    call("cmake", "--preset", "library", "-S", ROOT, "-B", folder, f"-DCMAKE_CXX_COMPILER={CXX}", *(f"-D{s}" for s in settings))
    call("cmake", "--build", folder)
    return folder


class Matrix(unittest.TestCase):
    def test_table(self):
        rows, faults = [], []

        def note(way: str, compiler: str, standard: str, built: str, name: str):
            for program, fault in runs(name):
                rows.append(f"{way:<12} {compiler:<8} C++{standard} {built:<7} {program:<22} {'fails' if fault else 'right'}")
                faults.extend([fault] * bool(fault))

        prefixes = {"plain": install(library()), "native": install(library("CH5_NATIVE=ON")),
                    "shared": install(library("BUILD_SHARED_LIBS=ON"))}
        for (built, prefix), compiler, standard in itertools.product(prefixes.items(), COMPILERS, ("17", "20")):
            configure("matrix", f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_CXX_COMPILER={compiler}", f"-DCMAKE_CXX_STANDARD={standard}")
            note("installed", compiler, standard, built, "matrix")
        for compiler, (built, flags) in itertools.product(COMPILERS, (("plain", ""), ("native", "-march=native -ffast-math"))):
            configure("matrix", f"-DCH5_SOURCE={ROOT}", f"-DCMAKE_CXX_COMPILER={compiler}", "-DCMAKE_CXX_STANDARD=20",
                      "-DCMAKE_BUILD_TYPE=Release", f"-DCMAKE_CXX_FLAGS={flags}")
            note("subproject", compiler, "20", built, "matrix")
        TABLE.write_text("\n".join(rows) + "\n", encoding="utf-8")
        self.assertEqual(faults, [])


class Package(unittest.TestCase):
    def test_a_debian_package_holds_the_library(self):
        if not shutil.which("dpkg-deb"):
            self.skipTest("only Debian has dpkg-deb")
        folder = library()
        call("cpack", "-G", "DEB", "--config", folder / "CPackConfig.cmake", "-B", HERE / "package")
        package, = (HERE / "package").glob("*.deb")
        paths = re.findall(r"\./(\S*[^/\s])$", call("dpkg-deb", "--contents", package), re.MULTILINE)
        for path in ("usr/lib/libch5_backend.a", "usr/include/ch5_backend/version.h", "usr/lib/pkgconfig/ch5_backend.pc",
                     "usr/lib/cmake/ch5_backend/ch5_backendConfig.cmake", "usr/share/doc/libch5-backend-dev/copyright"):
            self.assertIn(path, paths)
        self.assertEqual([path for path in paths if re.search("kernels|steps|tests|lab|gtest|open_tasks|plain_block|curve_fitting", path)], [])
        if shutil.which("lintian"):
            self.assertEqual(run("lintian", "--fail-on", "error,warning", package).stdout, "")
        self.assertIn("libeigen3-dev", call("dpkg-deb", "--field", package, "Depends"))
