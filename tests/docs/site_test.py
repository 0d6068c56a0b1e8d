"""The site: every link on every page leads to a file and a place that are there, and none leads out of it."""

import os
import re
import shutil
import sys
import tempfile
import unittest
import zlib
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

from tests.docs.markdown import ROOT, read
from tests.project import run

SITE = Path(os.environ.get("CH5_SITE", ROOT / "out/site")).resolve()


class Page(HTMLParser):
    """What a page links to, and the places in it that can be linked to."""

    def __init__(self, text):
        super().__init__()
        self.links, self.places = [], set()
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.links += [attributes[name] for name in ("href", "src") if attributes.get(name)]
        self.places |= {attributes[name] for name in ("id", "name") if attributes.get(name)}


def faults(site) -> list:
    """(page, link, what is wrong) for each broken link; and how many there are."""
    pages = {path.resolve(): Page(read(path)) for path in site.rglob("*.html")}
    found, count = [], 0
    for path, page in pages.items():
        for link in page.links:
            if re.match(r"(https?|data|mailto|javascript):", link):
                continue
            count += 1
            file, _, fragment = unquote(link).partition("#")
            target = (path.parent / file.partition("?")[0]).resolve() if file else path
            if site not in target.parents:
                found.append((path.name, link, "leads out of the site"))
            elif not target.is_file():
                found.append((path.name, link, "there is no such file"))
            elif fragment and not has(target, fragment, pages):
                found.append((path.name, link, "there is no such place"))
    return found, count


def has(target, fragment, pages) -> bool:
    if fragment in pages[target].places or target.name == "lab.html":  # the lab reads its settings there
        return True
    return target.parent.name == "slides" and 1 <= int(fragment) <= read(target).count("<svg data-marpit-svg")


def addresses_in(pdf: bytes) -> list:
    """What a PDF links to."""
    text = pdf
    for stream in re.findall(rb"stream\r?\n(.*?)endstream", pdf, re.DOTALL):
        try:
            text += zlib.decompress(stream)
        except zlib.error:
            pass
    return [address.decode("latin-1") for address in re.findall(rb"/URI\s*\((.*?)\)", text)]


@unittest.skipUnless((SITE / "index.html").exists(), f"{SITE} is not there: ./course site makes it")
class Site(unittest.TestCase):
    def test_every_link_leads_somewhere(self):
        found, count = faults(SITE)
        self.assertEqual(found, [])
        self.assertGreater(count, 1000)

    def test_a_broken_link_is_found(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder).resolve()
            (folder / "there.html").write_text('<p id="place"><a href="there.html#place">a</a><a href="#gone">b</a>'
                                               '<a href="gone.html">c</a><img src="../above.png">', encoding="utf-8")
            found, count = faults(folder)
            self.assertEqual(([link for _, link, _ in found], count), (["#gone", "gone.html", "../above.png"], 4))

    def test_no_pdf_links_to_the_machine_that_printed_it(self):
        for path in SITE.glob("slides/*.pdf"):
            for address in filter(None, addresses_in(path.read_bytes())):
                self.assertTrue(address.startswith("http") or (path.parent / address.partition("?")[0]).is_file(), (path.name, address))

    @unittest.skipUnless(list(SITE.glob("slides/*.html")), "without decks: see what Docs.decks_build says")
    def test_front_page_has_both_languages_and_every_lecture_and_stage(self):
        front = Page(read(SITE / "index.html"))
        for deck in (ROOT / "slides").glob("[0-9]-*.md"):
            self.assertLessEqual({f"slides/{deck.stem}.html", f"lectures/{deck.stem}.html"}, set(front.links))
        for page in (ROOT / "ch5_homework/handout").glob("*.md"):
            self.assertIn(f"homework/{page.stem}.html", front.links)
        self.assertLessEqual({"en", "zh"}, front.places)

    def test_no_page_needs_another_host(self):
        for path in SITE.rglob("*.html"):
            self.assertNotRegex(read(path), r'<(?:script|img|link)[^>]+(?:src|href)="(?:https?:)?//', path.name)

    def test_speaker_notes_stay_at_home(self):
        for path in SITE.glob("slides/*.html"):
            self.assertNotIn('<div class="bespoke-marp-note"', read(path), path.name)

    @unittest.skipUnless(list(SITE.glob("slides/*.html")), "without decks: see what Docs.decks_build says")
    def test_handouts_lead_to_the_page_of_a_lecture_with_its_formulas(self):
        for end, language in (("", "en"), (".zh", "zh")):
            page, lecture = read(SITE / f"homework/stage_1.1{end}.html"), read(SITE / f"lectures/1-back-end.{language}.html")
            self.assertRegex(page, rf'href="\.\./lectures/1-back-end\.{language}\.html#\S')
            self.assertIn(r"$$ H_{ij} \mathrel{+}= J_i^\top W J_j,", lecture)
            self.assertIn('src="../api/mathjax/MathJax.js"', lecture)
            self.assertNotIn(".md", page)

    def test_another_folder_is_not_replaced(self):
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "site").mkdir()
            shutil.copy(__file__, Path(folder, "site"))
            done = run(sys.executable, "-m", "ch5_backend.course.documents.site", folder, cwd=ROOT)
            self.assertEqual(done.returncode, 2)
            self.assertIn("holds something else", done.stderr)
