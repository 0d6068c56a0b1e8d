#!/usr/bin/python3
"""Draws the figures of a recording's odometry and writes them into one page: DIR/figures, DIR/report.html.

usage: recording.py DIR        the folder that ch5_recording FOLDER --out DIR has filled
"""
from pathlib import Path

import numpy as np

import odometry
import page
import sliders
import style


def summary_table(directory):
    summary = style.read(directory, "odometry_policies")
    head = ("policy", "ATE [m]", "scale error [%]", "yaw error [deg]", "times real time", "p99 [ms]", "images",
            "restarts")
    rows = []
    for name in odometry.policies(summary):
        row = summary.row(policy=name)
        errors = row["ate_m"], 100 * row["scale_error"], row["yaw_error_deg"]  # NaN where there is no truth
        known = lambda value, digits: "–" if np.isnan(value) else f"{value:.{digits}f}"
        rows.append((odometry.NAMES[name], *(known(error, 3) for error in errors),
                     f"{row['realtime_factor']:.1f}", known(row["p99_window_ms"], 2),
                     f"{row['frames']:.0f}", f"{row['restarts']:.0f}"))
    return page.table(head, rows)


def draw(directory):
    odometry.draw(directory)
    body = [f"<h1>Visual-inertial odometry: {Path(directory).resolve().name}</h1>",
            "<p>Two sliding-window estimators on the same recording; errors are after an alignment of position and "
            "yaw.</p>", summary_table(directory), sliders.windows(directory)]
    body += [page.figure(directory, name, words) for name, words in odometry.captions(directory).items()]
    trajectories = sorted(path.name for path in Path(directory).glob("*.tum"))
    links = ", ".join(f'<a href="{name}">{name}</a>' for name in trajectories)
    body += [f"<p>Trajectories for other tools: {links}.</p>", page.links_to_tables(directory)]
    page.write(Path(directory) / "report.html", "Visual-inertial odometry", body)


if __name__ == "__main__":
    style.main(draw)
