"""The lab: the page says what the native program says, and can be used by mouse, keyboard, link and phone."""

import itertools
import json
import os
import random
import re
import subprocess
import unittest
from pathlib import Path

import numpy as np

from ch5_backend.course.documents import lab
from slides import browser
from tests.project import BUILD, ROOT, run

PAGE = Path(os.environ.get("CH5_LAB_PAGE", ROOT / "out" / "lab.html"))
PROGRAM = BUILD / "bin" / "ch5_lab"
PANELS = ("solve", "steps", "marginalize", "window", "eliminate")
MOST_BYTES = 3_000_000
# Each panel as it opens, and each setting away from there.
QUERIES = Path(__file__).with_name("queries.txt").read_text(encoding="utf-8").split()
RELATIVE = 1e-9
# An estimator with few tracks triangulates from hardly any parallax, and what rounding changes there grows: the native
# program with AVX2 and without differ by centimeters. So flights are compared with a program that rounds as WebAssembly
# does.
FLIGHTS = ("panel=window", "panel=window&image=29", "panel=window&image=20&tracks=20")


def native(query, program=PROGRAM):
    done = run(program, query, env={**os.environ, "CH5_SIMD": "portable"})
    return json.loads(done.stdout)


def build_with_wasm_arithmetic():
    """ch5_lab, native, with the arithmetic of WebAssembly."""
    folder = BUILD / "lab_wasm_arithmetic"
    os.environ.pop("PYTHONSAFEPATH", None)  # as in ch5_backend/course/documents/lab.py
    for command in (["cmake", "-G", "Ninja", "-S", Path(__file__).with_name("wasm_arithmetic"), "-B", folder],
                    ["cmake", "--build", folder, "--target", "ch5_lab"]):
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return folder / "ch5_lab"


def is_table(rows):
    return isinstance(rows, list) and rows != [] and all(
        isinstance(row, dict) and not any(isinstance(value, (dict, list)) for value in row.values()) for row in rows)


def columns(rows):
    """A table by its columns; a row without an entry has None there."""
    names = {name: None for row in rows for name in row}
    return {name: [row.get(name) for row in rows] for name in names}


LENGTHS = dict.fromkeys(("p", "error", "rmse_position", "rmse_point", "rmse_position_aligned", "rmse_point_aligned", "chi2"), 1.0)


