"""Every claim has a row in experiments/evidence.json, and every row is whole and holds.

A claim is what a machine can find: a table that a page may ask, a result page of a deck, and in the other pages a number with a
unit, or a line of a table of measurements. Such a number must be one that a row of its section computes, or be "stated" there.
"""

import contextlib
import importlib.util
import io
import json
import os
import re
import tempfile
import unittest
from argparse import Namespace
from unittest import mock

from tests.docs.markdown import DECKS, ENGINEERS, GUIDES, PAGES, READMES, ROOT, headings, prose, read, sections, slides
from tests.project import DATA, OUT

from ch5_backend.course.__main__ import main
from ch5_backend.course.base.anchors import anchor
from ch5_backend.course.base.errors import CourseError
from ch5_backend.course.documents import evidence
from ch5_backend.course.experiments.figure_sets import SETS
from ch5_backend.figures.tables import Tables

UNIT = r"%|ms|µs|cm|mm|px|times|倍|GB\b|MB|rad⁻²|rad/s|°|Hz|s\b|m\b|images a second"
NUMBERS = re.compile(rf"((?<![\w.+])[−+-]?\d[\d,.]*(?:(?: ± | to |–| and | 到 | 和 |、)[−+-]?\d[\d.]*)*)[ \xa0]?({UNIT})")
MEASUREMENT = r"^\|.*\d\.\d.*\|$|[\d.]+ \([\d.]+–[^)|]+\)|AMD EPYC \([^)]*\)|[\d-]{10}(?:/[\d-]{10})*"  # a row of a table, a span, where, when


def documents():
    """[(name of the English page, [page in each language])], of those that claim."""
    grading = tuple(ROOT / f"ch5_homework/GRADING{end}.md" for end in ("", ".zh"))
    pairs = (READMES, *PAGES, *(pair for pair in ENGINEERS if pair[0] not in evidence.PAGES.values()), GUIDES, grading)
    return [(str(pair[0].relative_to(ROOT)), pair) for pair in pairs]


def measured(text):
    """{(number, unit)} of a text; in 0.75 to 0.81 m both are meters."""
    found = NUMBERS.findall(re.sub(r"`[^`\n]*`|\]\([^)]*\)", "", prose(text)))
    return {(number, unit.replace("倍", "times")) for numbers, unit in found for number in re.findall(r"\d+(?:\.\d+)?", numbers)}


