"""The reports say the same in both languages, and the Chinese ones say it in Chinese."""

import base64
import html
import io
import json
import re
import string
import tempfile
import unittest
from collections import Counter
from functools import cache
from pathlib import Path
from unittest import mock

from PIL import Image

from tests.experiments import report_texts
from ch5_backend.figures import page, words
from ch5_backend.figures.drawing import Axes
from ch5_backend.figures.queries import PLACEHOLDER
from ch5_backend.figures.words import PAGES, SENTENCES
from tests.folder import FolderTest
from tests.homework.chinese import english_in
from tests.project import ROOT

MINIMIZER = ROOT / "ch5_backend" / "solve" / "minimizer.cc"
NUMBER = re.compile(r"[+−-]?\d+(?:\.\d+)?(?: × 10)?[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]*")
SPOKEN = re.compile(r'(?:aria-label|alt|data-labels|data-empty|data-vertices|data-scrolls)="([^"]*)"')
SELDOM = {"lab.html", "recording.no_truth", "api/index.html", "odometry_path.alone", "odometry_path.silent", "odometry_path.at_rest", "odometry_spectrum.all", "odometry_timeline.restarts",
          "segment", "segment.words", "seconds", "gauge.quick", "gauge_methods.as", "gauge_methods.but", "gauge.extra", "gauge_matrices.alone",
          "gauge.machine_hall", "gauge.median_rmse", "gauge_recordings", "gauge_recordings.alt", *(key for key in SENTENCES["en"] if key.startswith(("warning", "failure.", "recordings.")))}
HALF_WIDTH = re.compile(r"[\u4e00-\u9fff][,:;?!()]|[,;?!()][\u4e00-\u9fff]")


def without_code(page):
    return re.sub(r"<(script|style)>.*?</\1>|src=\"data:[^\"]*\"", "", page, flags=re.S)


def words_of(page):
    """All that a reader sees or hears: what stands between the tags, and what is in them to be spoken or shown."""
    page = without_code(page)
    return html.unescape("\n".join([re.sub(r"<[^>]*>", "\n", page), *SPOKEN.findall(page)]))


@cache
def pages_of(of):
    """The English page, the Chinese one, and the keys of their sentences."""
    said, say = set(), words.Words.__call__
    noted = lambda self, key, **values: said.add(key) or say(self, key, **values)
    with tempfile.TemporaryDirectory(prefix="ch5-report-") as folder, mock.patch.object(words.Words, "__call__", noted):
        report_texts.write_reports(Path(folder), of)
        return *((Path(folder) / name).read_text(encoding="utf-8") for name in PAGES.values()), said


def ways_to_stop():
    """The solver's words in the tables."""
    return set(re.findall(r'case Termination::\w+: return "(.*)";', MINIMIZER.read_text(encoding="utf-8")))


class Sentences(unittest.TestCase):
    def test_no_key_stands_twice(self):
        for path in sorted((Path(words.__file__).parent / "words").glob("*.json")):
            keys = [key for key, _ in json.loads(path.read_text(encoding="utf-8"), object_pairs_hook=list)]
            self.assertEqual([key for key, times in Counter(keys).items() if times > 1], [], path.name)

    def test_both_languages_leave_room_for_the_same(self):
        self.assertEqual(*map(list, SENTENCES.values()))
        for key in SENTENCES["en"]:
            rooms = [{*PLACEHOLDER.findall(of[key]), *(name for _, name, _, _ in string.Formatter().parse(of[key]) if name)}
                     for of in SENTENCES.values()]
            self.assertEqual(*rooms, key)

    def test_chinese_is_chinese(self):
        for key, sentence in SENTENCES["zh"].items():
            sentence = PLACEHOLDER.sub("1", sentence)
            self.assertEqual(english_in(sentence), "", key)
            self.assertNotRegex(sentence, HALF_WIDTH, key)

    def test_every_way_to_stop_has_a_sentence(self):
        self.assertGreater(len(ways_to_stop()), 5)
        self.assertLessEqual(ways_to_stop(), set(SENTENCES["en"]))

    def test_every_sentence_is_said(self):
        said = set().union(*(pages_of(of)[2] for of in ("chapter", "recording", "gauge")))
        # Of a student's page those that need a mistake are rare.
        of_pages = {key for key in SENTENCES["en"] if not key.startswith("mine.")}
        self.assertEqual(of_pages - said - SELDOM - ways_to_stop(), set())

    def test_every_label_stands_in_a_figure(self):
        sources = [*ROOT.glob("ch5_backend/figures/**/*.py"), *ROOT.glob("slides/*.py"), *ROOT.glob("ch5_backend/experiments/**/*.cc"),
                   *ROOT.glob("ch5_backend/experiments/*.csv"), ROOT / "ch5_backend/course/experiments/fly.py"]
        text = re.sub(r'(?:\\n)?"\s+f?"', "", "".join(path.read_text(encoding="utf-8") for path in sources))
        for label in words.IN_CHINESE:
            for part in re.split(r"\{\w+\}|\n|: ", label):
                self.assertTrue(part in text, label)


