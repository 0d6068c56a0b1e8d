"""The lab: the page says what the native program says, and can be used by mouse, keyboard, link and phone."""

import json
import os
import re
import statistics
import subprocess
import sys
import unittest
from pathlib import Path

from slides import browser, npm

ROOT = Path(__file__).resolve().parents[2]

PAGE = Path(os.environ.get("CH5_LAB_PAGE", ROOT / "out" / "lab.html"))
BUILD = Path(os.environ.get("CH5_BUILD", ROOT / "build" / "release"))
PROGRAM = BUILD / "bin" / "ch5_lab"
PANELS = ("solve", "steps", "marginalize", "window")
MOST_BYTES = 3_000_000
# Each panel as it opens, and each setting away from there.
QUERIES = (
    "panel=solve", "panel=solve&weight=0.001", "panel=solve&weight=1e10",
    "panel=solve&gauge=minimal&weight=1e4&start=0.1&information=noise",
    "panel=solve&gauge=fixed&frames=5&points=12", "panel=solve&frames=10&points=40", "panel=solve&noise=0.01&seed=7",
    "panel=solve&outliers=3&loss=cauchy&information=noise",
    "panel=solve&outliers=3&loss=tukey&information=noise&delta=6",
    "panel=solve&outliers=3&loss=huber", "panel=solve&damping=diagonal&start=0.3", "panel=solve&algorithm=gn",
    "panel=solve&algorithm=dogleg&start=0.2", "panel=solve&solver=blocks", "panel=solve&solver=sparse&frames=6",
    "panel=steps", "panel=steps&trial=2&stop=judge", "panel=steps&algorithm=gn&trial=1",
    "panel=steps&start=0.5&tau=1e-12&trial=1",
    "panel=steps&algorithm=dogleg&radius=0.1&trial=3", "panel=marginalize&system=chain&drop=1",
    "panel=marginalize&drop=0",
    "panel=marginalize&drop=3,3,3,0", "panel=solve&frames=1",
)
RELATIVE = 1e-9
# An estimator with few tracks triangulates from hardly any parallax, and what rounding changes there grows: the native
# program with AVX2 and without differ by centimeters. So flights are compared with a program that rounds as WebAssembly
# does.
FLIGHTS = ("panel=window", "panel=window&image=29", "panel=window&image=20&tracks=20")


def native(query, program=PROGRAM):
    done = subprocess.run([program, query], capture_output=True, text=True, env={**os.environ, "CH5_SIMD": "portable"})
    return json.loads(done.stdout)


def build_twin():
    """ch5_lab, native, with the arithmetic of WebAssembly."""
    folder = BUILD / "lab_twin"
    os.environ.pop("PYTHONSAFEPATH", None)  # as in ch5_backend/lab/build.py
    for command in (["cmake", "-G", "Ninja", "-S", Path(__file__).with_name("twin"), "-B", folder],
                    ["cmake", "--build", folder, "--target", "ch5_lab"]):
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return folder / "ch5_lab"


def is_numbers(values):
    return all(isinstance(one, (int, float)) and not isinstance(one, bool) for one in values)


def is_table(rows):
    return isinstance(rows, list) and rows != [] and all(
        isinstance(row, dict) and not any(isinstance(value, (dict, list)) for value in row.values()) for row in rows)


def columns(rows):
    """A table by its columns; a row without an entry has None there."""
    names = {name: None for row in rows for name in row}
    return {name: [row.get(name) for row in rows] for name in names}


LENGTHS = dict.fromkeys(("p", "rmse_position", "rmse_point", "rmse_position_aligned", "rmse_point_aligned"), 1.0)


