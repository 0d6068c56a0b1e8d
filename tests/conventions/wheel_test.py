"""The Python module: pip makes it, and its example runs."""

import shutil
import sys
import sysconfig
import unittest
from pathlib import Path

from tests.conventions.consumer_test import HERE, call
from tests.conventions.examples_test import numbers
from tests.project import BUILD, ROOT

PYTHON = ROOT / "ch5_backend" / "python"

# Prints lines of "expected | said".
MISUSE = '''
import ch5, numpy as np
from importlib import metadata

def say(expected, do):
    try:
        said = do()
    except ValueError as error:
        said = error
    print(f"{expected} | {said}")

def solve(*words, **options):
    graph, a = ch5.Graph(), ch5.Vector(np.array([3.0, 1.0]))
    graph.add(a)
    graph.add(ch5.Edge([a], *words, **options))
    return graph.solve()["message"]

def turn(q):
    pose = ch5.Pose(np.zeros(3), np.array([0, 0, 0, 1.0]))
    pose.x = np.array([0, 0, 0, *q])
    return pose.x[6]

say(metadata.version("ch5"), lambda: ch5.__version__)
say("converged", lambda: solve(lambda x: x[0] - 1, 1))
say("Edge of Python 0: its function returned NoneType, expected 2x1", lambda: solve(lambda x: None, 2))
say("Edge of Python 0: its function returned 2x1 numbers, expected 3x1", lambda: solve(lambda x: x, 3))
say("Edge of Python 0: its jacobians are no list of 1", lambda: solve(lambda x: x, 2, jacobians=lambda x: np.eye(2)))
say("size = -1: must be at least 1", lambda: solve(lambda x: x, -1))
say("^1.0", lambda: turn([0, 0, 0, 2.0]))
say("the quaternion is zero", lambda: turn([0, 0, 0, 0]))
'''


@unittest.skipUnless(Path(sysconfig.get_path("include"), "Python.h").exists(), "Python's headers are not installed: python3-dev")
class PythonModule(unittest.TestCase):
    def test_pip_makes_it_and_the_example_runs(self):
        if not any(Path(folder, "include/pybind11/pybind11.h").exists() for folder in ("/usr", "/usr/local")):
            self.skipTest("pybind11 is not installed: pybind11-dev")
        wheels = HERE / "wheel"
        shutil.rmtree(wheels, ignore_errors=True)
        wheels.mkdir(parents=True)
        # As pip calls it; a wheel is a zip.
        call(sys.executable, "-c", f"import wheel_backend; wheel_backend.build_wheel({str(wheels)!r})", PYTHONPATH=str(PYTHON),
             CMAKE_CXX_COMPILER_LAUNCHER="ccache" if shutil.which("ccache") else "")
        wheel, = wheels.glob("ch5-*.whl")
        shutil.unpack_archive(wheel, wheels / "site", "zip")
        for answer in call(sys.executable, "-c", MISUSE, PYTHONPATH=str(wheels / "site")).splitlines():
            expected, said = answer.split(" | ")
            self.assertRegex(said, expected)
        recording = HERE / "recording"
        simulate = BUILD / "tests" / "experiments" / "simulate_recording"
        words = []
        if simulate.exists():
            call(simulate, recording, 8)
            words = [recording]
        said = call(sys.executable, PYTHON / "example.py", *words, PYTHONPATH=str(wheels / "site"))
        a, b, c = numbers(r"a, b, c = \[ *(\S+) +(\S+) +([^\]\s]+) *\]", said)
        self.assertAlmostEqual(a, 1.0, delta=0.1)
        self.assertAlmostEqual(b, 2.0, delta=0.1)
        self.assertAlmostEqual(c, 1.0, delta=0.1)
        self.assertLess(numbers(r"covariance changes by (\S+)", said)[0], 1e-6)
        if words:
            self.assertGreater(numbers(r"(\d+) of 161 images have a pose", said)[0], 80)
