"""plot_prior_weight.py: draws the chapter's sweep and a reader's own, and names file, line and value at fault."""

import contextlib
import io
import subprocess
import sys

from tests.folder import FolderTest
from tests.project import OUT
from ch5_backend.figures import plot_prior_weight

SCRIPT = "ch5_backend.figures.plot_prior_weight"
SWEEP = OUT / "csv" / "prior_sweep.csv"
HEAD = "weight,iterations,milliseconds,rmse_position\n"


class PriorWeightPlot(FolderTest):
    def setUp(self):
        super().setUp()
        self.table = self.folder / "own.csv"

    def draw(self, *words):
        """Exit code, standard output and standard error."""
        code = 0
        with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as error:
            try:
                plot_prior_weight.main(list(map(str, words)))
            except SystemExit as stopped:
                code = stopped.code
        return code, out.getvalue(), error.getvalue()

    def picture(self, table, name):
        target = self.folder / name
        self.assertEqual(self.draw(table, "-o", target), (0, f"{target}\n", ""))
        return target.read_bytes()

    def refuses(self, text, *naming):
        self.table.write_text(text, encoding="utf-8")
        code, out, error = self.draw(self.table)
        self.assertEqual((code, out, error.count("\n")), (2, "", 1), error)
        for word in ("plot_prior_weight.py: ", "own.csv", *naming):
            self.assertIn(word, error)
        self.assertEqual([path.name for path in self.folder.iterdir()], ["own.csv"])

    def test_the_chapters_sweep_drawn_by_another_process_is_the_same(self):
        for name, begin in (("a.png", b"\x89PNG"), ("a.svg", b"<?xml"), ("a.pdf", b"%PDF")):
            target = self.folder / f"other-{name}"
            subprocess.run([sys.executable, "-m", SCRIPT, SWEEP, "-o", target], check=True, capture_output=True, timeout=120)
            self.assertEqual(self.picture(SWEEP, name), target.read_bytes(), name)
            self.assertTrue(target.read_bytes().startswith(begin))

    def test_columns_are_found_by_name_and_rows_in_any_order(self):
        rows = ["1,5,2.5,0.01,mine", "100,9,4.0,0.02,mine", "0,4,2.0,0.03,yours", "10,7,3.0,0.04,yours"]
        self.table.write_text(HEAD.strip() + ",variant\n" + "\n".join(rows) + "\n", encoding="utf-8")
        one = self.picture(self.table, "a.png")
        lines = (HEAD.strip() + ",variant", *rows[1::-1], *rows[:1:-1])
        columns = [[line.split(",")[i] for i in (4, 2, 0, 3, 1)] for line in lines]
        self.table.write_text("\n".join(map(",".join, columns)) + "\n", encoding="utf-8")
        self.assertEqual(self.picture(self.table, "b.png"), one)

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
        for words, said in (((), "CSV"), (("a.csv", "b.csv"), "b.csv"), (("--frobnicate", "a.csv"), "--frobnicate"),
                            ((SWEEP, "-o", "a.gif"), "a.gif: cannot draw '.gif', only .png, .svg, .pdf"),
                            ((self.folder / "none.csv",), "none.csv"),
                            ((SWEEP, "-o", self.folder / "no" / "a.png"), f"{self.folder}/no")):
            code, out, error = self.draw(*words)
            self.assertEqual((code, out), (2, ""), words)
            self.assertIn(said, error)
