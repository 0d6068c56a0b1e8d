"""The model answer of stage 4: its numbers are those of the experiments, the same in both languages."""

import contextlib
import io
from unittest import mock

from tests.folder import FolderTest
from ch5_backend.figures import gauge_answer


class GaugeAnswer(FolderTest):
    def setUp(self):
        super().setUp()
        self.summary, self.answer = self.folder / "summary.csv", self.folder / "answer.md"
        self.summary.write_text("study,of,what,value\nsweep,sine planes,iterations at 0,5.04\nspectrum,camera,gap,2.4e-09\n",
                                encoding="utf-8")

    def run_on(self, text, *words):
        """Exit code, what the file holds then, and what was said."""
        self.answer.write_text(text, encoding="utf-8")
        said = io.StringIO()
        with mock.patch.object(gauge_answer, "ANSWERS", (self.answer,)), contextlib.redirect_stdout(said), \
                contextlib.redirect_stderr(said):
            code = gauge_answer.main([str(self.summary), *words])
        return code, self.answer.read_text(encoding="utf-8"), said.getvalue()

    def test_both_languages_cite_the_same_numbers(self):
        english, chinese = (sorted(gauge_answer.NUMBER.findall(path.read_text(encoding="utf-8")))
                            for path in gauge_answer.ANSWERS)
        self.assertGreater(len(english), 30)
        self.assertEqual(english, chinese)
        self.assertNotIn("?", {value for *_, value in english})

    def test_no_number_stands_there_without_its_source(self):
        for path in gauge_answer.ANSWERS:
            text = path.read_text(encoding="utf-8")
            self.assertEqual(text.count("<!-- -->"), len(gauge_answer.NUMBER.findall(text)), path)

    def test_numbers_are_put_in_and_found_to_be_old(self):
        text = "from <!-- sweep; sine planes; iterations at 0; .1f -->9.9<!-- --> to <!-- spectrum; camera; gap; power -->?<!-- -->"
        code, after, _ = self.run_on(text, "--check")
        self.assertEqual((code, after), (1, text))
        code, after, _ = self.run_on(text)
        self.assertEqual((code, after), (0, text.replace("9.9", "5.0").replace("?", "2·10⁻⁹")))
        self.assertEqual(self.run_on(after, "--check")[0], 0)

    def test_a_number_without_source_names_its_line(self):
        code, _, said = self.run_on("\n<!-- sweep; nowhere; iterations; .1f -->1<!-- -->")
        self.assertEqual(code, 2)
        self.assertIn("answer.md:2: the summary has no number 'sweep; nowhere; iterations'", said)
