"""The library as another project sees it: installed, found by find_package, compiled with its own flags."""

import subprocess
import tempfile
import unittest
from pathlib import Path

from house import BUILD, CXX, ROOT


def call(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode:
        raise AssertionError(f"{command} failed:\n{done.stdout}{done.stderr}")
    return done.stdout


class Consumer(unittest.TestCase):
    def build_and_run(self, flags: str):
        with tempfile.TemporaryDirectory() as folder:
            prefix, build = Path(folder, "prefix"), Path(folder, "build")
            call("cmake", "--install", BUILD, "--prefix", prefix)
            call("cmake", "-G", "Ninja", "-S", ROOT / "tests/house/consumer", "-B", build,
                 f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_CXX_COMPILER={CXX}", f"-DCMAKE_CXX_FLAGS={flags}")
            call("cmake", "--build", build)
            self.assertRegex(call(build / "consumer"), r"converged")

    def test_find_package_finds_the_installed_library(self):
        self.build_and_run("-O0")

    def test_consumer_for_this_processor_links_to_a_portable_library(self):
        # -march=native would change Eigen's alignment and with it the layout of every vertex, were the alignment
        # not part of the interface.
        self.build_and_run("-O0 -march=native")


if __name__ == "__main__":
    unittest.main()
