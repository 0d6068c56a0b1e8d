"""The layers: values flow one way, so no folder includes from a higher layer."""

import re
import unittest
from pathlib import Path

from house import ROOT, tracked_files

# What each folder of ch5_backend/ may include, besides itself.
MAY_INCLUDE = {
    "math": "",
    "graph": "math",
    "linear": "math",
    "solve": "math",
    "types": "math graph",
    "dense": "math graph linear solve",
    "sparse": "math graph linear solve types",
    "marginalize": "math graph linear solve types sparse",
    "consistency": "math graph linear solve types sparse marginalize",
    "window/start": "math graph linear solve types sparse marginalize consistency",
    "window": "math graph linear solve types sparse marginalize consistency window/start",
    "world": "math graph types",
    "world/simulate": "math graph types world",
    "world/files": "math graph types world",
    "world/evaluate": "math graph types world world/simulate",
}
TOP_LEVEL = {"CMakeLists.txt", "CMakePresets.json", "LICENSE", "README.md", "README.zh.md", "course", "ch5_backend",
             "ch5_homework", "slides", "solutions", "tests"}


def layer_of(path: str):
    """"ch5_backend/graph/edge.h" → "graph"; a file that stands in ch5_backend/ itself is below all layers."""
    folder = Path(path).parent.parts
    if folder[:1] != ("ch5_backend",) or len(folder) < 2:
        return None
    return "/".join(folder[1:]) if "/".join(folder[1:]) in MAY_INCLUDE else folder[1]


def may_include(user: str, used: str) -> bool:
    """Whether a file of layer `user` may include one of layer `used`."""
    return used is None or user == used or user == "apps" or used in MAY_INCLUDE.get(user, "").split()


def faults_of(path: str, text: str, exists) -> list:
    """What is wrong with the quoted includes of one file: [(line number, words)]."""
    faults = []
    for number, line in enumerate(text.splitlines(), 1):
        match = re.match(r'\s*#\s*include\s*"([^"]+)"', line)
        if not match:
            continue
        included = match[1]
        if not exists(included):
            faults.append((number, f'"{included}" is not a path from the root of the repository'))
        elif path.startswith("ch5_backend/") and not included.startswith("ch5_backend/"):
            faults.append((number, f'"{included}" is outside of ch5_backend/'))
        elif layer_of(path) is not None and not may_include(layer_of(path), layer_of(included)):
            faults.append((number, f"{layer_of(path)}/ must not include from {layer_of(included)}/"))
    return faults


class Layers(unittest.TestCase):
    def test_no_folder_includes_from_a_higher_layer(self):
        sources = [path for path in tracked_files(".h", ".cc") if path.parts[0] == "ch5_backend"]
        self.assertGreater(len(sources), 20, "the walk must have found the sources")
        faults = [f"{path}:{number}: {words}" for path in sources
                  for number, words in faults_of(str(path), (ROOT / path).read_text(encoding="utf-8"),
                                                 lambda name: (ROOT / name).is_file())]
        self.assertEqual(faults, [], "\n".join(["", *faults]))

    def test_the_rule_finds_faults(self):
        def faults(path, *included):
            text = "".join(f'#include "{name}"\n' for name in included)
            return [words for _, words in faults_of(path, text, lambda name: name != "edge.h")]
        self.assertEqual(faults("ch5_backend/sparse/a.cc", "ch5_backend/graph/edge.h", "ch5_backend/sparse/a.h"), [])
        self.assertEqual(faults("ch5_backend/world/a.cc", "ch5_backend/types/a.h", "ch5_backend/math/a.h"), [])
        self.assertEqual(faults("ch5_backend/apps/a.cc", "ch5_backend/window/a.h", "ch5_backend/world/a.h"), [])
        self.assertEqual(len(faults("ch5_backend/graph/a.h", "ch5_backend/types/a.h")), 1)
        self.assertEqual(len(faults("ch5_backend/world/a.h", "ch5_backend/solve/a.h")), 1)
        self.assertEqual(len(faults("ch5_backend/solve/a.h", "ch5_backend/world/a.h")), 1)
        self.assertEqual(len(faults("ch5_backend/solve/a.h", "ch5_backend/graph/a.h")), 1)
        self.assertEqual(len(faults("ch5_backend/window/start/a.h", "ch5_backend/window/a.h")), 1)
        self.assertEqual(len(faults("ch5_backend/world/files/a.h", "ch5_backend/world/simulate/a.h")), 1)
        self.assertEqual(len(faults("ch5_backend/window/a.h", "ch5_backend/apps/a.h")), 1)
        self.assertEqual(len(faults("ch5_backend/graph/a.h", "edge.h")), 1)
        self.assertEqual(len(faults("ch5_backend/graph/a.h", "solutions/problem.h")), 1)

    def test_every_folder_is_on_the_map(self):
        folders = {path.parts[1] for path in tracked_files(".h", ".cc") if layer_of(str(path)) is not None}
        self.assertEqual(folders - {layer.split("/")[0] for layer in MAY_INCLUDE} - {"apps"}, set())

    def test_top_level_holds_only_the_house(self):
        names = {path.parts[0] for path in tracked_files()}
        self.assertEqual({name for name in names - TOP_LEVEL if not name.startswith(".")}, set())


if __name__ == "__main__":
    unittest.main()
