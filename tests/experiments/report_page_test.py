"""The chapter's report as its readers use it, in Chromium, by hand and by keys. How it looks, and axe: tests/look."""

import re
import tempfile
import unittest
from pathlib import Path

from slides import browser
from ch5_backend.figures import style, tables
from tests.experiments.report_texts import write_reports
from tests.project import OUT
from tests.homework.chinese import english_in
from ch5_backend.figures.words import PAGES

PROBE = Path(__file__).with_name("report_probe.js").read_text(encoding="utf-8")


class Report(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        try:
            from tests.lab.chromium_page import Page
            page = Page(width=1000)
        except (ImportError, browser.BuildError) as missing:
            raise unittest.SkipTest(str(missing)) from missing
        cls.addClassCleanup(page.driver.quit)
        folder = tempfile.TemporaryDirectory(prefix="ch5-report-")
        cls.addClassCleanup(folder.cleanup)
        write_reports(Path(folder.name))
        cls.texts, cls.found = {}, {}
        for language, name in PAGES.items():
            cls.texts[language] = (Path(folder.name) / name).read_text(encoding="utf-8")
            page.open((Path(folder.name) / name).as_uri())
            cls.found[language] = page.evaluate(PROBE)
        cls.complaints = page.complaints()

    def test_nothing_is_complained_of(self):
        self.assertEqual(self.complaints, [])

    def test_the_figures_answer_in_chinese(self):
        found = self.found["zh"]
        self.assertEqual([slider["label"] for slider in found["sliders"]], ["迭代", "先验权重", "滑动"])
        self.assertEqual(found["sliders"][0]["seen"][2]["spoken"], "第 2 次迭代")
        self.assertEqual(found["tapped"], "位姿 1 × 位姿 2：没有边同时连接两者，所以这个块为零。")
        self.assertIn("S：位姿 1 × 位姿 2：没有边；20 个已消去的路标点", found["S"][5][0])
        for words, _ in found["H"] + found["S"]:
            self.assertEqual(english_in(words), "")

    def test_sliders_step_through_the_tables(self):
        found = self.found["en"]["sliders"]
        sliders = {slider["label"]: slider["seen"] for slider in found}
        self.assertEqual({slider["label"]: slider["pictures"] for slider in found},
                         {label: len(seen) if label == "Slide" else 1 for label, seen in sliders.items()}, "the film's images differ")
        self.assertEqual(list(sliders), ["Iteration", "Prior weight", "Slide"])
        trace, sweep = tables.read(OUT, "mono_ba_trace"), tables.read(OUT, "prior_sweep")
        self.assertEqual([at["words"] for at in sliders["Iteration"]],
                         [f"iteration {k}" for k in range(int(trace["iteration"].max()) + 1)])
        self.assertEqual(len(sliders["Prior weight"]), len(set(sweep["weight"])))
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
        found = self.found["en"]
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
        self.assertEqual(plain.count('<div class="control" hidden>'), 3)
        self.assertIn("H: pose 0 × pose 0: 40 edges, each adds J_iᵀ W J_j: numbers 0–39.", plain)
