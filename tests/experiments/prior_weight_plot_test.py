"""plot_prior_weight.py: draws the chapter's sweep and a reader's own, and names file, line and value at fault."""

import sys

from tests.folder import FolderTest
from tests.project import OUT, run

SCRIPT = "ch5_backend.figures.plot_prior_weight"
SWEEP = OUT / "csv" / "prior_sweep.csv"
HEAD = "weight,iterations,milliseconds,rmse_position\n"


class PriorWeightPlot(FolderTest):
    def draw(self, *words):
        done = run(sys.executable, "-m", SCRIPT, *words)
        return done.returncode, done.stdout, done.stderr

    def test_a_sweep_is_drawn_alike_whatever_the_order_of_columns_and_rows(self):
        rows = ["1,5,2.5,0.01,mine", "100,9,4.0,0.02,mine", "0,4,2.0,0.03,yours", "10,7,3.0,0.04,yours"]
        lines = [HEAD.strip() + ",variant", *rows[1::-1], *rows[:1:-1]]
        pictures = []
        for name, text in (("a.png", [HEAD.strip() + ",variant", *rows]), ("b.png", [",".join(line.split(",")[i] for i in (4, 2, 0, 3, 1)) for line in lines])):
            table, target = self.folder / f"{name}.csv", self.folder / name
            table.write_text("\n".join(text) + "\n", encoding="utf-8")
            self.assertEqual(self.draw(table, "-o", target), (0, f"{target}\n", ""))
            pictures.append(target.read_bytes())
        self.assertEqual(*pictures)
        for name, begin in (("a.svg", b"<?xml"), ("a.pdf", b"%PDF")):
            self.assertEqual(self.draw(SWEEP, "-o", self.folder / name)[0], 0)
            self.assertTrue((self.folder / name).read_bytes().startswith(begin))

    def test_what_is_wrong_is_named(self):
        table, none = self.folder / "own.csv", self.folder / "none"
        for text, said in (("", "no rows"), ("weight,iterations,milliseconds\n1,5,2.5\n", "line 1: no column 'rmse_position'"),
                           (HEAD + "1,5,2.5,0.01\n2,many,2.5,0.01\n", "line 3: iterations is 'many', expected a number"),
                           (HEAD + "1,5,2.5,0.01\n-3,5,2.5,0.01\n", "line 3: weight is -3, which cannot be"),
                           (HEAD + "1,5,2.5\n", "line 2: 3 cells under a header of 4"), (HEAD + "0,5,2.5,0.01\n", "no weight is above 0")):
            table.write_text(text, encoding="utf-8")
            code, out, error = self.draw(table)
            self.assertEqual((code, out, error.count("\n")), (2, "", 1), error)
            for word in ("plot_prior_weight.py: ", "own.csv", *said.split(": ")):
                self.assertIn(word, error)
        for words, said in (((), "CSV"), (("--frobnicate", "a.csv"), "--frobnicate"), ((SWEEP, "-o", "a.gif"), "a.gif: cannot draw '.gif', only .png, .svg, .pdf"),
                            ((none,), "none"), ((SWEEP, "-o", none / "a.png"), str(none))):
            code, out, error = self.draw(*words)
            self.assertEqual((code, out), (2, ""), words)
            self.assertIn(said, error)
