"""./course ladder: what it refuses, the rungs and the class's board; no time is tested."""

import os

from ch5_backend.course.base.errors import CourseError
from ch5_backend.course.base.language import speaker
from ch5_backend.course.experiments import ladder
from ch5_backend.course.homework.make_skeleton import skeleton
from ch5_backend.figures.numbers.windows import KEPT
from tests.folder import FolderTest
from tests.project import ROOT, run


def row(name, times):
    return {"name": name, "times": times, "processor": "P", "date": "2026-11-29"}


class Ladder(FolderTest):
    def test_a_stage_that_is_not_right_is_not_timed(self):
        (self.folder / "block_solver.cc").write_text(skeleton("block_solver.cc"), encoding="utf-8")
        for words, code, said in (((), 1, "./course check 7"), (("--board", "b.csv"), 2, "--name")):
            done = run(ROOT / "course", "ladder", *words, "--language", "en", env={**os.environ, "CH5_CHECK_FOLDER": str(self.folder)})
            self.assertEqual((done.returncode, done.stdout), (code, ""))
            self.assertIn(said, done.stderr)

    def test_each_rung_makes_it_faster_and_one_is_reached_near_its_gain(self):
        gains = KEPT("ladder")["times"].tolist()
        self.assertEqual(sorted({1.0, *gains}), [1.0, *gains], "each faster than the one before")
        for gain, reached in ((1.0, 0), (gains[0], 1), (0.97 * gains[1], 2), (0.9 * gains[1], 1), (9.0, len(gains))):
            self.assertEqual(sum(one["reached"] for one in ladder.rungs(gain)), reached, gain)

    def test_the_page_has_a_row_a_solver_and_leaves_out_what_was_not_measured(self):
        turn = {"linearize": 2.0, "solve": 4.0, "iteration": 6.0}
        times = {"ladder.solution": [turn], "ladder.yours": [{**turn, "iteration": 3.0}], "Ceres": [{"iteration": 12.0}]}
        for language, yours in (("en", "stage 7, yours"), ("zh", "阶段 7，你的")):
            text = ladder.page(times, 2.0, ladder.rungs(2.0), speaker(language))
            rows = {line.split("  ")[0]: line.split() for line in text.splitlines()}
            self.assertEqual(rows[yours][-4:], ["2.00", "4.00", "3.00", "2.00"])
            self.assertEqual(rows["Ceres"], ["Ceres", "12.00", "0.50"])
            self.assertEqual(text.count("✓"), sum(one["reached"] for one in ladder.rungs(2.0)))

    def test_the_board_takes_one_row_a_name_and_no_other_table(self):
        path = self.folder / "board.csv"
        for own in (row("007", "1.50"), row("小明", "2.25"), row("007", "1.75"), row("a,b", "9.00")):
            shown = ladder.board(path, own)
        self.assertEqual(path.read_text(encoding="utf-8").splitlines()[1:],
                         ['"a,b",9.00,P,2026-11-29', "小明,2.25,P,2026-11-29", "007,1.75,P,2026-11-29"])
        self.assertEqual(len(shown.splitlines()), 4)
        for wrong in ("a,b\n1,2\n", "name,times,processor,date\nx,fast,P,D\n", "name,times,processor,date\nx\n"):
            path.write_text(wrong, encoding="utf-8")
            with self.assertRaises(CourseError):
                ladder.board(path, row("x", "1.00"))
            self.assertEqual(path.read_text(encoding="utf-8"), wrong, "nothing is lost")
