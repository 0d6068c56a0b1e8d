#!/usr/bin/python3
"""Draws the gauge paper's experiments and writes one page, DIR/report.html, and its numbers, DIR/summary.csv.

usage: gauge_report.py [DIR]        DIR/csv is read; what has no table there is left out
"""
from pathlib import Path

from markupsafe import Markup

from . import gauge, gauge_captions, gauge_choice, gauge_covariance, page, style
from .numbers import gauge as gauge_numbers, gauge_paper
from .style import number
from .words import Words
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
HEAD = ("position [m]", "rotation [deg]", "velocity [m/s]")


def errors_table(n):
    """Table II, ours and the paper's."""
    rows = []
    for scene in gauge_paper.SCENES:
        for method in ("fixation", "free", "prior"):
            paper = gauge_paper.RMSE[scene].get(method, gauge_paper.RMSE[scene]["fixation"])
            ours = [n[f"{scene[0]} {scene[1]} {method}", f"mean {column}"] for column in gauge.ERRORS]
            rows.append((f"{scene[0]}, {scene[1]}: {method}", *(f"{value:.5f}" for value in ours),
                         *(number(value, 4) for value in paper)))
    return page.table(("mean RMSE", *(f"{name}, ours" for name in HEAD), *("the paper's",) * 3), rows)


def recordings_table(n):
    """Table III's analogue."""
    rows = []
    for recording, name in gauge_choice.RECORDINGS.items():
        for method in ("fixation", "free", "prior"):
            of = f"{recording} {method}"
            rows.append((f"{name}: {method}", *(f"{n[of, 'median ' + column]:.5f}" for column in gauge.ERRORS),
                         f"{n[of, 'median iterations']:.1f}", f"{n[of, 'median milliseconds']:.0f}"))
    rows += [(f"the paper's EuRoC MH: {method}", *(f"{value:.5f}" for value in values), "–", "–")
             for method, values in gauge_paper.EUROC.items()]
    return page.table(("median RMSE", *HEAD, "iterations", "time [ms]"), rows)


def covariance_table(n):
    name = {"free untransformed": "free, as it is, from fixed", "free to fixed": "free, transformed, from fixed",
            "fixed untransformed": "fixed, as it is, from free", "fixed to free": "fixed, transformed, from free"}
    distance = lambda of, what: number(n[of, f"{what} relative Frobenius distance"], 2)
    rows = [(words, *(distance(of, what) for what in ("least", "mean", "largest"))) for of, words in name.items()]
    rows.append(("the paper's free, transformed, from fixed", "–", number(gauge_paper.COVARIANCE_DISTANCE, 2), "–"))
    return page.table(("‖Σ − Σ'‖ / ‖Σ'‖", "least", "mean", "largest"), rows)


def variants_table(n):
    """Table II with other scenes."""
    rows = []
    for variant in gauge_numbers.VARIANTS:
        for scene in map(" ".join, gauge_paper.SCENES):
            mean = lambda column: n[f"{variant}, {scene}", f"mean {column}"]  # noqa: B023
            rows.append((f"{variant}: {scene}", f"{mean('seen_per_keyframe'):.0f}",
                         *(f"{mean(column):.4f}" for column in gauge.ERRORS),
                         *(f"{mean(f'{method}_iterations'):.2f}" for method in gauge_numbers.METHODS[:3])))
    return page.table(("mean", "points seen", *HEAD, "iterations: fixation", "free", "prior"), rows)


def audit_table(n):
    """What each part of a window's H claims to know."""
    parts = {"measurements": "measurements", "prior": "prior, at its first estimates", "window": "both, at the estimates"}
    directions = ("x", "y", "z", "yaw", "roll", "pitch", "scale")
    rows = [(f"{policy}, constraints on {constraints}: {words}",
             *(number(n[f"{policy} {constraints} {part}", f"largest relative {d}"], 2) for d in directions))
            for policy in ("vins", "okvis") for constraints in ("none", "marginalized edges")
            for part, words in parts.items()]
    return page.table(("‖P⁻¹Hn‖ / ‖Pn‖", *directions), rows)


TABLES = {"gauge_errors": ("methods", errors_table), "gauge_matrices": ("covariance", covariance_table),
          "gauge_recordings": ("recordings", recordings_table)}


def body_of(directory, drawn, found):
    """The page's pieces."""
    words, say = gauge_captions.captions(found), Words("en")
    body = ["<h1>Three ways to handle a gauge</h1>",
            "<p>The experiments of Zhang, Gallego and Scaramuzza (RA-L 2018) on our own solver, and beyond them. Every "
            "number of ours is read from the tables beside this page. The paper's simulator was not released, and it "
            "does not state its number of points, intrinsics, noise and rates: structure can be compared, digits "
            "cannot. Our iteration is Levenberg-Marquardt with λ diag(H) and Ceres' default rules.</p>"]
    trials = found["methods"]["all scenes", "trials"] if "methods" in found else gauge_paper.TRIALS
    if trials < gauge_paper.TRIALS:
        body.append(Markup("<p><strong>A quick run: {:.0f} of the paper's {} trials of each scene. Every mean below is "
                           "rough.</strong></p>").format(trials, gauge_paper.TRIALS))
    for name in drawn:
        body.append(page.figure(directory, name, words[name], gauge_captions.ALTERNATIVES[name], say))
        table, make = TABLES.get(name, (None, None))
        if table in found:
            body.append(make(found[table]))
    if "variants" in found:
        body += [Markup("<p>{}</p>").format(words["gauge_variants"]), variants_table(found["variants"])]
    if "audit" in found:
        body += [Markup("<p>{}</p>").format(words["gauge_audit"]), audit_table(found["audit"])]
    return [*body, '<p><a href="summary.csv">summary.csv</a>: the numbers above, and more.</p>',
            page.links_to_tables(directory, say)]


def draw_figures(directory):
    """All that have their table; returns their names."""
    drawn = [name for name, (table, _) in FIGURES.items() if (Path(directory) / "csv" / f"{table}.csv").exists()]
    for name in drawn:
        table, draw_one = FIGURES[name]
        draw_one(directory, read(directory, table))
    return drawn


def draw(directory):
    """The figures, the page and the summary."""
    drawn = draw_figures(directory)
    if not drawn:
        raise TableError(f"{directory}/csv: none of the tables of the gauge experiments is there")
    found = gauge_numbers.numbers(directory)
    gauge_numbers.write_summary(Path(directory) / "summary.csv", found)
    page.write(Path(directory) / "report.html", "Three ways to handle a gauge", body_of(directory, drawn, found))


if __name__ == "__main__":
    style.main(draw)
