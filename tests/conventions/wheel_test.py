"""The Python module: pip makes it, its example runs, and its stubs say what it has."""

import ast
import os
import re
import shutil
import sys
import sysconfig
import unittest
from pathlib import Path

from tests.conventions.consumer_test import ALIGNMENT, HERE, call
from tests.conventions.examples_test import numbers
from tests.project import BUILD, CXX, EIGEN, ROOT

PYTHON = ROOT / "ch5_backend" / "python"

# Prints lines of "expected | said".
SAYS = r'''
import ch5, math, numpy as np, pathlib, sys, threading, time
from ch5 import pose_graph
from importlib import metadata

def say(expected, do):
    try:
        said = do()
    except (ValueError, RuntimeError, KeyError) as error:
        said = f"{type(error).__name__}: {error}"
    print(f"{expected} | {said}".replace(chr(10), " "))

def solve(*words, **options):
    graph, a = ch5.Graph(), ch5.Vector(np.array([3.0, 1.0]))
    graph.add(a)
    graph.add(ch5.Edge([a], *words))
    return graph.solve(**options)["message"]

def turn(q):
    pose = ch5.Pose(np.zeros(3), np.array([0, 0, 0, 1.0]))
    pose.x = np.array([0, 0, 0, *q])
    return pose.x[6]

def write(view):
    view[0] = 7

def stop(iteration):
    raise KeyError("from the callback")

def other_thread(do):
    # What `do` returns while a solve, whose residual waits, is under way in another thread.
    graph, a, solved = ch5.Graph(), ch5.Vector([3.0]), []
    graph.add(a)
    graph.add(ch5.Edge([a], lambda x: (time.sleep(0.02), x)[1], 1))
    thread = threading.Thread(target=lambda: solved.append(graph.solve()))
    thread.start()
    time.sleep(0.01)
    try:
        return do(graph, solved)
    finally:
        thread.join()

def counts(graph, solved):
    # A solve of 150 ms without any Python inside leaves room for this one.
    big, x, numbers = ch5.Graph(), ch5.Vector([0.5, 1.0, 0.0]), np.random.default_rng(1).uniform(0.1, 2, (200000, 2))
    big.add(x)
    big.add_formula(curve, [x], numbers)
    thread, turns = threading.Thread(target=lambda: big.solve(max_iterations=10)), 0
    thread.start()
    while thread.is_alive():
        turns += 1
        time.sleep(0)
    return "went on" if turns > 20 else f"only {turns} turns"

curve = ch5.Formula(sys.argv[1], "curve")

def fit(loss=None, n=60):
    t = np.linspace(0, 1, n)
    numbers = np.stack([t, np.exp(t * t + 2 * t + 1)], axis=1)
    graph, memory = ch5.Graph(), np.array([0.5, 1.0, 0.0])
    x = ch5.Vector.on(memory)
    graph.add(x)
    graph.add_formula(curve, [x], numbers, loss=loss)
    graph.solve(max_iterations=50)
    return memory.round(6), x.view.round(6)

def square(path):
    solution = pose_graph.solve(pathlib.Path(path))
    return solution["converged"], solution["poses"].round(3).tolist(), solution["ids"].tolist()

def circle_of_edges_alone():
    rows = [f"EDGE_SE2 {i} {i + d} {math.sin(2 * d)} {1 - math.cos(2 * d)} {math.remainder(2 * d, 2 * math.pi)} 1 0 0 1 0 1\n"
            for i in range(40) for d in (1, 7) if i + d < 40]
    pathlib.Path("circle.g2o").write_text("".join(rows))
    return pose_graph.solve("circle.g2o")["final_cost"] < 1e-9, pose_graph.solve("circle.g2o", start="file")["final_cost"] > 1

def frame_of(ids):
    return ch5.Estimator(ch5.Calibration()).add_frame(1.0, ids, np.zeros((len(ids), 2)))["status"]

say(metadata.version("ch5"), lambda: ch5.__version__)
say("converged", lambda: solve(lambda x: x[0] - 1, 1))
say("ValueError: Edge of Python 0: its function returned NoneType, expected 2x1", lambda: solve(lambda x: None, 2))
say("Edge of Python 0: its function returned 2x1 numbers, expected 3x1", lambda: solve(lambda x: x, 3))
say("Edge of Python 0: its jacobians are no list of 1", lambda: solve(lambda x: x, 2, lambda x: np.eye(2)))
say("size = -1: must be at least 1", lambda: solve(lambda x: x, -1))
say("^1.0", lambda: turn([0, 0, 0, 2.0]))
say("the quaternion is zero", lambda: turn([0, 0, 0, 0]))
say("KeyError: .from the callback", lambda: solve(lambda x: x, 2, callback=stop))
say("stopped by the caller", lambda: solve(lambda x: x, 2, callback=lambda i: False))
say("OptionError: SolveOptions::tau", lambda: solve(lambda x: x, 2, tau=-1.0))
say("ValueError: solve: there is no option 'taw'", lambda: solve(lambda x: x, 2, taw=1.0))
say("ValueError: solve: tau cannot be a str", lambda: solve(lambda x: x, 2, tau="small"))
say("converged", lambda: solve(lambda x: np.float32(x[0]), 1))
say("algorithm is 'best', expected one of automatic, gauss-newton", lambda: solve(lambda x: x, 2, algorithm="best"))
say("converged", lambda: solve(lambda x: x, 2, algorithm="dogleg", damping="identity"))
say("set_loss: name is 'l1', expected one of huber", lambda: ch5.Edge([ch5.Vector([1.0])], lambda x: x, 1).set_loss("l1", 1.0))
say("ValueError: .*read-only", lambda: write(ch5.Vector([1.0]).view))
say("Vector.on: a writable, contiguous array", lambda: ch5.Vector.on(np.arange(3)))
say("GraphError: AddVertex: the vertex is null", lambda: ch5.Graph().add(None))
say("CovarianceError", lambda: ch5.Graph().covariance([ch5.Vector([1.0])]))
say(r"^\(True, True\)", circle_of_edges_alone)
say("starting", lambda: frame_of([]))
say("ids are whole numbers", lambda: frame_of([1.5]))
say("the id 1099511627776 does not fit into 32 bits", lambda: frame_of(np.array([2**40])))
say("algorithm is '5', expected one of", lambda: solve(lambda x: x, 2, algorithm=5))
say("FileError: .*nowhere", lambda: pose_graph.solve("/nowhere.g2o"))
say("Formula: .*has no formula 'circle'", lambda: ch5.Formula(sys.argv[1], "circle"))
say("vertex 0 has 2 parameters, expected 3", lambda: ch5.Graph().add_formula(curve, [ch5.Vector([1.0, 2.0])], np.zeros((1, 2))))
say("a row an edge: n x 2 are wanted", lambda: ch5.Graph().add_formula(curve, [ch5.Vector(np.zeros(3))], np.zeros((1, 3))))
say(r"array\(\[1., 2., 1.\]\), array\(\[1., 2., 1.\]\)", fit)
say(r"array\(\[1., 2., 1.\]\)", lambda: fit(("huber", 1.0)))
say("RuntimeError: Graph: another thread is using it", lambda: other_thread(lambda graph, solved: graph.cost()))
say("^still solving$", lambda: other_thread(lambda graph, solved: "ended" if solved else "still solving"))
say("^went on$", lambda: counts(None, None))
say(r"^\(True, \[\[0.0, 0.0, 0.0\], \[1.0, 0.0, 1.571\]\], \[7, 9\]\)", lambda: square(sys.argv[2]))
'''

