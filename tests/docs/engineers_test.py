"""The engineers' pages: the index of formulas leads to them, and what the pages name exists."""

import re
import unittest

from tests.docs.markdown import LIBRARY, ROOT, read, spans
from tests.project import tracked_files

BACKEND = ROOT / "ch5_backend"
INDEX, WALK = LIBRARY


def rows():
    """The index: [(formula, source, path, [functions])]."""
    table = read(INDEX).partition("## Index of formulas")[2]
    found = re.findall(r"^\| (.+?) \| (.+?) \| `([\w/.]+)` \| (.+?) \|$", table, re.M)
    return [(formula, source, path_of(file), re.findall(r"`([\w:]+)`", functions))
            for formula, source, file, functions in found]


def path_of(file):
    return ROOT / file if file.startswith("solutions/") else BACKEND / file


def with_header(path):
    """The text of a file, and of the header it implements."""
    return "".join(read(file) for file in {path, path.with_suffix(".h")} if file.is_file())


def sources():
    return "".join(read(path) for path in BACKEND.rglob("*") if path.suffix in (".h", ".cc"))


class Engineers(unittest.TestCase):
    def test_index_of_formulas_is_long_enough_and_complete(self):
        table = read(INDEX).partition("## Index of formulas")[2]
        self.assertGreaterEqual(len(rows()), 25)
        self.assertEqual(len(rows()), len(re.findall(r"^\| (?!formula|---)", table, re.M)), "a row was not understood")

    def test_each_file_of_the_index_holds_its_functions(self):
        for formula, _, path, functions in rows():
            self.assertTrue(path.is_file(), f"{formula}: {path}")
            self.assertTrue(functions, formula)
            for function in functions:
                name = function.rpartition("::")[2]
                defined = rf"\b{re.escape(function)}\b(\(|<| :| \{{)|\b(class|struct|\w[\w<>:*&]*) {name}\b(\(|<| :| \{{)"
                self.assertRegex(read(path), defined, f"{formula}: {path} does not define {function}")

    def test_each_file_of_the_index_names_its_source(self):
        for formula, source, path, _ in rows():
            if source.startswith("chapter 5") or source == "chain rule":
                continue
            author = re.match(r"(?:BAL, )?(\w+(?: & Van Loan)?)", source)[1]
            text = with_header(path)
            self.assertIn(author, text, f"{formula}: {path} does not name {author}")
            for number in re.findall(r"(?:eqs?\.|§|alg\.) ?([\w.]+)", source):
                self.assertIn(number, text, f"{formula}: {path} does not name {source}")

    def test_doxygen_reads_the_name_of_every_exception(self):
        for path in tracked_files(".h"):
            for name in re.findall(r"@throws\s+(\S+)", read(ROOT / path)):
                self.assertRegex(name, r"^((\w+::)+\w+|[A-Z]\w+)$", path)

    def test_names_in_the_walk_exist(self):
        text, count = sources(), 0
        for span in spans(read(WALK)):
            if "/" in span or span.endswith((".h", ".cc")):
                places = [folder / span for folder in (BACKEND / "sparse", BACKEND)]
                self.assertTrue(any(place.exists() for place in places), span)
            else:
                name = span.rpartition("::")[2].rstrip("s") if span.endswith("Blocks") else span.rpartition("::")[2]
                self.assertRegex(text, rf"\b{name}\b", f"{span} is not in the sources")
            count += 1
        self.assertGreater(count, 40)
