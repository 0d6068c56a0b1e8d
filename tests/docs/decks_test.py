"""The decks: both languages show the same, every number comes from a table, every figure from a script."""

import base64
import io
import itertools
import json
import re
import unittest
from argparse import Namespace
from unittest import mock

from matplotlib.pyplot import imread

from tests.docs.markdown import DECKS, fences, formulas, prose, read, slides
from tests.experiments.figure_look_test import faults, has_english
from tests.project import OUT, ROOT

from slides import build
from ch5_backend.course.documents import slides as command
from ch5_backend.figures import slide
from ch5_backend.figures.tables import Tables
from ch5_backend.figures.words import Labels

TABLES = Tables(OUT / "csv")
STAGES = {stage["id"] for stage in json.loads(read(ROOT / "ch5_homework/stages.json"))["stages"]}
PLACEHOLDER, FIGURE = build.PLACEHOLDER.pattern, r"!\[([^\]]*)\]\(figures/(\w+)\.svg\)"
LAB = r"\(\.\./lab\.html\?lang=\w\w#([^)]*)\)"


def pairs():
    """(id, English page, Chinese page) of every slide."""
    for english in DECKS:
        pages = slides(read(english)), slides(read(str(english).replace(".en.", ".zh.")))
        yield from ((one[0], one, other) for one, other in zip(*pages))


def numbers(svg):
    """A figure's words, and the numbers of its paths and matrices: neither rounding nor matplotlib's version counts."""
    paths = [float(number) for d in re.findall(r' d="([^"]*)"', svg) for number in re.findall(r"-?\d+\.?\d*", d)]
    matrices = [imread(io.BytesIO(base64.b64decode(png))) for png in re.findall(r"data:image/png;base64,([^\"]*)", svg)]
    return re.findall(r">([^<>\s][^<>]*)</text>", svg), [*paths, *(value for matrix in matrices for value in matrix.flat)]


