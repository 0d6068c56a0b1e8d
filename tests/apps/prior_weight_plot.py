"""plot_prior_weight.py: draws the chapter's sweep and a reader's own, and names file, line and value at fault."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from apps import ROOT

SCRIPT = ROOT / "ch5_backend" / "apps" / "plot" / "plot_prior_weight.py"
SWEEP = Path(os.environ["CH5_TABLES"]) / "csv" / "prior_sweep.csv"
HEAD = "weight,iterations,milliseconds,rmse_position\n"


class PriorWeightPlot(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.table = self.folder / "own.csv"

    def draw(self, *words):
        return subprocess.run([sys.executable, SCRIPT, *map(str, words)], stdin=subprocess.DEVNULL, capture_output=True,
                              text=True, timeout=120, cwd=self.folder)

    def picture(self, table, name):
        """The bytes of a picture, drawn twice alike."""
        drawn = []
        for _ in range(2):
            done = self.draw(table, "-o", self.folder / name)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            drawn.append((self.folder / name).read_bytes())
        self.assertEqual(*drawn)
        return drawn[0]

    def refuses(self, text, *naming):
        self.table.write_text(text, encoding="utf-8")
        done = self.draw(self.table)
        self.assertEqual((done.returncode, done.stdout), (2, ""), done)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        for word in ("plot_prior_weight.py: ", "own.csv", *naming):
            self.assertIn(word, done.stderr)
        self.assertEqual([path.name for path in self.folder.iterdir()], ["own.csv"])

    def test_the_chapters_sweep_as_png_svg_and_pdf_is_the_same_every_time(self):
        self.assertTrue(self.picture(SWEEP, "a.png").startswith(b"\x89PNG"))
        self.assertIn(b"<svg", self.picture(SWEEP, "a.svg"))
        self.assertTrue(self.picture(SWEEP, "a.pdf").startswith(b"%PDF"))

    def test_columns_are_found_by_name_and_rows_in_any_order(self):
        rows = ["1,5,2.5,0.01,mine", "100,9,4.0,0.02,mine", "0,4,2.0,0.03,yours", "10,7,3.0,0.04,yours"]
        self.table.write_text(HEAD.strip() + ",variant\n" + "\n".join(rows) + "\n", encoding="utf-8")
        one = self.picture(self.table, "a.png")
        columns = [[line.split(",")[i] for i in (4, 2, 0, 3, 1)] for line in (HEAD.strip() + ",variant", *rows[1::-1], *rows[:1:-1])]
        self.table.write_text("\n".join(map(",".join, columns)) + "\n", encoding="utf-8")
        self.assertEqual(self.picture(self.table, "b.png"), one)

    def test_a_table_without_variants_lands_beside_it(self):
        self.table.write_text(HEAD + "0,4,2,0.03\n1e3,5,2.5,0.01\n", encoding="utf-8")
        done = self.draw(self.table)
        self.assertEqual((done.returncode, done.stdout), (0, f"{self.folder / 'prior_weight.png'}\n"), done.stderr)
        self.assertTrue((self.folder / "prior_weight.png").exists())

    def test_bad_tables_are_named_with_line_and_value(self):
        self.refuses("", "no rows")
        self.refuses(HEAD, "no rows")
        self.refuses("weight,iterations,milliseconds\n1,5,2.5\n", "line 1", "no column 'rmse_position'")
        self.refuses(HEAD + "1,5,2.5,0.01\n2,many,2.5,0.01\n", "line 3: iterations is 'many', expected a number")
        self.refuses(HEAD + "1,5,2.5,nan\n", "line 2: rmse_position is 'nan'")
        self.refuses(HEAD + "1,5,,0.01\n", "line 2: milliseconds is ''")
        self.refuses(HEAD + "1,5,2.5,0.01\n-3,5,2.5,0.01\n", "line 3: weight is -3, which cannot be")
        self.refuses(HEAD + "1,5,0,0.01\n", "line 2: milliseconds is 0, which cannot be")
        self.refuses(HEAD + "1,5,2.5\n", "line 2: 3 cells under a header of 4")
        self.refuses(HEAD + "0,5,2.5,0.01\n", "no weight is above 0")

    def test_wrong_words_are_refused(self):
        for words in ((), ("-o", "a.png"), ("a.csv", "b.csv"), ("a.csv", "-o"), ("--frobnicate",)):
            done = self.draw(*words)
            self.assertEqual((done.returncode, done.stdout), (2, ""), words)
            self.assertIn("expected CSV [-o FILE]", done.stderr)
        done = self.draw(SWEEP, "-o", "a.gif")
        self.assertEqual(done.returncode, 2)
        self.assertIn("a.gif: cannot draw '.gif', only .png, .svg, .pdf", done.stderr)
        done = self.draw(self.folder / "none.csv")
        self.assertEqual(done.returncode, 2)
        self.assertIn("none.csv", done.stderr)


if __name__ == "__main__":
    unittest.main()