def differences(a, b, path="", scales=LENGTHS):
    """[(path, difference)] of all numbers, relative to the largest number of their vector, matrix, or table's column: near
    an optimum gradients and steps are small differences of large numbers. `scales` knows a size from elsewhere: lengths
    are compared in meters, as the scene has some meters, χ² with one, and a part of the cost with the whole.
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
    if isinstance(a, list) and None in a:  # a matrix with holes
        assert [one is None for one in a] == [one is None for one in b], path
        a, b = ([one for one in values if one is not None] for values in (a, b))
    if isinstance(a, list) and all(type(one) in (int, float) for one in a + b):
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


@unittest.skipUnless(PROGRAM.exists(), "ch5_lab is not built")
class Numbers(unittest.TestCase):
    """Those of the native program, by other ways."""

    def test_ellipses_are_of_the_inverse_and_only_where_it_is_a_covariance(self):
        for query in ("gauge=fixed&frames=6", "weight=1e5&noise=0.01", "gauge=minimal&weight=1e8&frames=4&seed=2"):
            answer = native(f"panel=solve&information=noise&{query}")
            n = answer["H"]["rows"]
            inverse = np.linalg.inv(np.reshape(answer["H"]["values"], (n, n)))
            rows = {one["number"]: one["row"] for one in answer["variables"] if one["kind"] == "pose" and one["row"] >= 0}
            self.assertEqual([one["number"] for one in answer["claims"]], list(rows))
            for one in answer["claims"]:
                at = slice(rows[one["number"]], rows[one["number"]] + 2)
                claimed = np.array(one["covariance"]).reshape(2, 2)
                np.testing.assert_allclose(claimed, inverse[at, at], rtol=1e-5, atol=1e-5 * np.trace(claimed))
                error = np.subtract(answer["estimate"]["frames"][one["number"]]["p"], answer["truth"]["frames"][one["number"]]["p"])[:2]
                self.assertAlmostEqual(one["chi2"], error @ np.linalg.solve(claimed, error), delta=1e-6 * (1 + one["chi2"]))
            self.assertAlmostEqual(answer["claim_limit"], -2 * np.log(0.05), places=9)
        for query in ("gauge=fixed", "information=noise&gauge=free"):
            self.assertNotIn("claims", native(f"panel=solve&{query}"))

    def test_a_window_is_laid_upon_the_truth_at_its_oldest_frame(self):
        outside = 0
        for query in ("image=12", "image=29", "image=29&rate=5&pixels=3"):
            answer = native(f"panel=window&{query}")
            for policy in ("vins", "okvis"):
                frames = [one["id"] for one in answer[policy]["frames"]]
                np.testing.assert_allclose(answer[policy]["held"], answer["truth"][frames[0]], atol=1e-12)
                self.assertEqual([one["number"] for one in answer[policy]["claims"]], frames[1:])
                for one in answer[policy]["claims"]:
                    error, claimed = np.array(one["error"]), np.array(one["covariance"]).reshape(2, 2)
                    np.testing.assert_allclose(np.add(one["p"][:2], error), answer["truth"][one["number"]][:2], atol=1e-12)
                    self.assertAlmostEqual(one["chi2"], error @ np.linalg.solve(claimed, error), delta=1e-6 * (1 + one["chi2"]))
                    outside += one["chi2"] > answer[policy]["claim_limit"]
        self.assertGreater(outside, 0, "no page shows a truth outside")
        self.assertEqual(native("panel=window&image=0")["vins"]["claims"], [], "the only frame is held")

    def test_the_factor_and_the_score_are_those_of_the_order(self):
        draw = random.Random(1)
        for board, deals in (("chain", 1), ("loop", 1), ("grid", 1), ("bundle", 4), ("random", 4)):
            for deal in range(deals):
                query = f"panel=eliminate&board={board}&seed={deal}"
                start = native(query)
                H, n = start["H"]["values"], len(start["nodes"])
                orders = [draw.sample(range(n), n) for _ in range(5)]
                for order in (start["amd_order"], *orders):
                    end = native(f"{query}&order={','.join(map(str, order))}")
                    L = [end["L"]["values"][n * i:n * i + n] for i in range(n)]
                    for i in range(n):
                        for j in range(n):  # L Lᵀ = H in that order
                            self.assertAlmostEqual(sum(a * b for a, b in zip(L[i], L[j])), H[order[i] * n + order[j]], delta=1e-9)
                        self.assertEqual([value for value in L[i][i + 1:] if value], [])
                    entries = sum(value != 0 for value in end["L"]["values"])
                    self.assertEqual(end["fill"], entries - (sum(value != 0 for value in H) + n) // 2)
                    self.assertEqual(sum(end["L_fill"]["values"]), end["fill"])
                    self.assertEqual(sum(one["clique"] != [] for one in end["gone"]), n - 1)  # one root: all are tied
                    self.assertGreaterEqual(end["fill"], end["least"])
                    if order == start["amd_order"]:
                        self.assertEqual(end["fill"], end["amd"])

    def test_the_least_is_what_can_be_counted_by_hand(self):
        fills = [native(f"panel=eliminate&board=chain&order={','.join(order)}")["fill"] for order in itertools.permutations("012")]
        self.assertEqual(fills, [0, 0, 1, 1, 0, 0])
        self.assertEqual(native("panel=eliminate&board=chain&order=0")["L"]["values"], [10, 0, 0, -10, 0, 0, 0, 0, 0])
        self.assertEqual(native("panel=eliminate&board=loop")["least"], 8 - 3)
        for deal in range(4):  # points first tie cameras only
            bundle = f"panel=eliminate&board=bundle&seed={deal}"
            cameras = {number for one in native(f"{bundle}&order={','.join(map(str, range(4, 13)))}")["ties"] for number in (one["i"], one["j"])}
            self.assertEqual(cameras, {0, 1, 2, 3})


class LabCase(unittest.TestCase):
    """The page in a browser of its own."""

    def setUp(self):
        if not PAGE.exists():
            self.skipTest("there is no lab.html: emscripten is not installed")
        try:
            from tests.lab.chromium_page import Page
            self.page = Page()
        except (ImportError, browser.BuildError) as missing:
            self.skipTest(f"{missing}; Debian: apt-get install python3-selenium chromium-driver")
        self.addCleanup(self.page.driver.quit)

    def open(self, state="", **search):
        words = "&".join(f"{key}={value}" for key, value in search.items())
        self.page.open(f"{PAGE.as_uri()}?{words}#{state}", "ready.then(() => true)")

    def state(self):
        return self.page.evaluate("location.hash.slice(1)")

    def tearDown(self):
        self.assertEqual(self.page.complaints(), [])

    def text(self, name):
        return self.page.evaluate(f"document.getElementById('{name}').textContent")

    def wait(self, condition):
        """Until an expression of the page holds; at most ten seconds."""
        self.assertTrue(self.page.evaluate(
            f"(async () => {{ for (let i = 0; i < 500; ++i) {{ if ({condition}) return true; await new Promise(done => setTimeout(done, 20)); }}"
            f" return false; }})()"), condition)

    def rest(self):
        """Until C++ has nothing to do: then the picture is of the present settings."""
        self.wait("!present && !jobs.length")

    def slide(self, setting, value):
        self.page.evaluate(f"(() => {{ const one = document.getElementById('set-{setting}'); one.value = {value};"
                           "one.dispatchEvent(new Event(one.tagName === 'SELECT' ? 'change' : 'input')); })()")
        self.rest()


class Lab(LabCase):
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
        self.compare(FLIGHTS, build_with_wasm_arithmetic())

    def test_the_page_begins_with_the_programs_defaults(self):
        for panel in PANELS:
            self.open(f"panel={panel}")
            asked = self.page.evaluate("query()")
            self.assertIn("&", asked)
            self.assertEqual(self.page.evaluate(
                f"Promise.all([ask({asked!r}), ask('panel={panel}')]).then(([a, b]) => a === b)"), True, asked)

    def test_the_page_is_small_and_needs_nothing_else(self):
        html = PAGE.read_text(encoding="utf-8")
        size = len(html.encode())
        print(f"\nlab.html: {size} bytes")
        self.assertLessEqual(size, MOST_BYTES)
        self.assertEqual(re.findall(r'<(?:link|img|script)[^>]*(?:src|href)=|@import|url\(', html), [])

    def test_texts_are_complete_and_used(self):
        texts = json.loads((ROOT / "ch5_backend/lab/page/text.json").read_text(encoding="utf-8"))
        page = ROOT / "ch5_backend/lab/page"
        source = "".join(path.read_text(encoding="utf-8") for path in (page / "lab.html", *lab.SCRIPTS))
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

    def test_variables_are_eliminated_by_mouse_finger_and_key(self):
        self.page.show_as(390, 844)
        self.open("panel=eliminate&board=loop", lang="en")
        self.page.click("#variable-0")
        self.page.evaluate("document.getElementById('variable-3').scrollIntoView({block: 'center'})")
        self.page.touch("#variable-3", 0, 0)
        self.page.evaluate("document.getElementById('variable-6').focus()")
        self.page.press("Enter")
        self.rest()
        self.assertEqual(self.state(), "panel=eliminate&board=loop&order=0,3,6")
        self.assertEqual(self.page.evaluate("document.activeElement.id"), "variable-6")
        self.assertEqual("x6 is gone; it depends on x5, x7.", self.page.evaluate("document.activeElement.ariaLabel"))
        self.page.press("Enter")
        self.page.click("#undo")
        self.page.click("#pictures [data-key='H.after'] canvas", 0.01, 0.01)  # x1
        self.rest()
        self.assertEqual(self.state(), "panel=eliminate&board=loop&order=0,3,1")
        self.page.click("#restart")
        self.page.click("#by-amd")
        self.rest()
        self.assertIn("As good as AMD.", self.text("score"))
        self.slide("board", "'grid'")
        self.assertEqual(self.state(), "panel=eliminate&board=grid")

    def test_the_loop_is_walked_through_by_key(self):
        self.open("panel=steps")
        self.page.evaluate("document.getElementById('forward').focus()")
        stops = []
        for _ in range(8):
            stops.append(self.page.evaluate("[state.values.trial, state.values.stop].join(' ')"))
            self.page.press("Enter")
        self.assertEqual(stops, [f"0 {one}" for one in ("linearize", "build", "damp", "eliminate", "solve", "step", "judge")]
                         + ["1 linearize"])

    def test_a_new_flight_is_shown_while_it_grows_and_superseded_ones_are_left(self):
        self.open("panel=window", lang="en")
        said, asked = self.page.evaluate(
            "(async () => { const own = ask, asked = [], said = [], slider = document.getElementById('set-rate');"
            "ask = (words, how) => { asked.push(words); return own(words, how); };"
            "for (let i = 0; i < 3; ++i) { slider.stepDown(); slider.dispatchEvent(new Event('input')); }"
            "for (const end = performance.now() + 5000; performance.now() < end && !asked.at(-1).endsWith('until=29');) {"
            "said.push(document.getElementById('status').textContent); await new Promise(done => setTimeout(done, 5)); }"
            "return [said, asked]; })()")
        self.assertIn("Computing the flight …", said)
        rates = [re.search(r"rate=(\d+).*until=(\d+)", words).groups() for words in asked]
        self.assertEqual([one for one in rates if one[0] != "12"], [("14", "0"), ("13", "0")])
        self.assertEqual([int(until) for rate, until in rates if rate == "12"], [*range(0, 30, 2), 29])

    def test_a_camera_and_a_landmark_are_dragged_by_mouse_and_by_key(self):
        self.open("panel=solve", lang="en")
        before = self.text("status"), self.page.evaluate("document.querySelector('#pictures [data-key=cost]').innerHTML")
        self.page.drag("#handle-pose-2", 40, -20)
        self.rest()
        number, right, up = self.page.evaluate("state.values.cameras").split(":")
        scale = self.page.evaluate("document.querySelector('.scene').getScreenCTM().a * PIXELS")
        self.assertEqual(number, "2")
        self.assertAlmostEqual(float(right), 40 / scale, delta=0.02)
        self.assertAlmostEqual(float(up), 20 / scale, delta=0.02)
        self.assertNotEqual(self.page.evaluate("document.querySelector('#pictures [data-key=cost]').innerHTML"), before[1])
        self.page.evaluate("document.getElementById('handle-landmark-3').focus()")
        self.page.press("ArrowUp")
        self.rest()
        self.assertEqual(self.page.evaluate("state.values.landmarks"), "3:0:0.25")
        self.assertEqual(self.page.evaluate("document.activeElement.id"), "handle-landmark-3")
        self.page.click("#drag-start")
        self.rest()
        self.page.evaluate("document.getElementById('handle-pose-1').focus()")
        self.page.press("ArrowLeft")
        self.rest()
        self.assertEqual(self.page.evaluate("state.values.camera_starts"), "1:-0.25:0")
        self.page.click("#drag-back")
        self.rest()
        self.assertEqual(self.state(), "panel=solve")

    def test_a_landmark_is_dragged_by_finger_and_the_page_stays(self):
        self.page.show_as(390, 844)
        self.open("panel=solve", lang="en")
        self.page.evaluate("document.getElementById('handle-landmark-3').scrollIntoView({block: 'center'})")
        scale, scrolled = self.page.evaluate("[document.querySelector('.scene').getScreenCTM().a * PIXELS, scrollY]")
        self.page.touch("#handle-landmark-3", -48, 60)
        self.rest()
        number, right, up = map(float, self.page.evaluate("state.values.landmarks").split(":"))
        self.assertEqual(number, 3)
        self.assertAlmostEqual(right, -48 / scale, delta=0.02)
        self.assertAlmostEqual(up, -60 / scale, delta=0.02)
        self.assertEqual(self.page.evaluate("scrollY"), scrolled)

    def test_keys_keep_their_place_when_the_picture_is_drawn_anew(self):
        self.open("panel=solve", lang="en")
        self.page.evaluate("document.getElementById('observations').focus()")
        for key in ("ArrowDown", "Enter", "ArrowRight", "Enter"):
            self.page.press(key)
            self.rest()
        self.assertEqual(self.page.evaluate("state.values.without"), "0:2,1:2")
        self.page.press("Enter")
        self.rest()
        self.assertEqual(self.page.evaluate("state.values.without"), "0:2")

    def test_what_was_left_or_reset_comes_back(self):
        self.open("panel=solve&weight=100&frames=4", lang="en")
        self.page.click("#tab-marginalize")
        self.wait("state.panel === 'marginalize'")
        self.page.click("#tab-solve")
        self.wait("state.panel === 'solve'")
        self.assertEqual(self.page.evaluate("[state.values.weight, state.values.frames]"), ["100", "4"])
        self.page.click("#reset")
        self.rest()
        self.assertEqual(self.state(), "panel=solve")
        self.page.evaluate("history.back()")
        self.wait("state.values.weight === '100'")

    def test_a_task_tells_its_number_and_the_goal(self):
        self.open("task=baseline", lang="en")
        self.page.evaluate("document.getElementById('option-0').click()")
        self.wait("document.getElementById('verdict')?.textContent.includes('to reach')")
        now, goal = map(float, re.search(r"points \[m\]: now (\S+), to reach (\S+)\.$", self.text("verdict")).groups())
        self.assertAlmostEqual(goal / now, 4.0, delta=0.01)
        self.assertIn(f"RMSE of the points {now:.4g}", self.page.evaluate("document.querySelector('[data-key=scene] figcaption').textContent"))

    def test_a_truth_outside_its_ellipse_can_be_seen(self):
        for state in ("panel=window&image=29", "panel=solve&information=noise&outliers=2"):
            self.open(state, lang="en")
            self.rest()
            said = self.page.evaluate("[...document.querySelectorAll('[data-key=claims]')].map(one => [one.textContent.match(/outside of (\\d+) of (\\d+)/)"
                                      ".slice(1).map(Number), one.querySelectorAll('.out').length, one.querySelectorAll('ellipse').length])")
            self.assertGreater(len(said), 0)
            for (out, every), rings, ellipses in said:
                self.assertEqual((out, every), (rings, ellipses), state)

    def test_pictures_of_lengths_have_a_scale_and_axes_their_powers(self):
        bar = "(svg => [svg.querySelector('.scale').getBBox().width, svg.querySelector('.scale + text').textContent])"
        self.open("panel=solve", lang="en")
        width, words = self.page.evaluate(f"{bar}(document.querySelector('.scene'))")
        self.assertEqual(words, "2 m")
        self.assertAlmostEqual(width, 2 * self.page.evaluate("PIXELS"), places=3)
        self.assertIn("10⁻⁵", self.page.evaluate("document.querySelector('[data-key=cost] svg').textContent"))
        for image, length in ((0, "0.02 m"), (29, "0.2 m")):
            self.open(f"panel=window&image={image}", lang="en")
            self.assertEqual(self.page.evaluate(f"{bar}(document.querySelector('[data-key=flight] svg'))")[1], length)

    def test_an_observation_is_left_out_and_taken_back_by_click(self):
        self.open("panel=solve&points=10", lang="en")
        cell = {"across": 4.5 / 10, "down": 0.75}  # landmark 4, frame 2
        self.page.click("#observations", **cell)
        self.rest()
        self.assertEqual(self.state(), "panel=solve&points=10&without=4:2")
        self.assertEqual(self.page.evaluate("document.querySelectorAll('.ray[data-landmark=\"4\"]').length"), 2)
        self.page.click("#observations", **cell)
        self.rest()
        self.assertEqual(self.state(), "panel=solve&points=10")

    def test_a_block_of_the_matrix_lights_up_what_it_ties(self):
        lit = ("[...document.querySelectorAll('#pictures [data-item].lit')].map(one => one.dataset.item).sort().filter((one, i, all) => "
               "all.indexOf(one) === i).join()")
        self.open("panel=solve", lang="en")  # 3 poses of 6 rows, 20 landmarks
        self.page.point("#pictures [data-key=H] canvas", (18 + 4.5) / 38, 8 / 38)  # landmark 4 × pose 1
        self.assertEqual(self.page.evaluate(lit), "landmark 4,pose 1")
        self.assertEqual(self.page.evaluate("[...document.querySelectorAll('.ray.lit')].map(one => one.dataset.landmark + ' ' + one.dataset.pose).join()"), "4 1")
        self.assertIn("pose 1 × landmark 4", self.page.evaluate("document.querySelector('[data-key=H] figcaption').textContent"))
        self.page.point("h1")
        self.assertEqual(self.page.evaluate(lit), "")
        self.page.evaluate("document.querySelector('[data-key=H] canvas').focus({focusVisible: true})")
        self.page.press("ArrowDown")
        self.assertEqual(self.page.evaluate(lit), "pose 0,pose 1")

    def test_the_formulas_hold_the_numbers_of_the_step(self):
        self.open("panel=steps&stop=eliminate", lang="en")
        answer = native("panel=steps&stop=eliminate")
        numbers = self.page.evaluate("[...document.querySelectorAll('.formulas math:last-of-type')].at(-1).textContent")
        self.assertIn(self.page.evaluate(f"number({answer['S']['values'][0]!r})"), numbers)
        for stop in ("linearize", "build", "damp", "eliminate", "solve", "step", "judge"):
            self.open(f"panel=steps&stop={stop}", lang="en")
            self.assertGreaterEqual(self.page.evaluate("document.querySelectorAll('.formulas math').length"), 1, stop)
            words = self.page.evaluate("document.getElementById('formula').parentNode.textContent")
            self.assertNotRegex(words, "NaN|undefined|null|[_^`]", stop)

    def test_two_settings_stand_side_by_side(self):
        self.open("panel=solve&weight=100", lang="en")
        self.page.click("#compare")
        self.rest()
        self.slide("weight", 0)
        self.assertEqual(self.state(), "panel=solve&beside=weight%3D100")
        cost = "[...document.querySelectorAll('#{} [data-key=cost] .formulas')].map(one => one.textContent).join()"
        left, right = (self.page.evaluate(cost.format(one)) for one in ("beside", "pictures"))
        self.assertNotEqual(left, right)
        ticks = "[...document.querySelectorAll('#{} [data-key=\"{}\"] svg text')].map(one => one.textContent + one.getAttribute('x') + one.getAttribute('y'))"
        for key in ("cost", "spectrum"):
            self.assertEqual(*(self.page.evaluate(ticks.format(one, key)) for one in ("beside", "pictures")), key)
        self.open("panel=solve&weight=100", lang="en")
        self.assertEqual(self.page.evaluate(cost.format("pictures")), left)
        self.open("panel=solve&beside=weight%3D100", lang="en")
        self.assertEqual(self.page.evaluate(cost.format("beside")), left)
        self.assertEqual(self.page.evaluate("[...document.querySelectorAll('[id]')].map(one => one.id).filter((one, i, all) => all.indexOf(one) !== i)"), [])
        self.page.press("c")
        self.rest()
        self.assertEqual(self.state(), "panel=solve")

    def test_reset_help_and_panels_have_keys_that_can_be_turned_off(self):
        self.open("panel=solve&weight=100&cameras=2:1:1", lang="en")
        self.page.evaluate("document.getElementById('show-help').click()")
        self.page.click("#keys")
        self.page.click("#close-help")
        self.page.press("r")
        self.assertEqual(self.page.evaluate("state.values.weight"), "100")
        self.page.evaluate("document.getElementById('keys').click()")
        self.page.press("r")
        self.rest()
        self.assertEqual(self.state(), "panel=solve")
        self.page.press("?")
        self.assertTrue(self.page.evaluate("document.getElementById('help').open"))
        self.page.press("Escape")
        self.assertFalse(self.page.evaluate("document.getElementById('help').open"))
        self.page.press("3")
        self.wait("state.panel === 'marginalize'")

    def test_every_button_is_reached_by_tab(self):
        for panel in PANELS:
            self.open(f"panel={panel}&task=gauge" if panel == "solve" else f"panel={panel}", lang="en")
            unreached = self.page.evaluate(
                "[...document.querySelectorAll('button, select, input, canvas, .handle')].filter(one => !one.disabled && "
                "!one.closest('[inert], dialog:not([open]), [hidden]') && one.tabIndex < 0 && one.getAttribute('role') !== 'tab')"
                ".map(one => one.outerHTML.slice(0, 100))")
            self.assertEqual(unreached, [], panel)

    def test_tabs_and_languages_switch(self):
        self.open("panel=solve", lang="en")
        self.page.evaluate("document.getElementById('tab-solve').focus()")
        self.page.press("ArrowRight")
        self.page.evaluate("new Promise(done => setTimeout(done, 50))")
        self.assertEqual(self.state(), "panel=steps")
        self.page.click("[data-language=zh]")
        self.assertEqual(self.page.evaluate("document.documentElement.lang"), "zh-Hans")
        self.assertIn("线性化", self.page.evaluate("document.body.innerText"))

    def test_a_bad_link_is_named_and_the_default_used(self):
        for state, words, left in (
                ("panel=solve&weight=x", "weight = 'x' cannot be used: it must be a number, 0 – 10¹².", "panel=solve"),
                ("panel=solve&frames=9999&points=7", "frames = '9999' cannot be used: it must be a whole number, 2 – 10.", "panel=solve&points=7"),
                ("panel=no", "panel = 'no' cannot be used", "panel=no"), ("panel=solve&task=no", "task = 'no'", "panel=solve&task=no"),
                ("panel=solve&wieght=1", "'wieght' is not a setting", "panel=solve"),
                ("panel=solve&a=1&b=2&gauge=z", "gauge = 'z' cannot be used: it must be one of prior, minimal, fixed, free.", "panel=solve"),
                ("panel=steps&beside=frames%3D77", "frames = '77'", "panel=steps&beside="),
                ("panel=solve&without=0", "without = '0'", "panel=solve"), ("panel=solve&weight=1%26frames%3D3", "weight", "panel=solve")):
            self.open(state, lang="en")
            self.assertIn(words, self.page.evaluate("document.getElementById('message').textContent"), state)
            self.assertEqual(self.state(), left)
            self.assertGreaterEqual(self.page.evaluate("document.querySelectorAll('figure').length"), 2, state)
        self.open("panel=solve&weight=x", lang="zh")
        self.assertIn("参数 weight = 'x' 无效", self.page.evaluate("document.getElementById('message').textContent"))

    def test_the_decks_links_are_understood(self):
        links = {link for deck in (ROOT / "slides").glob("*.md")
                 for link in re.findall(r"lab\.html[^#)]*#([^)]*)\)", deck.read_text(encoding="utf-8"))}
        self.assertGreater(len(links), 5)
        for link in sorted(links):
            self.open(link)
            self.assertEqual(self.page.evaluate("document.getElementById('message').textContent"), "", link)
            self.assertEqual(self.state(), link)