class Decks(unittest.TestCase):
    def need_tables(self):
        if not TABLES.folder.exists():
            self.skipTest(f"{TABLES.folder} is missing; ./course run writes it")

    def test_both_languages_have_the_same_pages(self):
        self.assertTrue(DECKS)
        for english in DECKS:
            ids = [[(name, result) for name, result, _ in slides(read(path))]
                   for path in (english, str(english).replace(".en.", ".zh."))]
            self.assertEqual(*ids)
            names = [name for name, _ in ids[0]]
            self.assertNotIn(None, names, "a page without <!-- slide: … -->")
            self.assertEqual(len(set(names)), len(names), "two pages of one name")

    def test_both_languages_show_the_same(self):
        for name, one, other in pairs():
            one, other = one[2], other[2]
            self.assertEqual(sorted(formulas(one)), sorted(formulas(other)), f"{name}: formulas")
            self.assertEqual(re.findall(FIGURE, one), re.findall(FIGURE, other), f"{name}: figures")
            self.assertEqual(*([(language, re.sub(r" +# .*", "", code) if language == "sh" else code) for language, code in fences(page)]
                               for page in (one, other)), f"{name}: code")  # comments to a command may be translated
            self.assertEqual(re.findall(LAB, one), re.findall(LAB, other), f"{name}: states of the lab")
            self.assertEqual(sorted(re.findall(PLACEHOLDER, one)), sorted(re.findall(PLACEHOLDER, other)), name)
            self.assertEqual(re.findall(r"_class: .*", one), re.findall(r"_class: .*", other), name)
            self.assertEqual(len(re.findall(r"^\|", one, re.M)), len(re.findall(r"^\|", other, re.M)), f"{name}: table")

    def test_every_figure_has_a_script_and_a_page(self):
        drawn = {}
        for deck in DECKS:
            figures = set(build.module_of(deck).FIGURES)
            self.assertEqual(set(), figures & set(drawn), f"{deck.name}: names that another deck has")
            shown = {figure for page in slides(read(deck)) for _, figure in re.findall(FIGURE, page[2])}
            self.assertEqual(figures - {"overview"}, shown, deck.name)
            drawn.update(dict.fromkeys(figures))

    def test_result_pages_have_no_typed_number(self):
        results = [(name, page[2]) for name, one, other in pairs() if one[1] for page in (one, other)]
        self.assertGreater(len(results), 10)
        for name, page in results:
            self.assertEqual([query for query in re.findall(PLACEHOLDER, page) if not re.search("[a-z]{3}", query)], [], "a typed number")
            rest = re.sub(rf"<!--.*?-->|{PLACEHOLDER}|{FIGURE}|{LAB}", "", prose(page), flags=re.S)
            rest = re.sub(r"[_^]\{?-?\w+\}?", "", rest)  # indices and exponents of formulas
            self.assertEqual(re.findall(r".{0,20}\d.{0,20}", rest), [], f"{name}: let a placeholder say it")
        used = {name for name, page in results if re.search(PLACEHOLDER, page) or re.search(FIGURE, page)}
        self.assertEqual(used, {name for name, _ in results}, "a result page without a result")

    def test_numbers_and_figures_are_there_and_can_be_read(self):
        """Drawn once for all: every placeholder has its number, every word of a figure is in the page's language, none is small at
        its width, and what has been built was drawn the same to the byte."""
        self.need_tables()
        built = build.read_record(OUT / "slides")  # none without Node.js
        english, found, say, render = set(), {}, Labels.__call__, slide.Slide.render

        def noted(labels, label, **values):
            words = say(labels, label, **values)
            if labels.language == "zh" and has_english(words):
                english.add(words)
            return words

        def measured(page, kind):
            text = render(page, kind)
            found[language, page.title] = faults(page.figure, shown=page.width)  # a page of 1280 pixels shows it as it is
            return text
        with mock.patch.object(Labels, "__call__", noted), mock.patch.object(slide.Slide, "render", measured):
            for language in build.LANGUAGES:
                for draw in build.pictures().values():
                    draw(TABLES, language)
            for deck in build.decks():
                language = build.language(deck)
                made = build.Prepared(deck, TABLES.folder)
                self.assertNotIn("{{", made.text)
                self.assertNotIn("<!-- slide:", made.text)
                self.assertGreater(len(made.figures), 5)
                for name, svg in made.figures.items():
                    self.assertTrue(svg.startswith("<svg "), name)
                    self.assertNotRegex(svg, r"\b(nan|inf)\b", name)
                    self.assertNotRegex(svg, r">[^<]*\b[A-Za-z]_[A-Za-z]", f"{name}: an index that is not set as one")
                    self.assertNotRegex(svg, r">[^<]*[\u4e00-\u9fff][,:] ", f"{name}: a comma or colon of half width")
                self.assertEqual(self.small_words(deck, made), [])
                if deck.stem in built:
                    self.assertEqual(made.record(), {kind: built[deck.stem][kind] for kind in made.record()})
        self.assertEqual(english, set())
        self.assertGreater(len(found), 40)
        self.assertEqual({name: wrong for name, wrong in found.items() if wrong}, {})

    def small_words(self, deck, made):
        """Words that are smaller than 14 pixels of 1280."""
        return [(name, word) for width, name in re.findall(r"!\[w:(\d+)\]\(figures/(\w+)\.svg\)", read(deck))
                for units in [float(re.search(r'viewBox="0 0 ([\d.]+)', made.figures[name])[1])]
                for size, word in re.findall(r"<text[^>]*?([\d.]+)px[^>]*>([^<]*)<", made.figures[name])
                if float(size) * int(width) / units < 13.9]

    def test_every_page_ends_with_its_speaker_note_and_a_deck_takes_60_to_90_minutes(self):
        note = r"\n\n<!-- \((\d+) min\) (?:(?!-->).){10,} -->\s*\Z"
        for english in DECKS:
            times = [[(name, re.search(note, page)) for name, _, page in slides(read(path))]
                     for path in (english, str(english).replace(".en.", ".zh."))]
            self.assertEqual([name for pages in times for name, found in pages if not found], [], english.name)
            minutes = [[int(found[1]) for _, found in pages] for pages in times]
            self.assertEqual(*minutes)
            self.assertTrue(60 <= sum(minutes[0]) <= 90, f"{english.name}: {sum(minutes[0])} minutes")

    def test_what_a_deck_refers_to_exists(self):
        tables = [path.stem for path in (ROOT / "slides/measured").glob("*.csv")]
        self.assertIn("speed_steps", tables)
        for deck in build.decks():
            text = read(deck)
            for path in re.findall(r"`((?:\w[\w.-]*/)+[\w.-]*)`", prose(text)):
                self.assertTrue((ROOT / path).exists() or (ROOT / "ch5_backend" / path).exists(), f"{deck.name}: {path}")
            for target in re.findall(r"(?<!!)\[[^\]]*\]\(([^)\s]+)\)", prose(text)):
                self.assertRegex(target, r"^(https://|\.\./(lab|report)\.html)", f"{deck.name}: out/slides/ has no {target}")
            for stage in re.findall(r"\./course (?:check|hint) ([\d.]+)", text):
                self.assertIn(stage, STAGES, deck.name)

    def test_tables_are_made_for_the_decks_that_are_named(self):
        for names, wanted in ((["2-solvers.en"], ["slides/2"]), ([], [f"slides/{number}" for number in range(1, 8)])):
            with mock.patch.object(command, "build_decks", return_value=0), mock.patch.object(command, "make_missing") as make:
                command.slides(Namespace(html=True, check=False, names=names), [])
            self.assertEqual([one.name for one in make.call_args[0][0]], wanted)

    def test_a_figure_on_a_page_is_told_in_words(self):
        shown = build.inline('<img src="figures/one.zh.svg" alt="" />', {"one": "<svg><title>图</title></svg>"}, "zh")
        self.assertRegex(shown, '<img src="data:[^"]*" alt="图" />')

    def test_no_line_begins_with_the_mark_behind_a_formula(self):
        formula = '<mjx-container class="MathJax"><svg></svg></mjx-container>'
        for behind, wanted in (("。", f"{formula}。</span>"), ("</em>。", f"{formula}。</span></em>"), ("</em> 和", None)):
            shown = build.inline(formula + behind, {}, "zh")
            self.assertEqual(shown, f'<span style="white-space: nowrap">{wanted}' if wanted else formula + behind)

    def test_an_unknown_placeholder_is_an_error(self):
        with self.assertRaisesRegex(build.BuildError, r"deck.md:2: .*no\.such"):
            build.fill("one\n{{no.such | f1}}", {}, TABLES, "deck.md")

    def test_pictures_of_the_guide_and_the_homework_are_current(self):
        self.need_tables()
        for (name, draw), lang in itertools.product(build.pictures().items(), build.LANGUAGES):
            committed, drawn = (numbers(svg) for svg in (read(ROOT / f"slides/figures/{name}.{lang}.svg"), draw(TABLES, lang)))
            self.assertEqual(committed[0], drawn[0], "redraw it: slides/build.py --overview")
            self.assertEqual(len(committed[1]), len(drawn[1]), "redraw it: slides/build.py --overview")
            worst = max(abs(a - b) for a, b in zip(committed[1], drawn[1]))
            self.assertLess(worst, 0.05, "redraw it: slides/build.py --overview")

    def test_the_front_pages_picture_is_small_and_says_what_the_front_page_says(self):
        for language, page in (("en", "README.md"), ("zh", "README.zh.md")):
            text = read(ROOT / f"slides/figures/flight.{language}.svg")
            self.assertLess(len(text.encode()), 60_000)
            self.assertEqual(text.count('<polyline pathLength="1" class="path'), 4, "two paths and their errors")
            self.assertIn(f"![{re.search('aria-label=.([^>]+).>', text)[1]}]", read(ROOT / page))

    def test_marp_is_pinned_to_a_public_release(self):
        package = json.loads(read(ROOT / "slides/package.json"))
        lock = json.loads(read(ROOT / "slides/package-lock.json"))
        for name, version in package["dependencies"].items():
            self.assertEqual(lock["packages"][f"node_modules/{name}"]["version"], version)
        for name, entry in lock["packages"].items():
            self.assertTrue(not name or entry.get("integrity"), f"{name} is not pinned by its hash")
            self.assertTrue(entry.get("resolved", "https://registry.npmjs.org/").startswith("https://registry.npmjs.org/"))
