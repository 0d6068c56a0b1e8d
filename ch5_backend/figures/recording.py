#!/usr/bin/python3
"""Draws the figures of a recording's odometry and writes them into one page: DIR/figures, DIR/report.html, in Chinese
DIR/report.zh.html.

usage: recording.py DIR        the folder that ch5_recording FOLDER --out DIR has filled
"""
from pathlib import Path

import numpy as np
from markupsafe import Markup

from . import evaluation, film, odometry, page, style
from .digits import fixed, minus
from .tables import read

NAMES = {**odometry.NAMES, "batch": "batch"}  # --batch: the whole recording at once


def summary_table(directory, say):
    summary = read(directory, "odometry_policies")
    head = (say("policy"), "ATE [m]", "RPE [m]", say("drift_percent"), say("path_length"), say("scale_error"), say("yaw_error"), say("consistency.nees_motion"), say("realtime"), say("tracking"), "p99 [ms]", say("images"),
            say("restarts"))
    rows = []
    for name in summary["policy"]:
        row = summary.row(policy=name)
        errors = row["ate_m"], row["rpe_m"], row["drift_percent"], row["path_m"], 100 * row["scale_error"], row["yaw_error_deg"]  # NaN where there is no truth
        rows.append((NAMES[name], *(fixed(error, 3) for error in errors), fixed(row["nees_motion"], 1),
                     fixed(row["realtime_factor"], 1), fixed(row["tracking_factor"], 1), fixed(row["p99_window_ms"], 2),
                     f"{row['frames']:.0f}", f"{row['restarts']:.0f}"))
    return page.table(head, rows)


def segment_table(directory, say):
    """What each restart has begun; nothing where there was none."""
    table = read(directory, "odometry_segments")
    if np.all(table["segment"] == 0):
        return ""
    head = say("policy"), say("segment"), say("seconds"), say("images"), "ATE [m]", say("scale_error"), say("yaw_error")
    rows = [(NAMES[row["policy"]], f"{row['segment']:.0f}", f"{row['first_s']:.2f} – {row['last_s']:.2f}",
             f"{row['frames']:.0f}", fixed(row["ate_m"], 3), fixed(100 * row["scale_error"], 3), fixed(row["yaw_error_deg"], 3))
            for row in table.rows()]
    return page.paragraph(say("segment.words"), say) + page.table(head, rows)


def warnings(directory, say):
    """What is doubtful in the data, with the numbers that it has in the figure of what happened when."""
    for k, row in enumerate(read(directory, "odometry_warnings", may_be_empty=True).rows(), start=1):
        numbers = {name: minus(f"{row[name]:.4g}") for name in ("value", "other")}
        words = say(f"warning.{row['warning']}", detail=row["detail"], **numbers)
        yield Markup("<p><strong>{}</strong>{}</p>").format(say("warning", number=k), words)


def body_of(directory, say):
    """The page's pieces: the path first, then what judges it, then how the estimators work."""
    trajectories = sorted(path.name for path in Path(directory).glob("*.tum"))
    links = Markup(say("list")).join(Markup('<a href="{0}">{0}</a>').format(name) for name in trajectories)
    words = {**odometry.captions(directory, say), **evaluation.captions(directory, say)}
    drawn = {name: page.figure(directory, name, words[name], say(f"{name}.alt"), say) for name in words}
    has_truth = bool(len(read(directory, "odometry_path").where(policy="truth")))
    has_nees = np.isfinite(read(directory, "odometry_policies")["nees_motion"]).any()
    judged = [drawn.pop(name) for name in ("odometry_lengths", "odometry_consistency", "odometry_timeline", "odometry_biases", "odometry_timing")
              if name in drawn]
    return [*page.opening(say("recording.heading", name=Path(directory).resolve().name), say("recording.lead"), say),
            drawn.pop("odometry_path"), *warnings(directory, say), summary_table(directory, say), segment_table(directory, say),
            *([] if has_truth else [page.paragraph(say("recording.no_truth"))]), *judged, *([page.paragraph(say("recordings.gauge"), say)] if has_nees else []), film.player(directory, say, "recorded"), *drawn.values(),
            Markup(f"<p>{say('trajectories', links='{}')}</p>").format(links), page.links_to_tables(directory, say)]


def draw(directory):
    odometry.draw(directory)
    evaluation.draw(directory)
    page.write_all(directory, "recording.title", body_of)


if __name__ == "__main__":
    style.main(draw)
