"""What the project may use: no more than Ubuntu 22.04 has, CMake 3.22, Python 3.10 and Matplotlib 3.5; and its presets."""

import ast
import json
import re
import shutil
import tempfile
import unittest
from unittest import mock

from tests.project import CXX, ROOT, run, tracked_files

NEWER_CMAKE = r"\bblock\(|FILE_SET|LINK_GROUP|LINK_LIBRARY:|COMPILE_WARNING_AS_ERROR|BUILD_LOCAL_INTERFACE|--fresh|TEST_LAUNCHER"
NEWER_KEYWORDS = {"subplots": {"width_ratios", "height_ratios"}, "legend": {"ncols"}, "boxplot": {"tick_labels"}}


def trees() -> list:
    """The syntax trees of all our Python, as Python 3.10 reads it: [(path, tree)]."""
    return [(path, ast.parse((ROOT / path).read_text(encoding="utf-8"), str(path), feature_version=(3, 10)))
            for path in tracked_files(".py")]


def newer_keywords(tree) -> list:
    """Calls with keywords that Matplotlib 3.5 does not know."""
    return [f"line {call.lineno}: {call.func.attr}({keyword.arg}=…)" for call in ast.walk(tree)
            if isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute) for keyword in call.keywords
            if keyword.arg in NEWER_KEYWORDS.get(call.func.attr, ())]


class Versions(unittest.TestCase):
    def test_cmake_3_22_is_enough(self):
        lists = [path for path in tracked_files() if path.name == "CMakeLists.txt"]
        self.assertGreater(len(lists), 5)
        for path in lists:
            text = (ROOT / path).read_text(encoding="utf-8")
            self.assertIsNone(re.search(NEWER_CMAKE, text), path)
            for version in re.findall(r"cmake_minimum_required\(VERSION ([0-9.]+)", text):
                self.assertLessEqual(tuple(map(int, version.split("."))), (3, 22), path)
        presets = (ROOT / "CMakePresets.json").read_text(encoding="utf-8")
        self.assertRegex(presets, r'"version": 3,\s*"cmakeMinimumRequired": \{"major": 3, "minor": 22')
        for guide in ("GUIDE.md", "GUIDE.zh.md"):
            self.assertIn("CMake 3.22", (ROOT / "ch5_backend" / guide).read_text(encoding="utf-8"))

    def test_python_3_10_reads_every_script(self):
        self.assertGreater(len(trees()), 20)

    def test_no_call_is_newer_than_matplotlib_3_5(self):
        self.assertEqual([f"{path}, {words}" for path, tree in trees() for words in newer_keywords(tree)], [])
        self.assertEqual(len(newer_keywords(ast.parse("plt.subplots(1, 2, width_ratios=(1, 2))"))), 1)

    def test_layouts_are_set_as_matplotlib_3_5_wants_it(self):
        try:
            from ch5_backend.figures import style
        except ImportError:
            self.skipTest("no Matplotlib")
        figure = mock.Mock(spec=["suptitle", "set_constrained_layout_pads", "set_constrained_layout"])  # where 3.5 differs
        style.space(figure, wspace=0.04)
        style.space(figure, rect=(0, 0, 1, 0.9))
        style.freeze(figure)
        self.assertEqual([name for name, _, _ in figure.method_calls],
                         ["set_constrained_layout_pads", "suptitle", "set_constrained_layout"])

    def test_every_preset_configures(self):
        presets = json.loads((ROOT / "CMakePresets.json").read_text(encoding="utf-8"))["configurePresets"]
        names = [preset["name"] for preset in presets if not preset.get("hidden")]
        self.assertEqual(set(names), {"release", "library", "dev", "gcc-11", "aarch64", "asan-ubsan", "tsan", "fuzz"})
        compilers = {"fuzz": "clang++", "aarch64": "aarch64-linux-gnu-g++"}  # libFuzzer comes with Clang alone
        for name in names:
            compiler = compilers.get(name, CXX)
            if name in compilers and not shutil.which(compiler):
                continue
            with self.subTest(preset=name), tempfile.TemporaryDirectory() as folder:
                command = ["cmake", "--preset", name, "-B", folder, f"-DCMAKE_CXX_COMPILER={compiler}"]
                done = run(*command, cwd=ROOT)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
