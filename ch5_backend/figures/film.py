"""The window's slides as a film: the frames from above and how certain they are, H with what leaves it, and the prior that remains.

Everything is the estimator's own: film.js draws, and computes nothing.
"""
import json
from itertools import groupby
from operator import itemgetter
from pathlib import Path

import numpy as np
from markupsafe import Markup

from . import page
from .digits import MISSING
from .odometry import NAMES, policies, segments
from .style import number
from .tables import read

DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz-_"  # a shade is one of them, a vertex one or two
SHADES = 10
INSIDE = 5.99  # χ² of two numbers, 95 %
COVARIANCE = ("xx_m2", "xy_m2", "yy_m2")
MOST_POINTS = 800  # of a whole flight: more, no eye would see


def player(directory, say, flight):
    """The policies side by side: a slider over the images, one canvas, and a table of what it shows; nothing where no window has
    slid. The `flight` is simulated or recorded."""
    blocks, vertices, frames = (read(directory, f"film_{name}", may_be_empty=True) for name in ("blocks", "vertices", "frames"))
    truth, names = frames.where(policy="truth"), policies(vertices)
    if not names:
        return Markup("")
    shots = np.unique(vertices["image"])
    taken = {policy: [[table.where(policy=policy, image=image) for table in (blocks, vertices, frames)] for image in shots] for policy in names}
    letters = 1 if max(len(of[1]) for every in taken.values() for of in every) <= len(DIGITS) else 2
    film = {"names": {name: NAMES[name] for name in names}, "letters": letters, "shots": {},
            "true": int(bool(len(truth))), "ways": {name: ways(directory, name, truth) for name in names}}
    rows = []
    for policy, every in taken.items():
        largest = {stage: blocks.where(policy=policy, stage=stage)["largest"] for stage in ("window", "prior")}
        spans = {stage: np.log10(np.percentile(values, (1, 100))) for stage, values in largest.items() if len(values)}
        film["shots"][policy] = [shot(*of, spans, letters) if len(of[2]) else 0 for of in every]
        rows += [(at, NAMES[policy], *cells(*of, len(truth), say)) for at, of in enumerate(every) if len(of[2])]
    words = {key: say(f"film.{key}") for key in ("play", "pause", "back", "on", "above", "window", "prior")}
    canvas = Markup('<canvas class="film" role="img" aria-label="{}" data-film="{}" data-words="{}"></canvas>').format(
        say("film.alt"), json.dumps(film, separators=(",", ":")), json.dumps(words, ensure_ascii=False))
    script = Markup((Path(__file__).parent / "film.js").read_text(encoding="utf-8"))
    keys = [(say(f"film.{name}"), kind) for name, kind in (("truth", "truth"), ("estimate", "c0"), ("leaves", "c1")) if name != "truth" or len(truth)]
    judged = ("film.error", "film.claimed", "film.inside") if len(truth) else ("film.claimed",)
    at = {image: frames.where(image=image)["t_s"].max() for image in shots}
    return page.PIECES.player(
        "film", say("film.title"), say("film.words", flight=say(f"film.{flight}", shots=len(shots)), laid=say("film.laid") if len(truth) else ""),
        [say("film.image", image=f"{image:.0f}", seconds=f"{at[image]:.1f}") for image in shots],
        len(shots) // 3, keys, [canvas], [say(key) for key in ("policy", "film.gone", "film.fill", *judged)],
        rows) + Markup("<script>{}</script>").format(script)


def millimeters(x, y):
    return [round(1e3 * x, 1), round(1e3 * y, 1)]


def ways(directory, policy, truth):
    """The whole flight from above: the truth or, where there is none, the policy's estimate, each segment by itself."""
    pieces = [truth] if len(truth) else segments(read(directory, "odometry_path").where(policy=policy))
    return [[millimeters(x, y) for x, y in piece.matrix("x_m", "y_m")[::1 + len(piece) // MOST_POINTS]] for piece in pieces]


def shot(blocks, vertices, frames, spans, letters):
    """What the canvas shows of one slide, in millimeters."""
    digits = lambda n: DIGITS[n] if letters == 1 else DIGITS[n // len(DIGITS)] + DIGITS[n % len(DIGITS)]
    order = {int(row): digits(at) for at, row in enumerate(np.sort(vertices["row"]))}
    leaves = vertices["fate"] == "marginalized"
    gone = set(vertices["number"][leaves & (vertices["vertex"] == "pose")])
    packed = {"prior": ""}
    for stage, (low, high) in spans.items():
        of = blocks.where(stage=stage)
        shades = np.clip(np.ceil(SHADES * (np.log10(of["largest"]) - low) / max(high - low, 1e-3)), 1, SHADES).astype(int)
        every = zip(of["window_row"], of["window_column"], shades, of["fill"])
        packed[stage] = "".join(f".{order[int(row)]}" + "".join(order[int(column)] + DIGITS[shade + SHADES * int(fill)] for _, column, shade, fill in blocks_of)
                                for row, blocks_of in groupby(every, itemgetter(0)))
    rows = sorted(zip(vertices["row"], vertices["rows"], leaves))
    return {"rows": [int(count) for _, count, _ in rows], "gone": [int(left) for _, _, left in rows], **packed,
            "frames": [[int(row["frame"] in gone), *millimeters(row["x_m"], row["y_m"]), *(round(1e6 * row[name], 1) for name in COVARIANCE),
                        *(millimeters(row["true_x_m"], row["true_y_m"]) if np.isfinite(row["true_x_m"]) else ())] for row in frames.rows()]}


def cells(blocks, vertices, frames, has_truth, say):
    """What leaves, the fill-in, and how far the newest frame errs beside what is claimed."""
    leaves = vertices.where(fate="marginalized")
    count = {kind: [f"{number:.0f}" for number in leaves.where(vertex=kind)["number"]] for kind in ("pose", "speed", "landmark")}
    gone = [say(f"film.gone.{kind}", which=say("list").join(which), count=len(which)) for kind, which in count.items() if which]
    errors = np.column_stack((frames["x_m"] - frames["true_x_m"], frames["y_m"] - frames["true_y_m"]))[1:]  # the oldest is held
    xx, xy, yy = frames.matrix(*COVARIANCE)[1:].T
    claims = np.stack((xx, xy, xy, yy), axis=1).reshape(-1, 2, 2)
    known = np.isfinite(errors[:, 0])
    inside = sum(error @ np.linalg.solve(claim, error) <= INSIDE for error, claim in zip(errors[known], claims[known]))
    erring, claimed = (number(100 * value, 2) for value in (np.linalg.norm(errors[-1]), np.sqrt(np.trace(claims[-1]))))
    judged = (erring, claimed, say("film.of", inside=inside, of=known.sum())) if has_truth else (claimed,)
    return (say("semicolon").join(gone) or MISSING, int(blocks.where(stage="prior")["fill"].sum()), *judged)
