"""Every public header of the linear algebra, of the sparse solver and of the consistency tools has a direct test.

That is a file in tests/LAYER/ which includes the header and calls what it declares: each of its functions or, where it
has none, one of its classes. What only kernels/ holds is reached through the step that runs it.

`python3 tests/conventions/direct_tests.py --list` prints all faults.
"""

import re
import sys
import unittest
from pathlib import Path

from tests.conventions.functions import declarations, function_name
from tests.conventions.project import ROOT, tracked_files

LAYERS = ("linear", "sparse", "consistency")
WITHOUT_RESULT = {"PrefetchObject", "PrefetchEdge"}  # they change nothing but the time


def tested_names(header: str) -> list:
    """What a test of the header must name: its functions, or one of its classes. Each item is a set of alternatives."""
    functions, classes = set(), set()
    for found in declarations(header):
        if found.in_class or "friend" in found.head:
            continue
        if found.kind == "type" and (match := re.search(r"\b(?:class|struct)\s+(\w+)(?!.*\b(?:class|struct)\b)", found.head)):
            classes.add(match[1])
        elif found.kind in ("function", "other") and "(" in found.head and "=" not in found.head.split("(")[0]:
            functions.add(function_name(found.head))
    functions = {name for name in functions if re.fullmatch(r"\w+", name)} - WITHOUT_RESULT  # Class::Method belongs to its class
    return [{name} for name in sorted(functions)] or [classes]


def names_without_test(path: Path, tests: dict) -> list:
    """The names of a header that no test of its layer names which includes it; `tests` are texts by path."""
    including = [text for text in tests.values() if f'#include "{path}"' in text]
    words = set(re.findall(r"\w+", "\n".join(including)))
    return [" or ".join(sorted(names)) for names in tested_names((ROOT / path).read_text(encoding="utf-8"))
            if not names & words]


def faults() -> list:
    found = []
    for layer in LAYERS:
        tests = {path: (ROOT / path).read_text(encoding="utf-8") for path in tracked_files(".h", ".cc")
                 if path.parts[:2] == ("tests", layer)}
        for path in tracked_files(".h"):
            if path.parts[:-1] == ("ch5_backend", layer):
                found += [f"{path}: {name} has no test in tests/{layer}/" for name in names_without_test(path, tests)]
    return found


HEADER = """
namespace a {
struct Options { int n = 3; };
class Solver {
 public:
  int Run(int n) const { return n; }
};
template <typename T>
inline T Twice(T x) { return 2 * x; }
int Once(const Options& options = {});
inline int Solver::Other() { return 1; }
}
"""


class DirectTests(unittest.TestCase):
    def test_every_public_header_has_one(self):
        found = faults()
        self.assertEqual(found, [], "\n".join(["", *found]))

    def test_what_must_be_named(self):
        self.assertEqual(tested_names(HEADER), [{"Once"}, {"Twice"}])
        self.assertEqual(tested_names("struct A { int x; };\nclass B {\n  int Get();\n};\n"), [{"A", "B"}])

    def test_a_missing_test_is_noticed(self):
        path = Path("ch5_backend/linear/pivot_rule.h")
        include = f'#include "{path}"\n'
        self.assertEqual(names_without_test(path, {"a": include + "PivotRounding(3);"}), [])
        self.assertEqual(names_without_test(path, {"a": include, "b": "PivotRounding(3);"}), ["PivotRounding"])


if __name__ == "__main__":
    if sys.argv[1:] == ["--list"]:
        print("\n".join(faults()))
    else:
        unittest.main()
