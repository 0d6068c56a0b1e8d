"""The lab's tasks are played: predicted, tried and solved, by mouse, by finger and by keys."""

import itertools
import re

from tests.lab.lab_test import LabCase
from tests.project import ROOT

SOLVED = "document.getElementById('verdict').className === 'good'"
IDS = re.findall(r'^    id: "(\w+)"', (ROOT / "ch5_backend/lab/page/challenges.js").read_text(encoding="utf-8"), re.MULTILINE)


class Tasks(LabCase):
    hand = "mouse"

    def push(self, selector, across=0.5, down=0.5):
        if self.hand == "mouse":
            self.page.click(selector, across, down)
        elif self.hand == "finger":
            self.page.touch(selector, across=across, top=down)
        else:
            self.page.evaluate(f"document.querySelector({selector!r}).closest('[tabindex], button').focus()")
            self.page.press("Enter")
        self.rest()

    def observe(self, row, column, of):
        """Pushes a square of "Who sees what"; `of` is how many rows and columns it has."""
        if self.hand != "keys":
            return self.push("#observations", (column + 0.5) / of[1], (row + 0.5) / of[0])
        self.page.evaluate("document.getElementById('observations').focus()")
        for key, times in (("ArrowUp", of[0]), ("ArrowLeft", of[1]), ("ArrowDown", row), ("ArrowRight", column), ("Enter", 1)):
            for _ in range(times):
                self.page.press(key)
        self.rest()

    def put(self, setting, value):
        """A slider or a choice at a value. What a choice unfolds is the browser's own, so only keys walk through it."""
        name = f"document.getElementById('set-{setting}')"
        kind, low, high, now, words = self.page.evaluate(f"(one => [one.type, one.min, one.max, one.value, [...one.options ?? []].map(word => word.value)])({name})")
        if self.hand == "keys":
            far = words.index(value) - words.index(now) if words else round((value - float(now)) / float(self.page.evaluate(f"{name}.step || 1")))
            self.page.evaluate(f"{name}.focus()")
            for _ in range(abs(far)):
                self.page.press(("ArrowUp", "ArrowDown")[far > 0] if words else ("ArrowLeft", "ArrowRight")[far > 0])
        elif kind == "range" and self.hand == "finger":
            share = lambda at: 0.02 + 0.96 * (float(at) - float(low)) / (float(high) - float(low))  # noqa: E731  the thumb has a width
            wide = self.page.evaluate(f"{name}.getBoundingClientRect().width")
            self.page.touch(f"#set-{setting}", (share(value) - share(now)) * wide, 0, across=share(now))
        else:
            self.slide(setting, repr(value))
        self.rest()

    def is_solved(self):
        self.rest()
        self.page.evaluate("new Promise(done => setTimeout(done, 30))")
        self.rest()
        return self.page.evaluate(SOLVED)

    def begin(self, task):
        """Opens a task, predicts, and returns (what was predicted, what C++ said)."""
        self.open(lang="en")
        self.push(f"#task-{task}")
        kept = self.page.evaluate(f"CHALLENGES.find(one => one.id === '{task}').keep")
        shown = self.page.evaluate("[...document.querySelectorAll('#pictures > [data-key]')].map(one => one.dataset.key)")
        self.assertLessEqual(set(shown), set(kept), "more is shown than may be before the prediction")
        self.assertTrue(self.page.evaluate("document.getElementById('controls').inert"))
        self.push("#option-0")
        self.wait("document.getElementById('predicted').textContent")
        self.assertFalse(self.is_solved(), "a task is solved before anything was done")
        self.assertFalse(self.page.evaluate("document.getElementById('controls').inert"))
        return self.text("predicted")

    def test_there_are_eleven(self):
        self.assertEqual(len(set(IDS)), 11)
        self.assertEqual({name[5:] for name in dir(self) if name.startswith("play_")}, set(IDS))

    # What solves each task: the right prediction by C++'s numbers, as worked out below, and the moves.

    def play_weight(self):
        for place in range(-30, 101, 10):
            self.put("weight", place)
            if self.is_solved():
                return

    def play_gauge(self):
        self.put("gauge", "free")

    def play_rotation(self):
        self.put("motion", "turn")

    def play_baseline(self):
        if self.hand != "keys":
            meter = self.page.evaluate("document.querySelector('.scene').getScreenCTM().a * PIXELS")
            return (self.page.touch if self.hand == "finger" else self.page.drag)("#handle-pose-1", 2 * meter, 5 * meter)
        self.page.evaluate("document.getElementById('handle-pose-1').focus()")
        for key, times in (("ArrowRight", 8), ("ArrowDown", 20)):
            for _ in range(times):
                self.page.press(key)
                self.rest()

    def play_fewest(self):
        for landmark in (0, 2, 4):
            self.observe(1, landmark, of=(2, 6))

    def play_liar(self):
        self.observe(1, 0, of=(2, 20))

    def play_reject(self):
        self.put("tau", -120)

    def play_fill(self):
        for variable in (0, 1, 2):
            self.push(f"#drop-{variable}")
            if self.is_solved():
                return
            self.push("#undo")

    def play_order(self):
        for _ in range(2):
            self.push("#drop-0")

    def play_yaw(self):
        for rate in range(5, 21):  # who claims more is chance
            self.put("rate", rate)
            if self.is_solved():
                return

    def play_beat(self):
        while best := self.page.evaluate("document.querySelector('#pictures .game [aria-disabled=false]') && [...document.querySelectorAll("
                                         "'#pictures .game [aria-disabled=false]')].sort((a, b) => a.ariaLabel.match(/(\\d+)[.]$/)[1] - "
                                         "b.ariaLabel.match(/(\\d+)[.]$/)[1])[0].id"):
            self.push(f"#{best} > :first-child")

    def test_each_is_predicted_and_solved(self):
        # The options that the numbers bear out. `weight`: the peak of the gauge's paper; `gauge`: 7; `rotation`: a depth for each
        # of 20 landmarks; `fewest`: 6 unknowns by 2 equations each; `order`: an end has one neighbor.
        right = {"gauge": "7", "rotation": "20", "fewest": "3", "order": "an end", "baseline": "nearer to the first camera",
                 "beat": "no"}
        for self.hand, task in itertools.product(("mouse", "finger", "keys"), IDS):
            with self.subTest(task, hand=self.hand):
                self.page.show_as(*((390, 844) if self.hand == "finger" else (1280, 900)))
                self.open(lang="en")
                self.page.evaluate("localStorage.clear()")
                said = self.begin(task)
                print(f"\n{task}, {self.hand}: first option: {said}")
                if task in right:
                    first = self.text("option-0")
                    self.assertEqual(said, "Well predicted." if first == right[task] else f"C++ says: {right[task]}.")
                getattr(self, f"play_{task}")()
                self.assertTrue(self.is_solved(), self.state())
                self.assertIn("✓", self.text(f"task-{task}"))
                print(f"  solved at {self.state()}")

    def test_goal_control_number_and_picture_are_on_one_screen(self):
        for width, height in ((1280, 720), (390, 844)):
            for task in IDS:
                for language in ("en", "zh"):
                    with self.subTest(task=task, width=width, language=language):
                        self.page.show_as(width, height)
                        self.open(f"task={task}", lang=language)
                        self.page.evaluate("kept.guesses = {}; predict(taskNow(), 0); scrollTo(0, 0)")
                        self.wait("document.getElementById('verdict').textContent && !present && !jobs.length")
                        below = self.page.evaluate(
                            "[...document.querySelectorAll('#task-do, #task-control label, #verdict, #task-way, #pictures > [data-key]:nth-child("
                            "-n+2) :is(svg, canvas, table, button)')].filter(one => one.getBoundingClientRect().bottom > innerHeight)"
                            ".map(one => (one.id || one.localName) + ' ' + one.getBoundingClientRect().bottom)")
                        self.assertEqual(below, [])
                        self.assertEqual(self.page.evaluate("[document.querySelectorAll('details[open]').length, "
                                                            "document.documentElement.scrollWidth]"), [0, width])
                        control = self.page.evaluate("taskNow().control ?? ''")
                        self.assertEqual(self.page.evaluate("document.querySelector('#task-control :is(input, select)')?.id ?? ''"),
                                         control and f"set-{control}")

    def test_what_was_solved_is_kept_and_can_be_begun_again(self):
        self.begin("gauge")
        self.play_gauge()
        self.assertTrue(self.is_solved())
        self.open("panel=solve&task=gauge", lang="zh")
        self.assertIn("✓", self.text("task-gauge"))
        self.page.click("#task-again")
        self.rest()
        self.assertNotIn("✓", self.text("task-gauge"))
        self.assertTrue(self.page.evaluate("document.getElementById('controls').inert"))

    def test_keys_alone_solve_a_task(self):
        self.open(lang="en")
        self.page.press("Tab")
        self.page.press("Enter")
        self.assertEqual(self.page.evaluate("document.activeElement.id"), "matrix-H", "two keys reach the matrices")
        self.page.press("t")
        self.rest()
        self.assertEqual(self.page.evaluate("document.activeElement.id"), "task")
        self.page.press("Tab")
        self.page.press("Enter")
        self.wait("document.getElementById('predicted').textContent")
        self.assertEqual(self.page.evaluate("state.task"), IDS[0])
        for _ in range(40):
            if self.page.evaluate("document.activeElement.id") == "set-weight":
                return
            self.page.press("Tab")
        self.fail("the control is not reached")
