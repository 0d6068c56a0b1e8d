"""The shape of the sources: short files, short functions, small folders.

`python3 tests/conventions/shape.py --list` prints all faults.
"""

import collections
import sys
import unittest
from pathlib import Path

from tests.conventions.functions import cpp_functions, functions_of, python_functions
from tests.conventions.project import ROOT, tracked_files

MAX_FILE_LINES = 300
MAX_FUNCTION_LINES = 40  # of code: functions.py says what counts. The skeletons' blanks are comments in solutions/
MAX_HEADERS = 14


def sources() -> list:
    """All that a person edits, hence not ch5_homework/, which is generated from solutions/, nor SVG and JSON.

    The pages in Markdown and the fills of the homework (tests/homework/fills/), which are data, have no functions.
    """
    return [path for path in tracked_files(".h", ".cc", ".py") if path.parts[0] != "ch5_homework"]


def text_of(path: Path) -> str:
    return (ROOT / path).read_text(encoding="utf-8")


def long_files() -> list:
    scripts = [Path("course"), Path(".ci/run")]
    return [f"{path}: {lines} lines" for path in sources() + scripts
            if (lines := len(text_of(path).splitlines())) > MAX_FILE_LINES]


def long_functions() -> list:
    return [f"{path}:{function.line}: {function.name}: {function.code_lines} lines of code" for path in sources()
            for function in functions_of(path.suffix, text_of(path)) if function.code_lines > MAX_FUNCTION_LINES]


def large_folders() -> list:
    counts = collections.Counter(str(path.parent) for path in tracked_files(".h"))
    return [f"{folder}/: {count} headers" for folder, count in sorted(counts.items()) if count > MAX_HEADERS]


class Shape(unittest.TestCase):
    def test_files_stay_short(self):
        faults = long_files()
        self.assertEqual(faults, [], "\n".join(["", *faults, "one file, one idea: split these"]))

    def test_functions_stay_short(self):
        faults = long_functions()
        self.assertEqual(faults, [], "\n".join(["", *faults, "name the steps: a function for each"]))

    def test_folders_stay_small(self):
        faults = large_folders()
        self.assertEqual(faults, [], "\n".join(["", *faults, "one folder, one subject: divide these"]))


CPP = r"""
#include <vector>
#define LOOP(n) \
  for (int i = 0; i < n; ++i) {
namespace a::b {
namespace {
const char* const kText = "not { code";  // nor { this
const std::vector<int> kTable = {1, 2, 3};
constexpr int kMillion{1'000'000};
enum class Kind { kOne, kTwo };
const char kBrace = '{';
}  // namespace

template <class T, class = std::enable_if_t<(sizeof(T) > 1)>>
class Holder : public Base<T> {
 public:
  Holder(int size, Options options = {})
      : size_(size), table_{1, 2}, name_(R"(} raw { text)") {
    Fill();

    // a comment
  }
  ~Holder() = default;
  int size() const { return size_; }
  bool operator()(int a) const override {
    /* two lines
       of comment */ return a > 0;
  }

 private:
  int size_{0};
  std::array<int, 2> table_ = {{1, 2}};
};

struct Row { int a, b; } row;

template <typename T>
auto Sum(const T& values,
         int first) -> decltype(values[0]) {
  struct Local {
    int Twice() const { return 2; }
  };
#ifdef NDEBUG
  const auto square = [&](int x) {
    return x * x;
  };
#endif
  return std::accumulate(values.begin(), values.end(), Row{first, 0});
}
}  // namespace a::b

TEST(Suite, IsRight) {
  EXPECT_TRUE(true);
}
"""

PYTHON = '''
class A:
    """Words."""

    def first(self, a,
              b):
        """Words
        and more."""

        # a comment
        text = """not
        documentation"""
        def inner():
            return 1
        return text
'''


class Counting(unittest.TestCase):
    def test_cpp_functions_are_found_and_counted(self):
        found = {function.name: function.code_lines for function in cpp_functions(CPP)}
        self.assertEqual(found, {"Holder": 3, "size": 1, "operator()": 3, "Sum": 9, "Suite.IsRight": 3})

    def test_python_functions_are_found_and_counted(self):
        found = {function.name: function.code_lines for function in python_functions(PYTHON)}
        self.assertEqual(found, {"first": 7, "inner": 2})

    def test_one_line_more_is_noticed(self):
        for lines in (MAX_FUNCTION_LINES, MAX_FUNCTION_LINES + 1):
            body = "\n".join(["  Call();  // why", "", "  // more"] * (lines - 2))
            self.assertEqual([f.code_lines for f in cpp_functions(f"void F() {{\n{body}\n}}\n")], [lines])

    def test_unmatched_braces_are_an_error(self):
        for text in ("void F() {", "}"):
            with self.assertRaises(ValueError):
                cpp_functions(text)

    def test_every_function_of_the_project_is_found(self):
        """A brace taken for something else would hide what it opens: each definition at the margin must be there."""
        for path in sources():
            if path.suffix == ".cc":
                lines = text_of(path).splitlines()
                ends = sum(1 for line in lines if line == "}")  # a function's, there; namespaces say so in a comment
                found = cpp_functions(text_of(path))
                self.assertGreaterEqual(len(found), ends, path)


if __name__ == "__main__":
    if sys.argv[1:] == ["--list"]:
        print("\n".join(long_files() + long_functions() + large_folders()))
    else:
        unittest.main()
