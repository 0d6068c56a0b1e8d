"""The layers: values flow one way, so no folder includes or imports from a higher layer, in C++ and in Python."""

import ast
import graphlib
import json
import re
import unittest
from pathlib import Path

from tests.project import ROOT, tracked_files

# What each folder of ch5_backend/ may include and each folder of Python may import, besides itself; tests may import everything. A
# group's name stands for its folders.
RULES = json.loads(Path(__file__).with_name("layers.json").read_text(encoding="utf-8"))


def folders(words: str) -> list:
    return [folder for word in words.split() for folder in (folders(RULES["groups"][word]) if word in RULES["groups"] else [word])]


MAY_INCLUDE, MAY_IMPORT = ({folder: folders(words) for folder, words in RULES[kind].items()} for kind in ("may_include", "may_import"))


def longest(path: str, folders) -> str:
    """The folder among `folders` that holds the path, the most specific; "" if there is none."""
    return max((folder for folder in folders if path.startswith(folder + "/")), key=len, default="")


def layer_of(path: str) -> str:
    """"ch5_backend/graph/edge.h" → "graph"; a file that stands in ch5_backend/ itself is below all layers: ""."""
    return longest(path.removeprefix("ch5_backend/"), MAY_INCLUDE) if path.startswith("ch5_backend/") else ""


def cpp_faults(path: str, text: str, exists) -> list:
    """What is wrong with the quoted includes of one file: [(line number, words)]."""
    faults = []
    for number, line in enumerate(text.splitlines(), 1):
        match = re.match(r'\s*#\s*include\s*"([^"]+)"', line)
        if not match:
            continue
        included, user, used = match[1], layer_of(path), layer_of(match[1])
        if not exists(included):
            faults.append((number, f'"{included}" is not a path from the root of the repository'))
        elif included.startswith("tests/") and not path.startswith("tests/"):
            faults.append((number, f'"{included}": nothing but a test may use what is in tests/'))
        elif path.startswith("ch5_backend/") and not included.startswith("ch5_backend/"):
            faults.append((number, f'"{included}" is outside of ch5_backend/'))
        elif user and used and user != used and used not in MAY_INCLUDE[user]:
            faults.append((number, f"{user}/ must not include from {used}/"))
    return faults


def imports_of(path: str, text: str):
    """What one module of the project imports, also inside of a function: [(line number, dotted name)]."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = list(Path(path).parent.parts)[:-(node.level - 1) or None] if node.level else []
            module = ".".join(above + ([node.module] if node.module else []))
            yield from ((node.lineno, f"{module}.{alias.name}") for alias in node.names)


def python_faults(path: str, text: str) -> list:
    """What is wrong with the imports of one module of the project: [(line number, words)]."""
    faults, user = [], longest(path, MAY_IMPORT)
    for number, module in imports_of(path, text):
        file = module.replace(".", "/") + "/"
        used = longest(file, MAY_IMPORT)
        if file.startswith("tests/") and not path.startswith("tests/"):
            faults.append((number, f"{module}: nothing but a test may use what is in tests/"))
        elif user and used and user != used and used not in MAY_IMPORT[user]:
            faults.append((number, f"{user}/ must not import from {used}/"))
    return faults


def circle(sources: dict) -> list:
    """Modules that import each other, the first one again at the end; [] if there are none.

    @param sources  {path of a module: its text}
    """
    modules = {path.removesuffix(".py").removesuffix("/__init__").replace("/", "."): path for path in sources}
    graph = {path: {modules.get(name) or modules.get(name.rpartition(".")[0]) for _, name in imports_of(path, text)} - {path, None}
             for path, text in sources.items()}
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        return error.args[1]
    return []


class Layers(unittest.TestCase):
    def found(self, faults_of, *suffixes) -> list:
        sources = tracked_files(*suffixes)
        self.assertGreater(len(sources), 20, "the walk must have found the sources")
        return [f"{path}:{number}: {words}" for path in sources
                for number, words in faults_of(str(path), (ROOT / path).read_text(encoding="utf-8"))]

    def test_no_folder_includes_from_a_higher_layer(self):
        faults = self.found(lambda path, text: cpp_faults(path, text, lambda name: (ROOT / name).is_file()), ".h", ".cc")
        self.assertEqual(faults, [], "\n".join(["", *faults]))

    def test_no_folder_imports_from_a_higher_layer(self):
        faults = self.found(python_faults, ".py")
        self.assertEqual(faults, [], "\n".join(["", *faults]))

    def test_no_modules_import_each_other_in_a_circle(self):
        self.assertEqual(circle({str(path): (ROOT / path).read_text(encoding="utf-8") for path in tracked_files(".py")}), [])
        self.assertEqual(set(circle({"a/b.py": "from . import c", "a/c.py": "def f():\n  from .b import g"})), {"a/b.py", "a/c.py"})
        self.assertEqual(circle({"a/__init__.py": "from .b import f", "a/b.py": "import os"}), [])

    def test_no_module_edits_the_path(self):
        sources = [path for path in tracked_files(".py") if re.search(r"\bsys\.path\b", (ROOT / path).read_text(encoding="utf-8"))]
        self.assertEqual(sources, [])

    def test_the_rules_find_faults(self):
        for path, included, count in (("ch5_backend/sparse/a.cc", "ch5_backend/graph/edge.h", 0),
                                      ("ch5_homework/judge/a.cc", "ch5_backend/window/a.h", 0),
                                      ("ch5_backend/solve/a.h", "ch5_backend/graph/a.h", 1),
                                      ("ch5_backend/sparse/kernels/a.h", "ch5_backend/sparse/steps/a.h", 1),
                                      ("ch5_backend/types/a.h", "ch5_backend/types/visual/a.h", 1),
                                      ("ch5_backend/graph/a.h", "edge.h", 1), ("ch5_backend/graph/a.h", "solutions/problem.h", 1),
                                      ("ch5_homework/judge/a.h", "tests/scenes.h", 1)):
            found = cpp_faults(path, f'#include "{included}"\n', lambda name: name != "edge.h")
            self.assertEqual(len(found), count, (path, included))
        for path, text, count in (("ch5_backend/course/grading/a.py", "from ..base.cmake_build import ROOT\nfrom . import b\nimport os", 0),
                                  ("tests/docs/a.py", "from slides import build", 0),
                                  ("ch5_backend/course/base/a.py", "from ..homework import judge", 1),
                                  ("ch5_backend/figures/a.py", "import ch5_backend.course.base.cmake_build", 1),
                                  ("ch5_backend/course/grading/a.py", "from tests.homework import samples", 1)):
            self.assertEqual(len(python_faults(path, text)), count, (path, text))

    def test_every_folder_is_on_the_map(self):
        found = {path.parts[1] for path in tracked_files(".h", ".cc") if path.parts[0] == "ch5_backend" and len(path.parts) > 2}
        self.assertEqual(found - {layer.split("/")[0] for layer in MAY_INCLUDE}, set())
        modules = [str(path) for path in tracked_files(".py") if path.parts[0] != "tests" and len(path.parts) > 2]
        self.assertEqual([path for path in modules if not longest(path, MAY_IMPORT)], [])

    def test_top_level_holds_only_the_project(self):
        names = {path.parts[0] for path in tracked_files()}
        self.assertEqual({name for name in names - set(RULES["top_level"]) if not name.startswith(".")}, set())
