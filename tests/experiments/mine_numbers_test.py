"""What is said of two flights, on tables written by hand."""

import json
import shutil

from ch5_backend.figures import mine as page
from ch5_backend.figures.numbers.mine import Finding, Mine
from ch5_backend.figures.words import Words
from tests.folder import FolderTest
from tests.homework.chinese import english_in

HEADER = "image,t_s,x_m,y_m,z_m\n"


def write_run(folder, H, S, matrices=True, failure=""):
    """What ./course run --mine leaves of a student's H and S, of one entry, beside the solution's, which are 1; S of 0 is not there."""
    for side, (h, s) in (("own", (H, S)), ("solution", (1, 1))):
        for name, table, text in (("hessian", "matrices", f"matrix,row,column,value\nH,0,0,{h}\n" + (f"S,0,0,{s}\n" if s else "")),
                                  ("hessian", "convergence", "iteration,cost,lambda\n0,1,\n"),
                                  ("weights", "weights", f"variant,weight,iterations,cost,drift_m\ncourse,1,3,{h + s},1\n")):
            place = folder / "mine" / name / side
            place.mkdir(parents=True, exist_ok=True)
            if side == "solution" or matrices or table != "matrices":
                (place / f"{table}.csv").write_text(text)
    files = {stage["file"]: {"errors": None, "unfinished": {}, "own": stage["todos"]} for stage in page.STAGES[::-1]}
    files["problem.cc"]["own"] = ["1.1a", "1.2a"]
    (folder / "mine" / "runs.json").write_text(json.dumps({"files": files, "experiments": {"hessian": failure, "weights": ""}}))


class MineNumbers(FolderTest):
    def test_the_image_named_is_one_that_both_have_answered(self):
        place = self.folder / "mine"
        for side, rows in (("own", "0,0.0,0,0,0\n1,0.1,1,0,0\n3,0.3,3,0,1\n"),
                           ("solution", "1,0.1,1,0,0\n2,0.2,2,0,0\n3,0.3,3,0,0\n")):
            (place / "vins" / side).mkdir(parents=True)
            (place / "vins" / side / "path.csv").write_text(HEADER + rows)
            (place / "vins" / side / "summary.csv").write_text("ate_m,yaw_rad,x_m,y_m,z_m,restarts\n0,0,0,0,0,0\n")
        (place / "runs.json").write_text(json.dumps({"files": {}, "experiments": {"vins": ""}}))
        found = Mine(self.folder).finding("vins")
        (place / "vins" / "solution" / "truth.csv").write_text("t_s,x_m,y_m,z_m\n0,0,0,0\n1,10,0,2\n")
        with_truth = Mine(self.folder).finding("vins")
        self.assertEqual((found.key, with_truth.key), ("flight", "flight_with_truth"))
        self.assertNotIn("–", page.told(found, Words("en")))
        self.assertAlmostEqual(with_truth.values["error"], 0.4)
        self.assertAlmostEqual(with_truth.values["solution"], 0.6)
        weight = Finding("weight", {"variant": "perturbed", "weight": 100.0, "column": "iterations", "own": 7.0, "solution": 5.0})
        deviation = Finding("deviation", {"gauge": "free to fixed", "keyframe": 3.0, "column": "position_m", "own": 7.0, "solution": 5.0})
        for finding in (weight, deviation):
            self.assertEqual(english_in(page.told(finding, Words("zh"))), "")
        self.assertEqual((found.values["image"], found.values["t"], found.values["apart"]), (3, 0.3, 1.0))

    def test_a_consequence_is_not_judged(self):
        """A wrong S is stage 1.2's: 1.1 is right, and the weights, which need the solver, say nothing of stage 3."""
        def wrong(H, S, matrices=True, failure=""):
            shutil.rmtree(self.folder / "mine", ignore_errors=True)
            write_run(self.folder, H, S, matrices, failure)
            mine = Mine(self.folder)
            return [mark for name in mine.failures for _, mark, _ in page.verdicts(mine, name, Words("en"))]

        self.assertEqual(wrong(1, 1), ["✓", "✓", "✓"])
        self.assertEqual(wrong(1, 2), ["✓", "✗", "–"])
        self.assertEqual(wrong(2, 2), ["✗", "–", "–"])
        self.assertEqual(wrong(1, 0, failure="Assertion failed"), ["✓", "✗", "–"], "S is not there")
        self.assertEqual(wrong(1, 1, matrices=False, failure="signal 11"), ["✗", "–", "–"])