class Evidence(unittest.TestCase):
    def text_of(self, page, section, lang):
        """What the rows of a section say in a language."""
        return "\n".join(evidence.filled(row, field, lang) for row in evidence.ROWS.values() for field in ("claim", "n", "settings", "rivals")
                         if {page, f"{page}#{section}"} & set(row["where"])).replace("\xa0", " ")

    def each_section(self):
        for page, pair in documents():
            anchors = ["", *(anchor(title) for title, _ in sections(read(pair[0]))[1:])]
            for lang, path in zip(("en", "zh"), pair):
                for section, (_, body) in zip(anchors, sections(read(path)), strict=True):
                    yield page, section, lang, body

    def test_every_number_with_a_unit_is_computed_by_a_row_or_stated(self):
        lost = [(page, section, lang, number) for page, section, lang, body in self.each_section()
                for number in measured(body) - measured(self.text_of(page, section, lang)) - measured(evidence.STATED.get(page, ""))]
        self.assertEqual(lost, [], "no row of evidence.json gives them")

    def test_measurements_are_those_of_the_rows(self):
        named = {place for row in evidence.ROWS.values() for place in row["where"]}
        lines = [(line, self.text_of(page, section, lang)) for page, section, lang, body in self.each_section()
                 if f"{page}#{section}" in named and "README" in page for line in re.findall(MEASUREMENT, body, re.M)]
        self.assertGreater(len(lines), 25)
        for line, text in lines:
            self.assertIn(line, text)

    def test_what_is_stated_stands_on_its_page(self):
        pages = dict(documents())
        for page, text in evidence.STATED.items():
            self.assertLessEqual(measured(text), set.union(*(measured(read(path)) for path in pages[page])), page)

    def test_what_a_number_is(self):
        self.assertEqual(measured("It is 3.1 to 4 times as fast, at 20\xa0Hz; see `5 ms`."), {("3.1", "times"), ("4", "times"), ("20", "Hz")})
        self.assertEqual(measured("误差小 12 %，快 2.5 倍"), {("12", "%"), ("2.5", "times")})

    def test_every_table_belongs_to_a_row(self):
        listed = {row["table"] for row in Tables(ROOT / "ch5_backend/experiments")("tables").rows()}
        kept = {path.stem for folder in evidence.KEPT for path in folder.glob("*.csv")} - {"measured"}
        trials = {f"gauge/{study}" if one.folder == "gauge" else study for one in SETS for study in one.trials}
        named = [table for row in evidence.ROWS.values() for table in row["tables"]]
        self.assertEqual(listed | kept | trials | {"endurance"}, set(named), "each table needs a row of evidence.json, each row a table")

    def test_every_result_page_stands_in_a_row_and_every_place_exists(self):
        named = {place for row in evidence.ROWS.values() for place in row["where"]}
        places = {f"slides/{deck.name[:-6]}#{name}": result for deck in DECKS for name, result, _ in slides(read(deck))}
        self.assertLessEqual({place for place, result in places.items() if result}, named)
        for place in named - places.keys():
            page, _, section = place.partition("#")
            self.assertTrue(not section or section in [anchor(words) for _, words in headings(read(ROOT / page))], place)

    def test_every_row_is_whole(self):
        for name, row in evidence.ROWS.items():
            self.assertLessEqual({"claim", "tables", "where", "n"}, row.keys(), name)
            for field in ("claim", "n", "settings", "rivals", "by hand"):
                self.assertEqual(set(row.get(field, evidence.WORDS)), {"en", "zh"}, (name, field))
            self.assertEqual("by hand" in row, not evidence.commands(row), name)
            for mark in row.get("each", ()):
                self.assertTrue(any(mark in one for one in row["holds"]), (name, mark))

    def test_every_part_of_a_command_exists(self):
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(ROOT)  # where they are called
        for name, row in evidence.ROWS.items():
            for line in evidence.commands(row, typed=False):
                program, *words = line.split()
                if program == "ch5_backend.course":
                    if DATA.exists() and "{out}/flight" not in line:
                        self.assertEqual(main([word.format(data=DATA, out=ROOT) for word in words], only_read=True), 0, (name, line))
                    continue
                source = importlib.util.find_spec(program).origin if "." in program and "/" not in program else next(
                    ROOT.glob(f"*/**/{program.rpartition('/')[2]}.cc"))
                for word in words:
                    if re.match(r"--|[a-z_]+$", word):
                        self.assertRegex(read(source) + " ".join(study for one in SETS for study in one.trials), rf"\b{word.strip('-')}\b", (name, line))

    def test_pages_are_current(self):
        for lang, path in evidence.PAGES.items():
            self.assertEqual(read(path), evidence.page(lang), f"{path}: python3 -m ch5_backend.course.documents.evidence")

    def test_every_claim_holds(self):
        if not (OUT / "csv/solver_pcg.csv").exists():
            self.skipTest(f"{OUT} has no tables; ./course slides writes them")
        tables = evidence.Found(*evidence.KEPT, OUT)
        self.assertGreater(sum(len(evidence.conditions(row)) for row in evidence.ROWS.values()), 150)
        for name, row in evidence.ROWS.items():
            self.assertEqual(evidence.broken(row, tables), [], name)

    def test_a_claim_that_fails_is_named(self):
        row = json.loads(json.dumps(evidence.ROWS["preintegration"]))
        row["holds"] = ["1 < 2", "np.median(table('preintegration').claimed) < 0"]
        self.assertEqual(evidence.broken(row, evidence.Found(*evidence.KEPT)), row["holds"][1:])

    def test_the_command_says_what_holds_and_what_does_not(self):
        for densities, code, word in (("1", 0, "holds: "), ("0.5", 1, "DOES NOT HOLD: ")):
            def compute(row, out):
                text = read(evidence.KEPT[0] / "preintegration.csv").splitlines()
                rows = [line.split(",") for line in text[1:]]
                scaled = [",".join([*row[:4], str(float(densities) * float(row[4])), row[5]]) for row in rows]
                (out / "preintegration.csv").write_text("\n".join([text[0], *scaled]))
            said = io.StringIO()
            with tempfile.TemporaryDirectory() as out, mock.patch.object(evidence, "compute", compute), contextlib.redirect_stdout(said):
                self.assertEqual(evidence.evidence(Namespace(name="preintegration", language="en", out=out)), code)
            self.assertIn(f"\n{word}(table('preintegration').claimed / table('preintegration').measured - 1).min() > -0.08   [", said.getvalue())
        with self.assertRaisesRegex(CourseError, "no claim is called 'front'"):
            evidence.refuse("front")