class Escapes(unittest.TestCase):
    def test_whatever_is_put_into_a_piece_is_escaped(self):
        say, bad = words.Words("en"), '"<b>&'
        pieces = (page.table((bad, "x"), [(bad, bad)]), page.PIECES.player(bad, bad, bad, [bad], 0, [(bad, bad)], [], (bad,), [(0, bad)]),
                  page.PIECES.section(bad, bad, [bad]), page.PIECES.files([bad], say), Axes(bad, (0, 1), (0, 1), bad).svg(bad))
        for piece in pieces:
            self.assertIn("&lt;b&gt;&amp;", piece)
            self.assertNotIn("<b>", piece)


class Pictures(FolderTest):
    def test_a_picture_in_the_page_is_the_figure_to_the_pixel(self):
        path = self.folder / "a.png"
        report_texts.style.plt.imsave(path, [[[k % 7 / 7, j % 5 / 5, k / 300] for k in range(300)] for j in range(50)])
        with Image.open(path) as figure, Image.open(io.BytesIO(base64.b64decode(page.small(path, 0)))) as packed:
            self.assertEqual(figure.convert("RGB").tobytes(), packed.convert("RGB").tobytes())


class Reports(unittest.TestCase):
    def are_alike(self, of):
        english, chinese, _ = pages_of(of)
        for pattern in (r'id="([^"]*)"', r'href="#([^"]*)"', r'href="(?:figures|csv)/([^"]*)"', r'data-at="(\d+)"',
                        r'data-parts="([^"]*)"', r' d="([^"]*)"', r"<(\w+)"):
            found = [re.findall(pattern, without_code(page)) for page in (english, chinese)]
            self.assertEqual(*found, pattern)
        for pattern in (r"<figcaption>(.*?)</figcaption>", r"<t[dh]\b[^>]*>(.*?)</t[dh]>", r"<text[^>]*>(.*?)</text>",
                        r"<p\b[^>]*>(.*?)</p>", r"<title>(.*?)</title>"):
            found = [[html.unescape(re.sub(r"<[^>]*>", "", piece)) for piece in re.findall(pattern, without_code(page), re.S)]
                     for page in (english, chinese)]
            self.assertEqual(*map(len, found), pattern)
            for one, other in zip(*found):
                self.assertEqual(*(Counter(NUMBER.findall(text)) for text in (one, other)), (one, other))
        self.assertEqual([line for line in map(english_in, words_of(chinese).splitlines()) if line], [])
        for page in (english, chinese):
            self.assertEqual(re.findall(r"<td>[^<]*(?<![\w.])-\.?\d[^<]*</td>", page), [], "a hyphen for a minus")
        self.assertIn('<html lang="zh">', chinese)
        self.assertIn('<a href="report.zh.html" lang="zh" hreflang="zh">中文</a>', english)
        self.assertIn('<a href="report.html" lang="en" hreflang="en">English</a>', chinese)

    def captions_are_short(self, of):
        """What of a caption is not folded."""
        english, chinese, _ = pages_of(of)
        for page, pattern, most in ((english, r"\S+", 40), (chinese, r"[\u4e00-\u9fff]|[^\s\u4e00-\u9fff]+", 80)):
            captions = re.findall(r"<figcaption>(.*?) <span", without_code(page), re.S)
            self.assertEqual(len(captions), page.count("<figcaption>"))
            for caption in [*captions, *re.findall(r"<p>([^<]*)</p><details>", without_code(page))]:
                self.assertLessEqual(len(re.findall(pattern, html.unescape(caption))), most, caption)

    def test_both_have_the_same_sections_figures_and_numbers_under_short_captions(self):
        for of in ("chapter", "recording", "gauge"):
            with self.subTest(of):
                self.are_alike(of)
                self.captions_are_short(of)
