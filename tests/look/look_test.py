"""Every kind of page is looked at: as it was accepted, without a violation of axe, a complaint, or a way to scroll sideways."""

import json
import os
import tempfile
import unittest
from pathlib import Path

from slides import browser, npm
from tests.look import views
from tests.project import BUILD, OUT, ROOT

SITE = Path(os.environ.get("CH5_SITE", OUT / "site"))
LAB = Path(os.environ.get("CH5_LAB_PAGE", ROOT / "out" / "lab.html"))
LOOKED = BUILD / "look"
WITHOUT_AXE = {"deck"}  # one page of Marp's; Docs.built_decks looks at its words


class Look(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if missing := [str(path) for path in (SITE / "index.html", LAB) if not path.exists()]:
            raise unittest.SkipTest(f"not there: {', '.join(missing)}")
        try:
            from tests.lab.chromium_page import Page
            cls.page = Page()
            cls.axe = (npm.installed() / "axe-core" / "axe.min.js").read_text(encoding="utf-8")
        except (ImportError, browser.BuildError) as missing:
            raise unittest.SkipTest(f"{missing}; Debian: apt-get install python3-selenium chromium-driver") from missing
        cls.addClassCleanup(cls.page.driver.quit)
        folder = tempfile.TemporaryDirectory(prefix="ch5-look-")
        cls.addClassCleanup(folder.cleanup)
        cls.kinds = views.kinds(SITE.resolve(), LAB.resolve(), Path(folder.name))

    def faults(self, width):
        """What is wrong beside the look."""
        found = [f"scrolls sideways: {wide}" for wide in [self.page.evaluate("document.documentElement.scrollWidth")] if wide > width]
        self.page.evaluate(f"{self.axe}; true")
        # What MathJax sets has its words in MathML, which axe does not read.
        found += self.page.evaluate("axe.run({rules: {'empty-table-header': {enabled: false}}}).then(({violations}) => violations.map(one => [one.id, one.impact, one.nodes[0].html.slice(0, 200)]))")
        return found + self.page.complaints()

    def test_every_page_in_every_condition(self):
        LOOKED.mkdir(exist_ok=True)
        kept, seen, different, faults = views.accepted(), {}, [], {}
        wanted = os.environ.get("CH5_LOOK", "")  # only the kinds with this word
        for kind in (kind for kind in self.kinds if wanted in kind):
            for language, width, scheme in views.CONDITIONS:
                name = f"{kind} {language} {width} {scheme}"
                views.show(self.page, *self.kinds[kind][language], width, scheme)
                if wrong := self.faults(width) if kind not in WITHOUT_AXE else self.page.complaints():
                    faults[name] = wrong
                picture = views.look(self.page, width)
                seen[name] = views.packed(views.cells_of(picture), picture.size)
                cells = views.changed(kept[name], picture) if name in kept else [(0, 0)]
                if cells:
                    different.append((name, kept.get(name), seen[name][2:4], cells))
                picture.save(LOOKED / views.file_of(name), quality=80)
        (LOOKED / "seen.json").write_text(json.dumps(seen), encoding="utf-8")
        views.write_page(LOOKED, different)
        self.assertEqual(faults, {}, "\n".join(f"{name}: {wrong}" for name, wrong in faults.items()))
        self.assertEqual([name for name, *_ in different], [], f"look at {LOOKED / 'index.html'}; python3 -m tests.look accept if it is right")
        self.assertTrue(wanted or set(seen) == set(kept), "a view that is no longer there: python3 -m tests.look accept")

    def test_what_is_missing_or_moved_is_seen(self):
        hide = "document.querySelector({!r}).style.visibility = 'hidden'".format
        for kind, does in (("lab task", "document.getElementById('task-next').remove()"), ("lab", hide("#compare")), ("lab flight", hide("[data-key=claims] svg")),
                           ("feedback", "document.querySelector('figure svg').style.marginLeft = '40px'"),
                           ("handout", "document.querySelector('article p').remove()"), ("chapter", hide("nav a:nth-child(3)"))):
            for width in (1280, 390):
                with self.subTest(kind, width=width):
                    pictures = []
                    for first in ("", "", f"{does}; "):
                        views.show(self.page, *self.kinds[kind]["en"], width, "light")
                        pictures.append(views.look(self.page, width, first))
                    as_it_is, once_more, wrong = pictures
                    kept = views.packed(views.cells_of(as_it_is), as_it_is.size)
                    self.assertEqual(views.changed(kept, once_more), [])
                    self.assertNotEqual(views.changed(kept, wrong), [])

    def test_a_violation_and_a_complaint_are_found(self):
        views.show(self.page, *self.kinds["feedback"]["en"], 390, "light")
        self.assertEqual(self.faults(390), [])
        self.page.evaluate("""document.body.insertAdjacentHTML("beforeend", '<p style="width:2000px;color:#eee">wide</p>'); console.error("no")""")
        found = str(self.faults(390))
        for words in ("scrolls sideways", "color-contrast", "no"):
            self.assertIn(words, found)
