"""The engineers' examples: compiled against the installed library, and what they find; the Python module and its example."""

import re
import shutil
import sys
import sysconfig
import unittest
from pathlib import Path

from tests.conventions.consumer_test import HERE, LAUNCHER, call, install
from tests.project import BUILD, CXX, ROOT

EXAMPLES = ROOT / "ch5_backend" / "examples"
PYTHON = ROOT / "ch5_backend" / "python"


def numbers(pattern: str, text: str) -> list:
    """The numbers in the pattern's groups."""
    return [float(number) for number in re.search(pattern, text).groups()]


def write_cameras(path):
    """A small problem in BAL's format: five cameras before 40 points; the starts of the points are off by 5 cm."""
    points = [((k * 7 % 11) / 5 - 1, (k * 5 % 13) / 6 - 1, -6 - (k % 3)) for k in range(40)]
    rows = [f"5 {len(points)} {5 * len(points)}"]
    for camera in range(5):
        rows += [f"{camera} {k} {-500 * (x + 0.3 * camera) / z:.6f} {-500 * y / z:.6f}" for k, (x, y, z) in enumerate(points)]
    for camera in range(5):
        rows += map(str, [0, 0, 0, 0.3 * camera, 0, 0, 500, 0, 0])
    rows += [f"{value + 0.05 * (-1) ** k}" for k, point in enumerate(points) for value in point]
    path.write_text("\n".join(rows) + "\n")


class Examples(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = HERE / "examples"
        call("cmake", "-G", "Ninja", "-S", EXAMPLES, "-B", cls.folder, *LAUNCHER, f"-DCMAKE_PREFIX_PATH={install(BUILD)}",
             f"-DCMAKE_CXX_COMPILER={CXX}", "-DCMAKE_CXX_FLAGS=-O1")
        call("cmake", "--build", cls.folder, "--parallel", "2")

    def test_own_camera(self):
        write_cameras(self.folder / "cameras.txt")
        first, last = numbers(r"cost (\S+) -> (\S+) in", call(self.folder / "own_camera", self.folder / "cameras.txt"))
        self.assertGreater(first, 10.0)
        self.assertLess(last, 1e-3)

    def test_pose_graph(self):
        said = call(self.folder / "pose_graph")
        across, truth = numbers(r"across the circle: (\S+) m, truly (\S+) m", said)
        self.assertAlmostEqual(across, truth, delta=0.1)
        sigmas = [float(sigma) for sigma in re.findall(r"sigma of the position (\S+) m", said)]
        self.assertEqual(len(sigmas), 11)
        self.assertLess(sigmas[0], sigmas[5])
        self.assertGreater(numbers(r"correlation of x of neighbors: (\S+)", said)[0], 0.3)

    def test_sliding_window(self):
        said = call(self.folder / "sliding_window")
        poses, window = numbers(r"window: (\d+) poses, sigma (\S+) m", said)
        self.assertEqual(poses, 5)
        self.assertAlmostEqual(window / numbers(r"batch: 100 poses, sigma (\S+) m", said)[0], 1.0, delta=0.02)
        self.assertLess(numbers(r"are (\S+) m apart", said)[0], 0.01)

    def test_live_odometry(self):
        said = call(self.folder / "live_odometry")
        self.assertGreater(len(re.findall(r"s, segment 0: ", said)), 100)
        self.assertIn("at the end: speed", said)


# Prints lines of "expected | said".
MISUSE = '''
import ch5, numpy as np

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