CURVE = '''
#include "ch5_backend/graph/c_formula.h"
struct Curve {
  template <typename T>
  static Eigen::Matrix<T, 1, 1> Evaluate(const double* ty, const Eigen::Matrix<T, 3, 1>& abc) {
    using std::exp;
    return Eigen::Matrix<T, 1, 1>(exp(abc[0] * ty[0] * ty[0] + abc[1] * ty[0] + abc[2]) - ty[1]);
  }
};
CH5_FORMULA(curve, Curve, 1, 2, 3)
'''
TWO_POSES = "VERTEX_SE2 7 0 0 0\nVERTEX_SE2 9 2 1 1\nEDGE_SE2 7 9 1 0 1.5707963 1 0 0 1 0 1\n"

# Prints the names of all things and of their members.
NAMES = '''
import ch5, re
for module in (ch5, ch5.pose_graph):
    for name, thing in vars(module).items():
        if name.startswith("_") or name == "pose_graph": continue
        print(name)
        for member in vars(thing) if isinstance(thing, type) else ():
            if not member.startswith("_"): print(f"{name}.{member}")
'''


def names_in_stubs() -> set:
    names = set()
    for stub in (PYTHON / "ch5-stubs").glob("*.pyi"):
        for node in ast.parse(stub.read_text(encoding="utf-8")).body:
            if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
                names.add(node.name)
            for member in node.body if isinstance(node, ast.ClassDef) else ():
                name = member.name if isinstance(member, ast.FunctionDef) else getattr(getattr(member, "target", None), "id", None)
                names |= {f"{node.name}.{name}"} if name and not name.startswith("_") else set()
    return names


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
        site = {"PYTHONPATH": str(wheels / "site")}
        needed = re.findall(r"NEEDED +(\S+)", call("objdump", "-p", next((wheels / "site").glob("ch5.*.so"))))
        self.assertLessEqual({name.split(".")[0] for name in needed}, {"libc", "libm", "ld-linux-x86-64", "libdl", "libpthread"})
        (wheels / "curve.cc").write_text(CURVE)
        (wheels / "two.g2o").write_text(TWO_POSES)
        call(CXX, "-std=c++17", "-O2", "-shared", "-fPIC", f"-I{ROOT}", "-isystem", EIGEN, *ALIGNMENT, wheels / "curve.cc", "-o", wheels / "curve.so")
        for answer in call(sys.executable, "-c", SAYS, wheels / "curve.so", wheels / "two.g2o", **site).splitlines():
            expected, said = answer.split(" | ")
            self.assertRegex(said, expected)
        here = set(call(sys.executable, "-c", NAMES, **site).split())
        exceptions = {name for name in here if "Error" in name}
        self.assertEqual(here - exceptions, {name for name in names_in_stubs() if "Error" not in name})
        self.assertLessEqual({name for name in exceptions if "." not in name}, names_in_stubs())
        recording = HERE / "recording"
        simulate = BUILD / "tests" / "experiments" / "simulate_recording"
        words = []
        if simulate.exists():
            call(simulate, recording, 8)
            words = [recording]
        os.chdir(wheels)  # where curve.png goes
        said = call(sys.executable, PYTHON / "example.py", *words, **site)
        a, b, c = numbers(r"a, b, c = \[ *(\S+) +(\S+) +([^\]\s]+) *\]", said)
        self.assertAlmostEqual(a, 1.0, delta=0.1)
        self.assertAlmostEqual(b, 2.0, delta=0.1)
        self.assertAlmostEqual(c, 1.0, delta=0.1)
        self.assertLess(numbers(r"covariance changes by (\S+)", said)[0], 1e-6)
        if words:
            self.assertGreater(numbers(r"(\d+) of 161 images have a pose", said)[0], 80)
