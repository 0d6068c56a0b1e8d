#!/usr/bin/python3
"""Draws the gauge paper's experiments and writes one page, DIR/report.html, in Chinese DIR/report.zh.html, and its numbers,
DIR/summary.csv.

usage: gauge_report.py [DIR]        DIR/csv is read; what has no table there is left out
"""
from pathlib import Path

from markupsafe import Markup

from . import gauge, gauge_captions, gauge_choice, gauge_covariance, page, style
from .numbers import gauge as gauge_numbers, gauge_paper
from .odometry import NAMES
from .style import number
from .tables import TableError, read

FIGURES = {  # name: its table, what draws it
    "gauge_prior_choice": ("prior_choice", gauge_choice.prior_choice),
    "gauge_methods": ("methods", gauge.methods),
    "gauge_errors": ("methods", gauge.errors),
    "gauge_sweep": ("sweep", gauge.sweep),
    "gauge_readings": ("near_start", gauge.readings),
    "gauge_convergence": ("convergence", gauge.convergence),
    "gauge_spectrum": ("spectrum", gauge_covariance.spectrum),
    "gauge_matrices": ("matrices", gauge_covariance.matrices),
    "gauge_deviations": ("deviations", gauge_covariance.deviations),
    "gauge_recordings": ("recordings", gauge_choice.recordings),
}
DIRECTIONS = ("x", "y", "z", "yaw", "roll", "pitch", "scale")


def errors_head(say):
    return [say(f"gauge.{column}") for column in gauge.ERRORS]


def row_name(say, *keys):
    return say("list").join(say(f"gauge.{key}") for key in keys)


def errors_table(n, say):
    """Table II, ours and the paper's."""
    rows = []
    for scene in gauge_paper.SCENES:
        for method in ("fixation", "free", "prior"):
            paper = gauge_paper.RMSE[scene].get(method, gauge_paper.RMSE[scene]["fixation"])
            ours = [n[f"{scene[0]} {scene[1]} {method}", f"mean {column}"] for column in gauge.ERRORS]
            rows.append((row_name(say, *scene, method), *(f"{value:.5f}" for value in ours), *(number(value, 4) for value in paper)))
    return page.table((say("gauge.mean_rmse"), *errors_head(say), *(say("gauge.the_papers", what=name) for name in errors_head(say))), rows)


def recordings_table(n, say):
    """Table III's analogue."""
    rows = []
    for recording, name in gauge_choice.RECORDINGS.items():
        for method in ("fixation", "free", "prior"):
            of = f"{recording} {method}"
            rows.append((say("list").join((name, say(f"gauge.{method}"))), *(f"{n[of, 'median ' + column]:.5f}" for column in gauge.ERRORS),
                         f"{n[of, 'median iterations']:.1f}", f"{n[of, 'median milliseconds']:.0f}"))
    rows += [(say("gauge.the_papers", what=row_name(say, "machine_hall", method)), *(f"{value:.5f}" for value in values), "–", "–")
             for method, values in gauge_paper.EUROC.items()]
    return page.table((say("gauge.median_rmse"), *errors_head(say), say("iterations"), say("time")), rows)


def covariance_table(n, say):
    distance = lambda of, what: number(n[of, f"{what} relative Frobenius distance"], 2)
    rows = [(say(f"gauge.{of}"), *(distance(of, what) for what in ("least", "mean", "largest")))
            for of in ("free untransformed", "free to fixed", "fixed untransformed", "fixed to free")]
    rows.append((say("gauge.the_papers", what=say("gauge.free to fixed")), "–", number(gauge_paper.COVARIANCE_DISTANCE, 2), "–"))
    return page.table(("‖Σ − Σ′‖ / ‖Σ′‖", *(say(f"gauge.{what}") for what in ("least", "mean", "largest"))), rows)


def variants_table(n, say):
    """Table II with other scenes."""
    rows = []
    for variant in gauge_numbers.VARIANTS:
        for scene in gauge_paper.SCENES:
            mean = lambda column: n[f"{variant}, {' '.join(scene)}", f"mean {column}"]  # noqa: B023
            rows.append((row_name(say, variant, *scene), f"{mean('seen_per_keyframe'):.0f}",
                         *(f"{mean(column):.4f}" for column in gauge.ERRORS),
                         *(f"{mean(f'{method}_iterations'):.2f}" for method in gauge_numbers.METHODS[:3])))
    head = say("gauge.iterations"), say("gauge.free"), say("gauge.prior")
    return page.table((say("gauge.mean"), say("gauge.seen"), *errors_head(say), *head), rows)


def audit_table(n, say):
    """What each part of a window's H claims to know."""
    rows = [(say("list").join((NAMES[policy], row_name(say, f"constraints.{constraints}", f"part.{part}"))),
             *(number(n[f"{policy} {constraints} {part}", f"largest relative {d}"], 2) for d in DIRECTIONS))
            for policy in NAMES for constraints in ("none", "marginalized edges") for part in ("measurements", "prior", "window")]
    return page.table(("‖P⁻¹Hn‖ / ‖Pn‖", *(say(f"gauge.{d}") for d in DIRECTIONS)), rows)


TABLES = {"gauge_errors": ("methods", errors_table), "gauge_matrices": ("covariance", covariance_table),
          "gauge_recordings": ("recordings", recordings_table)}


def body_of(directory, say, found):
    """The page's pieces."""
    body = page.opening(say("gauge.title"), say("gauge.lead"), say)
    trials = found["methods"]["all scenes", "trials"] if "methods" in found else gauge_paper.TRIALS
    if trials < gauge_paper.TRIALS:
        body.append(Markup("<p><strong>{}</strong></p>").format(say("gauge.quick", trials=f"{trials:.0f}", all=gauge_paper.TRIALS)))
    for name in drawn_of(directory):
        body.append(page.figure(directory, name, gauge_captions.caption(name, found, say), say(f"{name}.alt"), say))
        table, make = TABLES.get(name, (None, None))
        if table in found:
            body.append(make(found[table], say))
    for name, make in (("variants", variants_table), ("audit", audit_table)):
        if name in found:
            body += [page.paragraph(gauge_captions.caption(f"gauge_{name}", found, say), say), make(found[name], say)]
    summary = Markup('<a href="summary.csv">summary.csv</a>')
    return [*body, Markup(f"<p>{say('gauge.summary', link='{}')}</p>").format(summary), page.links_to_tables(directory, say)]


def drawn_of(directory):
    """The figures that have their table."""
    return [name for name, (table, _) in FIGURES.items() if (Path(directory) / "csv" / f"{table}.csv").exists()]


def draw_figures(directory):
    for name in drawn_of(directory):
        table, draw_one = FIGURES[name]
        draw_one(directory, read(directory, table))


def draw(directory):
    """The figures, the pages and the summary."""
    if not drawn_of(directory):
        raise TableError(f"{directory}/csv: none of the tables of the gauge experiments is there")
    draw_figures(directory)
    found = gauge_numbers.numbers(directory)
    gauge_numbers.write_summary(Path(directory) / "summary.csv", found)
    page.write_all(directory, "gauge.title", lambda folder, say: body_of(folder, say, found))


if __name__ == "__main__":
    style.main(draw)
