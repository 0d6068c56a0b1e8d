"""The chapter's report as its readers use it, in Chromium: by hand, by keys, by ear, on a phone, by night, offline."""

import html
import json
import re
import tempfile
import unittest
from pathlib import Path

from markupsafe import Markup

from slides import browser, npm
from ch5_backend.figures import page, style, tables
from tests.experiments.report_texts import write_reports
from tests.project import OUT
from tests.homework.chinese import english_in
from ch5_backend.figures.words import PAGES

PROBE = Path(__file__).with_name("report_probe.js").read_text(encoding="utf-8")
NOTHING_FROM_OUTSIDE = ('<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; img-src data:; '
                        'style-src \'unsafe-inline\'; script-src \'unsafe-inline\'">')
FRAMES = """<!doctype html><meta name="color-scheme" content="light dark"><body>FRAMES<script>
addEventListener("message", (event) => {
  const pre = document.createElement("pre");
  pre.textContent = event.data;
  document.body.append(pre);
});</script>"""
WIDTHS = (1280, 1000, 360)
NIGHT = "--blink-settings=preferredColorScheme=0"


class Report(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        try:
            browser.chromium()
            axe = npm.installed() / "axe-core" / "axe.min.js"
        except browser.BuildError as error:
            if error.code != 2:  # 2: something is missing
                raise
            raise unittest.SkipTest(str(error)) from error
        folder = tempfile.TemporaryDirectory(prefix="ch5-report-")
        cls.addClassCleanup(folder.cleanup)
        cls.out = Path(folder.name)
        write_reports(cls.out)
        cls.texts = {language: (cls.out / name).read_text(encoding="utf-8") for language, name in PAGES.items()}
        scripts = f"<script>{axe.read_text(encoding='utf-8')}</script><script>{PROBE}</script>"
        cls.probed = {language: text.replace("<head>", f"<head>{NOTHING_FROM_OUTSIDE}{scripts}", 1)
                      for language, text in cls.texts.items()}
        cls.day = {language: cls.tried(widths=WIDTHS, language=language) for language in PAGES}

    @classmethod
    def tried(cls, *words, widths=(1000,), language="en", text=None):
        """{width: what the probe found in a frame of this width}; a window is never narrower than 500 pixels."""
        (cls.out / "probed.html").write_text(text or cls.probed[language], encoding="utf-8")
        frames = "".join(f'<iframe src="probed.html" style="width:{width}px;height:900px;border:0"></iframe>'
                         for width in widths)
        (cls.out / "frames.html").write_text(FRAMES.replace("FRAMES", frames), encoding="utf-8")
        dom = browser.headless("--virtual-time-budget=60000", *words, "--dump-dom", (cls.out / "frames.html").as_uri())
        found = [json.loads(html.unescape(pre)) for pre in re.findall(r"<pre>(.*?)</pre>", dom, re.S)]
        assert len(found) == len(widths), dom[:2000]
        return {one["width"]: one for one in found}

    def nothing_is_at_fault(self, language):
        """By day and by night, wide and narrow."""
        night = self.tried(NIGHT, widths=WIDTHS, language=language)
        for frames, paper in ((self.day[language], "rgb(255, 255, 255)"), (night, "rgb(23, 25, 28)")):
            for width, found in frames.items():
                with self.subTest(width=width, paper=paper):
                    self.assertEqual(found["faults"], [])
                    self.assertEqual(found["paper"], paper)
                    self.assertLessEqual(max(found["reach"], found["reachAfter"]), width, "the page scrolls sideways")
                    self.assertLessEqual(*found["first"], "the first table scrolls sideways")
                    self.assertEqual(found["axe"], [])

    def test_nothing_is_at_fault_in_english(self):
        self.nothing_is_at_fault("en")

    def test_nothing_is_at_fault_in_chinese(self):
        self.nothing_is_at_fault("zh")

    def test_the_figures_answer_in_chinese(self):
        found = self.day["zh"][1000]
        self.assertEqual([slider["label"] for slider in found["sliders"]], ["迭代", "先验权重", "滑动", "窗口"])
        self.assertEqual(found["sliders"][0]["seen"][2]["spoken"], "第 2 次迭代")
        self.assertEqual(found["tapped"], "位姿 1 × 位姿 2：没有边同时连接两者，所以这个块为零。")
        self.assertIn("S：位姿 1 × 位姿 2：没有边；20 个已消去的路标点", found["S"][5][0])
        for words, _ in found["H"] + found["S"]:
            self.assertEqual(english_in(words), "")

    def test_sliders_step_through_the_tables(self):
        found = self.day["en"][1000]["sliders"]
        sliders = {slider["label"]: slider["seen"] for slider in found}
        self.assertEqual({slider["label"]: slider["pictures"] for slider in found},
                         {label: len(seen) if label == "Slide" else 1 for label, seen in sliders.items()}, "the film's images differ")
        self.assertEqual(list(sliders), ["Iteration", "Prior weight", "Slide", "Window"])
        trace, sweep = tables.read(OUT, "mono_ba_trace"), tables.read(OUT, "prior_sweep")
        self.assertEqual([at["words"] for at in sliders["Iteration"]],
                         [f"iteration {k}" for k in range(int(trace["iteration"].max()) + 1)])
        self.assertEqual(len(sliders["Prior weight"]), len(set(sweep["weight"])))
        self.assertGreater(len(sliders["Window"]), 50)
        for label, seen in sliders.items():
            self.assertEqual(len({at["words"] for at in seen}), len(seen), label)
            for at in seen:
                self.assertEqual(at["spoken"], at["words"])
                self.assertEqual(len(at["rows"]), 3 if label == "Prior weight" else 2, (label, at))
                self.assertGreaterEqual(at["curves"], 0 if label == "Slide" else 4, (label, at["words"]))
        row = sweep.row(variant="minimal", weight=sweep["weight"].max())
        self.assertIn(f"minimal{row['iterations']:.0f}", sliders["Prior weight"][-1]["rows"][2])
        cost = trace.where(scene="large")["cost"][-1]
        self.assertIn(style.number(cost, 6), sliders["Iteration"][-1]["rows"][1])

    def test_every_block_tells_what_made_it(self):
        found = self.day["en"][1000]
        edges, table = {}, tables.read(OUT, "hessian_edges").where(scene="course")
        for edge, vertex in zip(table["edge"], table["vertex"]):
            edges.setdefault(edge, set()).add(vertex)
        order = tables.read(OUT, "hessian_vertices").where(scene="course")["vertex"]
        pairs = [(i, j) for i in order for j in order]
        self.assertEqual(len(found["H"]), len(pairs))
        for (i, j), (words, lines) in zip(pairs, found["H"]):
            touching = sum({i, j} <= of for of in edges.values())
            self.assertEqual(lines, touching, words)
            self.assertIn(f"{touching} edge" if touching else "so the block is zero", words)
        self.assertEqual(len(found["S"]), 9)
        for words, _ in found["S"]:
            self.assertIn("20 eliminated landmarks", words)
        self.assertIn("pose 1 × pose 2: no edge touches both", found["tapped"])
        self.assertIn("no edge; 20 eliminated landmarks", found["S"][5][0])

    def test_without_script_all_is_there(self):
        plain = re.sub(r"<script>.*?</script>", "", self.texts["en"], flags=re.S)
        self.assertNotRegex(plain, r'(src|href)="(https?:|/)|url\(|@import')
        self.assertEqual(plain.count('<div class="control" hidden>'), 4)
        self.assertIn("H: pose 0 × pose 0: 40 edges, each adds J_iᵀ W J_j: numbers 0–39.", plain)

    def test_a_wide_table_of_another_page_can_be_scrolled_by_keys(self):
        page.write(self.out / "other.html", "Other", [Markup("<h1>Other</h1>"), page.table(["words"] * 30, [["words"] * 30])])
        axe = self.probed["en"].partition("<script>")[2].partition("</script>")[0]
        ask = ("addEventListener('load', () => axe.run().then(({violations}) => parent.postMessage(JSON.stringify("
               "{width: innerWidth, axe: violations.map(one => one.id), boxes: document.querySelectorAll('.scroll[tabindex]').length}), '*')))")
        text = (self.out / "other.html").read_text(encoding="utf-8").replace("<head>", f"<head><script>{axe}</script><script>{ask}</script>", 1)
        self.assertEqual(self.tried(widths=(390,), text=text)[390], {"width": 390, "axe": [], "boxes": 1})

    def test_what_is_wrong_is_found(self):
        wrong = self.probed["en"].replace("<h1>", '<img src="http://localhost/a.png"><script>nonsense()</script>'
                                    '<p style="width:2000px;color:#eee">wide</p><h1>')
        found = self.tried(text=wrong)[1000]
        self.assertGreater(found["reach"], 2000)
        self.assertTrue(any("would load" in fault for fault in found["faults"]), found["faults"])
        self.assertTrue(any("nonsense" in fault for fault in found["faults"]), found["faults"])
        self.assertLessEqual({"image-alt", "color-contrast"}, {one["id"] for one in found["axe"]})
