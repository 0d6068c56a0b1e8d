"""The engineers' examples: compiled against the installed library, and what they find."""

import re
import unittest

from tests.conventions.consumer_test import HERE, LAUNCHER, call, install
from tests.project import BUILD, CXX, ROOT

EXAMPLES = ROOT / "ch5_backend" / "examples"


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

    def test_growing_graph(self):
        said = call(self.folder / "growing_graph")
        eliminated = {int(k): int(n) for k, n in re.findall(r"pose (\d+): (\d+) of \1 variables eliminated", said)}
        self.assertEqual(sorted(eliminated), [1, *(k + at for k in range(100, 500, 100) for at in (0, 1)), 500])
        self.assertLess(eliminated[401], 30)
        self.assertGreater(eliminated[500], eliminated[401])
        self.assertLess(numbers(r"the end is (\S+) m", said)[0], 0.02)

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
