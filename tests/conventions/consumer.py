"""The library as another project sees it: installed, found by find_package, compiled with its own flags."""

import shutil
import subprocess
import unittest

from tests.conventions.project import BUILD, CXX, ROOT

HERE = BUILD / "tests" / "house" / "consumer"  # always the same place, so that ccache knows it again


def call(*command) -> str:
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode:
        raise AssertionError(f"{command} failed with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.stdout


class Consumer(unittest.TestCase):
    def test_another_project_uses_the_installed_library(self):
        shutil.rmtree(HERE, ignore_errors=True)
        call("cmake", "--install", BUILD, "--prefix", HERE / "prefix")
        launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
        call("cmake", "-G", "Ninja", "-S", ROOT / "tests/conventions/consumer", "-B", HERE / "build", *launcher,
             f"-DCMAKE_PREFIX_PATH={HERE / 'prefix'}", f"-DCMAKE_CXX_COMPILER={CXX}", "-DCMAKE_CXX_FLAGS=-O0")
        call("cmake", "--build", HERE / "build")
        portable = call(HERE / "build" / "consumer")
        native = call(HERE / "build" / "consumer_native")
        self.assertRegex(portable, "converged")
        self.assertEqual(portable, native)