def differences(a, b, path="", scales=LENGTHS):
    """[(path, difference)] of all numbers, relative to the largest number of their vector, matrix, or table's column: near
    an optimum gradients and steps are small differences of large numbers. `scales` knows a size from elsewhere: lengths
    are compared in meters, as the scene has some meters, and a part of the cost with the whole.
    Words and shapes must be the same.
    """
    if isinstance(a, dict):
        assert a.keys() == b.keys(), path
        if is_table(a.get("trials")):  # where the loop has begun
            scales = {**scales, "b": a["trials"][0]["gradient"],
                      "delta_x": max(row.get("step", 0.0) for row in a["trials"])}
        if "prior_cost" in a:
            scales = {**scales, "prior_cost": a["final_cost"]}
        return [found for key in a for found in differences(a[key], b[key], f"{path}.{key}", scales)]
    scale = scales.get(path.split(".")[-1], 0.0)
    if isinstance(a, list) and is_numbers(a + b):
        assert len(a) == len(b), path
        size = max([abs(one) for one in a] + [scale])
        return [(path, max((abs(x - y) / size for x, y in zip(a, b)), default=0.0) if size else 0.0)]
    if isinstance(a, list):
        assert len(a) == len(b), path
        if is_table(a) and is_table(b):
            return differences(columns(a), columns(b), path)
        return [found for i, pair in enumerate(zip(a, b)) for found in differences(*pair, f"{path}[{i}]", scales)]
    if isinstance(a, float) or isinstance(b, float):
        return [(path, abs(a - b) / max(abs(a), abs(b), scale) if a != b else 0.0)]
    assert a == b, f"{path}: {a} is not {b}"
    return []


