"""What is said of two flights, on tables written by hand."""

import json
import tempfile
import unittest
from pathlib import Path

from ch5_backend.figures.numbers.mine import Mine

HEADER = "image,t_s,x_m,y_m,z_m\n"


class MineNumbers(unittest.TestCase):
    def test_the_image_named_is_one_that_both_have_answered(self):
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder) / "mine"
            for side, rows in (("own", "0,0.0,0,0,0\n1,0.1,1,0,0\n3,0.3,3,0,1\n"),
                               ("solution", "1,0.1,1,0,0\n2,0.2,2,0,0\n3,0.3,3,0,0\n")):
                (place / "vins" / side).mkdir(parents=True)
                (place / "vins" / side / "path.csv").write_text(HEADER + rows)
                (place / "vins" / side / "summary.csv").write_text("ate_m,yaw_rad,x_m,y_m,z_m,restarts\n0,0,0,0,0,0\n")
            (place / "runs.json").write_text(json.dumps({"files": {}, "experiments": {"vins": ""}}))
            found = Mine(folder).finding("vins")
        self.assertEqual(found.key, "flight")
        self.assertEqual((found.values["image"], found.values["t"], found.values["apart"]), (3, 0.3, 1.0))
