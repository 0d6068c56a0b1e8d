"""The floors of the house: values flow one way, so no folder includes from a higher floor."""

import re
import unittest
from pathlib import Path

from house import ROOT, tracked_files

FLOORS = {"math": 0, "graph": 1, "types": 2, "solve": 3, "marginalize": 4, "window": 5, "apps": 6}
TOP_LEVEL = {"CMakeLists.txt", "CMakePresets.json", "LICENSE", "README.md", "README.zh.md", "course", "ch5_backend",
             "ch5_homework", "slides", "solutions", "tests"}


def floor_of(path: str):
    """"ch5_backend/graph/edge.h" → "graph"; a file that stands in ch5_backend/ itself is below all floors."""
    parts = Path(path).parts
    return parts[1] if parts[0] == "ch5_backend" and len(parts) > 2 else None


def may_include(user: str, used: str) -> bool:
    """Whether a file of floor `user` may include one of floor `used`."""
    if used is None or user == used or user == "apps":
        return True
    if user == "world":
        return FLOORS.get(used, 9) <= FLOORS["types"]
    return used in FLOORS and user in FLOORS and FLOORS[used] < FLOORS[user]


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
        elif floor_of(path) is not None and not may_include(floor_of(path), floor_of(included)):
            faults.append((number, f"{floor_of(path)}/ must not include from {floor_of(included)}/"))
    return faults


class Layers(unittest.TestCase):
    def test_no_folder_includes_from_a_higher_floor(self):
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
        self.assertEqual(faults("ch5_backend/solve/a.cc", "ch5_backend/graph/edge.h", "ch5_backend/solve/a.h"), [])
        self.assertEqual(faults("ch5_backend/world/a.cc", "ch5_backend/types/a.h", "ch5_backend/math/a.h"), [])
        self.assertEqual(faults("ch5_backend/apps/a.cc", "ch5_backend/window/a.h", "ch5_backend/world/a.h"), [])
        self.assertEqual(len(faults("ch5_backend/graph/a.h", "ch5_backend/types/a.h")), 1)
        self.assertEqual(len(faults("ch5_backend/world/a.h", "ch5_backend/solve/a.h")), 1)
        self.assertEqual(len(faults("ch5_backend/solve/a.h", "ch5_backend/world/a.h")), 1)
        self.assertEqual(len(faults("ch5_backend/window/a.h", "ch5_backend/apps/a.h")), 1)
        self.assertEqual(len(faults("ch5_backend/graph/a.h", "edge.h")), 1)
        self.assertEqual(len(faults("ch5_backend/graph/a.h", "solutions/problem.h")), 1)

    def test_every_folder_is_on_the_map(self):
        folders = {path.parts[1] for path in tracked_files(".h", ".cc") if floor_of(str(path)) is not None}
        self.assertEqual(folders - set(FLOORS) - {"world"}, set())

    def test_top_level_holds_only_the_house(self):
        names = {path.parts[0] for path in tracked_files()}
        self.assertEqual({name for name in names - TOP_LEVEL if not name.startswith(".")}, set())


if __name__ == "__main__":
    unittest.main()