class Lab(unittest.TestCase):
    def setUp(self):
        if not PAGE.exists():
            self.skipTest("there is no lab.html: emscripten is not installed")
        try:
            from tests.lab.page import Page
            self.page = Page()
        except (ImportError, browser.BuildError) as missing:
            self.skipTest(f"{missing}; Debian: apt-get install python3-selenium chromium-driver")
        self.addCleanup(self.page.__exit__)

    def open(self, state="", **search):
        words = "&".join(f"{key}={value}" for key, value in search.items())
        self.page.open(f"{PAGE.as_uri()}?{words}#{state}", "ready.then(() => true)")

    def state(self):
        return self.page.evaluate("location.hash.slice(1)")

    def tearDown(self):
        self.assertEqual(self.page.complaints(), [])

    def compare(self, queries, program):
        self.open()
        worst = []
        for query in queries:
            expected, got = native(query, program), json.loads(self.page.evaluate(f"ask({query!r})"))
            found = differences(expected, got)
            path, most = max(found, key=lambda one: one[1], default=("", 0.0))
            worst.append((query, most, path))
        print("\nlargest relative difference between WebAssembly and the native program")
        for query, most, path in worst:
            print(f"  {most:8.1e}  {query}  {path}")
        self.assertEqual([one for one in worst if one[1] > RELATIVE], [])

    def test_every_number_is_the_native_programs(self):
        self.compare(QUERIES, PROGRAM)

    @unittest.skipUnless("CH5_LONG" in os.environ, "CH5_LONG=1: the library is compiled once more, five minutes")
    def test_every_number_of_a_flight_is_the_native_programs(self):
        self.compare(FLIGHTS, build_twin())

    def test_the_page_begins_with_the_programs_defaults(self):
        for panel in PANELS:
            self.open(f"panel={panel}")
            asked = self.page.evaluate("query()")
            self.assertIn("&", asked)
            self.assertEqual(self.page.evaluate(f"ask({asked!r}) === ask('panel={panel}')"), True, asked)

    def test_the_page_is_small_and_needs_nothing_else(self):
        html = PAGE.read_text(encoding="utf-8")
        size = len(html.encode())
        print(f"\nlab.html: {size} bytes")
        self.assertLessEqual(size, MOST_BYTES)
        self.assertEqual(re.findall(r'<(?:link|img|script)[^>]*(?:src|href)=|@import|url\(', html), [])

    def test_every_panel_in_both_languages_fits_a_phone(self):
        for panel in PANELS:
            for language in ("en", "zh"):
                for width in (390, 1280):
                    self.page.show_as(width, 800, dark=width == 390)
                    self.open(f"panel={panel}", lang=language)
                    self.assertEqual(self.page.evaluate("document.getElementById('message').textContent"), "")
                    self.assertGreaterEqual(self.page.evaluate("document.querySelectorAll('figure').length"), 2)
                    self.assertLessEqual(self.page.evaluate("document.documentElement.scrollWidth"), width, (panel, language))

    def test_every_control_and_picture_has_a_name(self):
        for panel in PANELS:
            self.open(f"panel={panel}")
            nameless = self.page.evaluate(
                "[...document.querySelectorAll('input,select')].filter(one => !one.labels.length || "
                "!one.labels[0].textContent.trim()).length + [...document.querySelectorAll('canvas,svg')].filter(one => "
                "!one.getAttribute('aria-label')).length + [...document.querySelectorAll('button')].filter(one => "
                "!one.textContent.trim()).length")
            self.assertEqual(nameless, 0, panel)

    def test_axe_finds_nothing(self):
        try:
            axe = (npm.installed() / "axe-core" / "axe.min.js").read_text(encoding="utf-8")
        except browser.BuildError as error:
            if error.code != 2:  # 2: something is missing
                raise
            self.skipTest(str(error))
        for state in (*(f"panel={panel}" for panel in PANELS), "panel=steps&stop=judge", "panel=marginalize&system=chain"):
            for language in ("en", "zh"):
                for dark in (False, True):
                    self.page.show_as(1280, 800, dark)
                    self.open(state, lang=language)
                    self.page.evaluate(f"{axe}; true")
                    found = self.page.evaluate("axe.run().then(({violations}) => violations.map(one => "
                                               "[one.id, one.impact, one.nodes[0].html.slice(0, 200)]))")
                    self.assertEqual(found, [], (state, language, dark))

    def test_texts_are_complete_and_used(self):
        texts = json.loads((ROOT / "ch5_backend/lab/page/text.json").read_text(encoding="utf-8"))
        page = ROOT / "ch5_backend/lab/page"
        source = "".join((page / name).read_text(encoding="utf-8")
                         for name in ("lab.html", "state.js", "panels.js", "main.js"))
        controls = re.findall(r'(?:range|log|choice)\("(\w+)"', source)
        for key, words in texts.items():
            self.assertEqual(set(words), {"en", "zh"}, key)
            holes = [sorted(re.findall(r"{\w+}", words[one])) for one in ("en", "zh")]
            self.assertEqual(*holes, key)
            made = re.sub(r"[.].*", ".", key)  # "stop.damp" is `stop.${…}`, "pose.n" is `${kind}.n`
            self.assertTrue(any(word in source for word in (f'"{key}"', f'"{made}"', f"`{made}${{")) or key.endswith(".n")
                            or key.split(".")[0] in controls, f"{key} is not used")

    def test_a_link_brings_its_state_and_a_slider_changes_it(self):
        self.open("panel=solve&weight=100&frames=4")
        self.assertEqual(self.page.evaluate("document.getElementById('set-frames').value"), "4")
        self.assertEqual(self.page.evaluate("document.getElementById('set-weight').value"), "20")
        before = self.page.evaluate("document.getElementById('pictures').innerHTML")
        self.page.evaluate("document.getElementById('set-frames').focus()")
        self.page.press("ArrowRight")
        self.assertEqual(self.state(), "panel=solve&weight=100&frames=5")
        self.assertNotEqual(self.page.evaluate("document.getElementById('pictures').innerHTML"), before)

    def test_a_variable_is_marginalized_by_click_and_by_key(self):
        self.open("panel=marginalize")
        self.page.click("canvas.clicks", across=0.02, down=0.02)  # pose 0
        self.assertEqual(self.state(), "panel=marginalize&drop=0")
        self.page.evaluate("document.getElementById('drop-1').focus()")
        self.page.press("Enter")
        self.assertEqual(self.state(), "panel=marginalize&drop=0,1")
        self.assertEqual(self.page.evaluate("document.activeElement.id"), "drop-1")
        self.page.click("#undo")
        self.assertEqual(self.state(), "panel=marginalize&drop=0")

    def test_the_loop_is_walked_through_by_key(self):
        self.open("panel=steps")
        self.page.evaluate("document.getElementById('forward').focus()")
        stops = []
        for _ in range(8):
            stops.append(self.page.evaluate("[state.values.trial, state.values.stop].join(' ')"))
            self.page.press("Enter")
        self.assertEqual(stops, [f"0 {one}" for one in ("linearize", "build", "damp", "eliminate", "solve", "step", "judge")]
                         + ["1 linearize"])

    def test_of_new_flights_the_last_one_is_flown_and_announced(self):
        self.open("panel=window", lang="en")
        said, asked = self.page.evaluate(
            "(async () => { const own = ask, asked = [], slider = document.getElementById('set-rate');"
            "ask = words => { asked.push(words); return own(words); };"
            "for (let i = 0; i < 3; ++i) { slider.stepDown(); slider.dispatchEvent(new Event('input')); }"
            "const said = document.getElementById('status').textContent;"
            "while (document.querySelector('[aria-busy=true]')) await new Promise(done => setTimeout(done, 20));"
            "return [said, asked]; })()")
        self.assertEqual(said, "Computing the flight …")
        self.assertEqual(asked, ["panel=window&image=12&rate=12&tracks=12&pixels=1"])

    def test_tabs_and_languages_switch(self):
        self.open("panel=solve", lang="en")
        self.page.evaluate("document.getElementById('tab-solve').focus()")
        self.page.press("ArrowRight")
        self.page.evaluate("new Promise(done => setTimeout(done, 50))")
        self.assertEqual(self.state(), "panel=steps")
        self.page.click("[data-language=zh]")
        self.assertEqual(self.page.evaluate("document.documentElement.lang"), "zh-Hans")
        self.assertIn("线性化", self.page.evaluate("document.body.innerText"))

    def test_a_bad_link_is_named(self):
        for state, words in (("panel=solve&weight=x", "weight must be a number"), ("panel=no", "panel must be one of"),
                             ("panel=solve&wieght=1", "'wieght' is not a setting")):
            self.open(state)
            self.assertIn(words, self.page.evaluate("document.getElementById('message').textContent"))

    def test_the_decks_links_are_understood(self):
        links = {link for deck in (ROOT / "slides").glob("*.md")
                 for link in re.findall(r"lab\.html[^#)]*#([^)]*)\)", deck.read_text(encoding="utf-8"))}
        self.assertGreater(len(links), 5)
        for link in sorted(links):
            self.open(link)
            self.assertEqual(self.page.evaluate("document.getElementById('message').textContent"), "", link)
            self.assertEqual(self.state(), link)

    def test_times_of_a_slider_move(self):
        for panel, name in (("solve", "weight"), ("steps", "weight"), ("marginalize", "weight"), ("window", "image")):
            self.open(f"panel={panel}")
            times = self.page.evaluate(
                f"(() => {{ const slider = document.getElementById('set-{name}'), times = []; for (let i = 0; i < 15; ++i) {{"
                "const begin = performance.now(); slider.stepUp(); slider.dispatchEvent(new Event('input'));"
                "document.body.getBoundingClientRect(); times.push(performance.now() - begin); } return times; })()")
            print(f"\n{panel}: a move of '{name}' takes {min(times):.0f} ms at best, "
                  f"{statistics.median(times):.0f} ms (median), {max(times):.0f} ms at worst")
            self.assertEqual(len(times), 15)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--images"]:  # FOLDER: each panel, light and dark, wide and narrow, in both languages
        from tests.lab.page import Page
        with Page() as shown:
            for one in PANELS:
                for word, wide, is_dark in (("en", 1280, False), ("zh", 1280, True), ("zh", 390, False), ("en", 390, True)):
                    shown.show_as(wide, 900, dark=is_dark)
                    shown.open(f"{PAGE.as_uri()}?lang={word}#panel={one}", "ready.then(() => true)")
                    shown.image(Path(sys.argv[2]) / f"{one}-{word}-{wide}{'-dark' * is_dark}.png")
    else:
        unittest.main()
