"""The decks as they are shown: built, measured in Chromium, compared with their tables."""

import os
import re
import shutil
import sys

from tests.docs.markdown import read, slides
from tests.folder import FolderTest
from tests.project import OUT, run

from ch5_backend.figures.tables import TableError
from slides import browser, build

TABLES, BUILT = OUT / "csv", OUT / "slides"


def built(*words, seed="1"):
    return run(sys.executable, "-m", "slides.build", *words, env={**os.environ, "PYTHONHASHSEED": seed})


class BuiltDecks(FolderTest):
    def setUp(self):
        super().setUp()
        for needed in (browser.node, browser.chromium):
            try:
                needed()
            except browser.BuildError as missing:
                self.skipTest(str(missing))
        self.pages = [BUILT / f"{deck.stem}.html" for deck in build.decks()]
        self.assertEqual([page for page in self.pages if not page.exists()], [])

    def test_nothing_reaches_out_of_its_page_or_figure(self):
        self.assertEqual(browser.overflow(self.pages), {deck.stem: (len(slides(read(deck))) + 1, []) for deck in build.decks()},
                         "the last page has the answers")

    def test_what_does_reach_out_is_found(self):
        html = read(self.pages[0])
        wide = self.folder / "wide.html"
        figure = "data:image/svg+xml;base64," + build.base64.b64encode(
            b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 50 20" width="50" height="20"><title>narrow</title>'
            b'<text x="20" y="15">far too many words</text></svg>').decode()
        wide.write_text(html.replace("</head>", "<style>section { font-size: 40px !important; }</style></head>")
                        .replace("</section>", f'<img src="{figure}"></section>', 1), encoding="utf-8")
        _, found = browser.overflow([wide])["wide"]
        self.assertTrue(any("below the footer's top" in line for line in found))
        self.assertTrue(any("figure “narrow”" in line for line in found))

    def test_built_again_one_is_the_same_to_the_byte(self):
        """Its words and its page; the figures of all: Docs.decks."""
        name = build.decks()[0].stem
        done = built("--html", "--csv", TABLES, "--out", self.folder, name, seed="7")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.pages[0].read_bytes(), (self.folder / f"{name}.html").read_bytes())

    def test_every_page_brings_its_speaker_note_and_its_figures_words(self):
        for deck, page in zip(build.decks(), self.pages):
            notes = re.findall(r"<!-- \(\d+ min\) ", read(deck))
            self.assertEqual(len(re.findall(r'<div class="bespoke-marp-note"', read(page))), len(notes), page.name)
            self.assertNotIn('alt=""', read(page), f"{page.name}: a figure without words")

    def test_a_pdf_has_a_page_for_every_slide(self):
        name = build.decks()[0].stem
        done = built("--csv", TABLES, "--out", self.folder, name)
        self.assertEqual(done.returncode, 0, done.stderr)
        pdf = (self.folder / f"{name}.pdf").read_bytes()
        self.assertEqual(len(re.findall(rb"/Type\s*/Page\b", pdf)), len(slides(read(build.decks()[0]))) + 1)

    def test_a_changed_table_makes_the_check_fail_and_building_mends_it(self):
        tables, out = self.folder / "csv", self.folder / "slides"
        shutil.copytree(TABLES, tables)
        words = "--csv", tables, "--out", out, "2-solvers.en"
        self.assertEqual(built("--check", *words).returncode, 1)
        self.assertEqual(built("--html", *words).returncode, 0)
        for name, was, now in (("paths", "-1.2,1,12.0", "-1.2,1,13.0"), ("losses", "huber,1,0.5", "huber,1,0.9")):
            table = tables / f"solver_{name}.csv"
            table.write_text(read(table).replace(was, now), encoding="utf-8")
        stale = built("--check", *words)
        self.assertEqual(stale.returncode, 1)
        self.assertRegex(stale.stderr, r"number newton\.cost\[0\] \| f1 is out of date: 12\.1 on the slide, 13\.1 in the tables")
        self.assertRegex(stale.stderr, r"figure losses is out of date")
        self.assertEqual(built("--html", *words).returncode, 0)
        self.assertEqual(built("--check", *words).returncode, 0)

    def test_tables_of_an_older_version_are_named_with_the_remedy(self):
        """Rows that are not there yet, as gauge/csv/near_start.csv had none of one start."""
        with self.assertRaisesRegex(TableError, "not what this version writes.*plots --rerun"), build.of_this_version(self.folder):
            [][0]

    def test_an_old_node_is_named(self):
        old = self.folder / "node"
        old.write_text("#!/bin/sh\necho v12.22.9\n", encoding="utf-8")
        old.chmod(0o755)
        script = ("from slides import browser; import shutil; shutil.which = lambda name: %r if name == 'node' else None\n"
                  "try: browser.node()\nexcept browser.BuildError as e: print(e.code, e)" % str(old))
        done = run(sys.executable, "-c", script)
        self.assertRegex(done.stdout, r"^2 the slides need Node\.js 18 or newer, but \S.*/node is v12\.22\.9; ")
