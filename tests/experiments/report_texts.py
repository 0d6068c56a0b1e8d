"""The reports of the chapter and of a recording in both languages, out of the tables, with white pictures."""

from unittest import mock

import numpy as np

from ch5_backend.figures import captions, evaluation, gauge_report, nees, odometry, page, recording, report, style, systems
from ch5_backend.figures.numbers import gauge
from ch5_backend.figures.numbers.chapter import Chapter
from ch5_backend.figures.tables import Tables
from ch5_backend.figures.words import Words
from tests.project import OUT



def figures_of(out, of="chapter"):
    if of == "gauge":
        return gauge_report.drawn_of(out)
    say = Words("en")
    names = [name for section in captions.sections(Chapter(Tables(out / "csv")), say).values() for name in section]
    return ["hero", *names, *odometry.captions(out, say), *evaluation.captions(out, say), *nees.captions(say), *systems.captions(out, say)]


def write_reports(out, of="chapter"):
    """report.html and report.zh.html in this folder, each figure white in all kinds that they link to."""
    (out / "figures").mkdir(exist_ok=True)
    report.keep_tables(out)
    if out != OUT:
        (out / "csv").symlink_to((OUT / "gauge" if of == "gauge" else OUT) / "csv")
    style.plt.imsave(out / "white.png", np.ones((800, 1600, 3)))
    for name in figures_of(out, of):
        for kind in ("png", "svg", "pdf"):
            path = out / "figures" / f"{name}.{kind}"
            path.unlink(missing_ok=True)
            path.hardlink_to(out / "white.png")
    white = page.small(out / "white.png", 0)
    with mock.patch.object(page, "small", return_value=white):
        page.write_all(out, *{"chapter": ("title", report.body_of), "recording": ("recording.title", recording.body_of),
                              "gauge": ("gauge.title", lambda *where: gauge_report.body_of(*where, gauge.numbers(out)))}[of])


if __name__ == "__main__":
    write_reports(OUT)
