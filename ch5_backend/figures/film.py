"""The window's slides as a film: the frames from above and how certain they are, H with what leaves it, and the prior that remains.

Everything is the estimator's own: film.js draws, and computes nothing.
"""
import json
from pathlib import Path

import numpy as np
from markupsafe import Markup

from . import page
from .odometry import NAMES
from .style import number
from .tables import read

DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz-_"  # a vertex or a shade is one of them
SHADES = 10
INSIDE = 5.99  # χ² of two numbers, 95 %


def player(directory, say):
    """Both policies side by side: a slider over the images, one canvas, and a table of what it shows."""
    blocks, vertices, frames = (read(directory, f"film_{name}") for name in ("blocks", "vertices", "frames"))
    truth = frames.where(policy="truth")
    shots = [int(image) for image in np.unique(vertices["image"])]
    film = {"names": NAMES, "truth": [[round(1e3 * x, 1), round(1e3 * y, 1)] for x, y in truth.matrix("x_m", "y_m")], "shots": {}}
    rows = []
    for policy in NAMES:
        spans = {stage: np.log10(np.percentile(blocks.where(policy=policy, stage=stage)["largest"], (1, 100))) for stage in ("window", "prior")}
        film["shots"][policy] = []
        for at, image in enumerate(shots):
            here = [table.where(policy=policy, image=image) for table in (blocks, vertices, frames)]
            film["shots"][policy].append(shot(*here, spans))
            rows.append((at, NAMES[policy], *cells(*here, truth, say)))
    words = {key: say(f"film.{key}") for key in ("play", "pause", "back", "on", "above", "window", "prior")}
    canvas = Markup('<canvas class="film" role="img" aria-label="{}" data-film="{}" data-words="{}"></canvas>').format(
        say("film.alt"), json.dumps(film, separators=(",", ":")), json.dumps(words, ensure_ascii=False))
    script = Markup((Path(__file__).parent / "film.js").read_text(encoding="utf-8"))
    keys = [(say(f"film.{name}"), kind) for name, kind in (("truth", "truth"), ("estimate", "c0"), ("leaves", "c1"))]
    return page.PIECES.player(
        "film", say("film.title"), say("film.words"), [say("film.image", image=image) for image in shots],
        next(at for at, image in enumerate(shots) if image >= 20), keys, [canvas],
        [say(key) for key in ("policy", "film.gone", "film.fill", "film.error", "film.claimed", "film.inside")],
        rows) + Markup("<script>{}</script>").format(script)


def shot(blocks, vertices, frames, spans):
    """What the canvas shows of one slide, in millimeters."""
    order = {int(row): at for at, row in enumerate(np.sort(vertices["row"]))}
    leaves = vertices["fate"] == "marginalized"
    gone = set(vertices["number"][leaves & (vertices["vertex"] == "pose")])
    packed = {}
    for stage, (low, high) in spans.items():
        of = blocks.where(stage=stage)
        shades = np.clip(np.ceil(SHADES * (np.log10(of["largest"]) - low) / (high - low)), 1, SHADES).astype(int)
        packed[stage] = "".join(DIGITS[order[int(row)]] + DIGITS[order[int(column)]] + DIGITS[shade + SHADES * int(fill)]
                                for row, column, shade, fill in zip(of["window_row"], of["window_column"], shades, of["fill"]))
    rows = sorted(zip(vertices["row"], vertices["rows"], leaves))
    return {"rows": [int(count) for _, count, _ in rows], "gone": [int(left) for _, _, left in rows], **packed,
            "frames": [[int(row["frame"]), int(row["frame"] in gone), round(1e3 * row["x_m"], 1), round(1e3 * row["y_m"], 1),
                        *(round(1e6 * row[name], 1) for name in ("xx_m2", "xy_m2", "yy_m2"))] for row in frames.rows()]}


def cells(blocks, vertices, frames, truth, say):
    """What leaves, the fill-in, and how far the newest frame errs beside what is claimed."""
    leaves = vertices.where(fate="marginalized")
    count = {kind: [f"{number:.0f}" for number in leaves.where(vertex=kind)["number"]] for kind in ("pose", "speed", "landmark")}
    gone = [say(f"film.gone.{kind}", which=say("list").join(which), count=len(which)) for kind, which in count.items() if which]
    errors, claims = [], []
    for frame in frames.rows()[1:]:  # the oldest is held
        true = truth.row(frame=frame["frame"])
        errors.append(np.array([frame["x_m"] - true["x_m"], frame["y_m"] - true["y_m"]]))
        claims.append(np.array([[frame["xx_m2"], frame["xy_m2"]], [frame["xy_m2"], frame["yy_m2"]]]))
    inside = sum(error @ np.linalg.solve(claim, error) <= INSIDE for error, claim in zip(errors, claims))
    return (say("semicolon").join(gone) or "–", int(blocks.where(stage="prior")["fill"].sum()),
            number(100 * np.linalg.norm(errors[-1]), 2), number(100 * np.sqrt(np.trace(claims[-1])), 2),
            say("film.of", inside=inside, of=len(errors)))
