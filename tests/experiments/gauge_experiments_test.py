"""The page of the gauge experiments is drawn of their tables alone. What these must show: experiments/evidence.json."""

import html
import re
import shutil

from tests.experiments import programs_under_test
from tests.project import BUILD, DATA

from ch5_backend.figures import gauge_report, translate


class GaugeExperiments(programs_under_test.AppTest):
    app = "ch5_gauge"

    def test_page_and_figures_are_the_same_to_the_byte_and_leave_out_what_is_missing(self):
        studies = {table for table, _ in gauge_report.FIGURES.values()} | {"covariance", "audit", "variants"}
        if not (DATA / "tango_walk").exists():
            studies.discard("recordings")
        for study in sorted(studies):
            programs_under_test.make_trials(BUILD / "bin" / self.app, study, 1, self.out / "csv" / f"{study}.csv")
        drawn = self.drawn()
        figures = [name for name, (table, _) in gauge_report.FIGURES.items() if table in studies]
        self.assertEqual(len(drawn), (5 if translate.font() else 3) * len(figures) + 3, "with the pages and the summary")
        text = re.sub(r'src="[^"]*"', "", drawn[self.out / "report.html"].decode())
        self.assertNotRegex(text, r"\bnan\b|\binf\b")
        self.assertIn("has 4 zero eigenvalues", text)
        self.assertIn("A quick run: 1 of the paper's 50 trials", html.unescape(text))
        for table in (self.out / "csv").iterdir():
            if table.stem != "spectrum":
                table.unlink()
        again = {path: text for path, text in self.drawn().items() if path.parent.name == "figures"}
        self.assertEqual(again, {path: text for path, text in drawn.items() if path.name.startswith("gauge_spectrum.")})

    def drawn(self) -> dict:
        """{path: bytes} of all that is drawn of the tables."""
        shutil.rmtree(self.out / "figures", ignore_errors=True)
        gauge_report.draw(self.out)
        return {path: text for path, text in programs_under_test.contents(self.out).items() if path.parent.name != "csv"}
