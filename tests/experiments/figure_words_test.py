"""The words inside the report's figures are Chinese on its Chinese page, and none is forgotten."""

import os
import unittest
from pathlib import Path
from unittest import mock

from tests.conventions.project import ROOT
from ch5_backend.figures import report, style, translate

TABLES = Path(os.environ.get("CH5_TABLES", ROOT / "out")).resolve()


class FigureWords(unittest.TestCase):
    def test_a_sentence_may_hold_what_varies(self):
        for english, chinese in (("time [s]", "时间 [s]"), ("VINS: 99 % in 9.8 ms", "VINS：99 % 不超过 9.8 ms"),
                                 ("before\n42 × 42, 68 % filled", "之前\n42 × 42，68 % 非零"), ("x [m]", "x [m]"),
                                 ("OKVIS: the prior's spectrum", "OKVIS：先验的谱")):
            self.assertEqual(translate.translate(english), chinese)

    @unittest.skipUnless(translate.font(), "no Chinese font")
    def test_no_figure_of_the_report_keeps_an_english_word(self):
        left, drawn = {}, []

        def save(figure, _, name, chinese=False):
            figure.canvas.draw()
            style.freeze(figure)
            self.assertTrue(chinese, name)
            self.assertTrue(translate.to_chinese(figure))
            figure.canvas.draw()
            drawn.append(name)
            left.update({name: words} if (words := translate.english_left(figure)) else {})
            style.plt.close(figure)
        with mock.patch.object(style, "save", save):
            for script in report.SCRIPTS:
                script.draw(TABLES)
        self.assertGreater(len(drawn), 19)
        self.assertEqual(left, {})


if __name__ == "__main__":
    unittest.main()
