#!/usr/bin/python3
"""Draws a student's run beside the solution's, writes DIR/mine.html and DIR/mine.zh.html, and prints a line for each
experiment.

usage: mine.py DIR [--language WORD]        DIR is what ./course run --mine has filled
"""
import json
import sys
from pathlib import Path

import numpy as np
from markupsafe import Markup

from . import page, style
from .numbers.mine import EXPERIMENTS, Mine, dense_of, different
from .style import BLUE, GRAY, PALE, SKY, plt
from .translate import translate
from .words import Words

STAGES = json.loads((Path(__file__).resolve().parents[2] / "ch5_homework" / "stages.json").read_text(encoding="utf-8"))["stages"]
PAGES = {"en": "mine.html", "zh": "mine.zh.html"}
OWN, SOLUTION = {"color": BLUE, "label": "yours"}, {"color": GRAY, "linestyle": "--", "label": "solution"}
BROAD, DOTTED = {**SOLUTION, "linewidth": 5, "color": PALE, "linestyle": "-"}, {**OWN, "marker": "o"}
MATRICES = {"hessian": ("H", "S"), "marginal": ("prior of the chain", "without points", "without frame 1")}
DEVIATIONS = (("free", "free"), ("fixed", "fixed"), ("free to fixed", "free → fixed"), ("fixed to free", "fixed → free"))
QUESTIONS = ("first_estimate", "sign", "free_gauge")


# ---- Pictures -------------------------------------------------------------------------------------------------------

def sides(mine, experiment, name, solution=SOLUTION, own=OWN):
    """(table, its look) of the solution's and the student's, of those that are there."""
    theirs, ours = reversed(mine.both(experiment, name))
    return [(table, look) for table, look in ((theirs, solution), (ours, own)) if table is not None]


def draw_matrix(axes, mine, experiment, name):
    """The student's entries as shades; what differs from the solution's is red."""
    own, solution = mine.both(experiment, "matrices")
    theirs = dense_of(solution, name, solution)
    ours = np.zeros_like(theirs) if own is None or name not in own["matrix"] else dense_of(own, name, solution)
    low, high = np.log10([np.abs(theirs[theirs != 0]).min(), np.abs(theirs).max()])
    style.magnitudes(axes, ours, max(low - 1, high - 8), high, cmap="Greys")
    wrong = different(ours, theirs)
    axes.imshow(np.ma.masked_where(~wrong, wrong), cmap="autumn", vmin=1, vmax=2, alpha=0.75)
    axes.set_title(f"{name}: {wrong.sum()} of {wrong.size} differ", fontsize=12)
    style.bare(axes, frame=True)


def draw_convergence(axes, mine, experiment):
    for table, look in sides(mine, experiment, "convergence", BROAD, DOTTED):
        axes.plot(table["iteration"], table["cost"], **look)
    style.log_axis(axes.yaxis)
    axes.xaxis.set_major_locator(plt.MaxNLocator(integer=True))
    axes.set(title="cost", xlabel="iteration")
    axes.legend()


def draw_matrices(panels, mine, experiment):
    for axes, name in zip(panels, MATRICES[experiment]):
        draw_matrix(axes, mine, experiment, name)
    if experiment == "hessian":
        draw_convergence(panels[2], mine, experiment)


def draw_weights(panels, mine, experiment):
    for axes, column, title in zip(panels, ("iterations", "drift_m"), ("iterations", "drift of frame 0 [m]")):
        for variant, marker in (("course", "o"), ("perturbed", "s")):
            for table, look in sides(mine, experiment, "weights"):
                rows = table.where(variant=variant)
                known = rows[column] > 0
                label = f"{variant}, yours" if look is OWN else f"{variant}, solution"
                axes.plot(rows["weight"][known], rows[column][known], marker=marker, **{**look, "label": label})
        style.log_axis(axes.xaxis)
        axes.set(title=title, xlabel="prior weight w")
    style.log_axis(panels[1].yaxis)


def draw_gauge(panels, mine, experiment):
    for axes, (gauge, title) in zip(panels, DEVIATIONS):
        for table, look in sides(mine, experiment, "deviations", BROAD, DOTTED):
            rows = table.where(gauge=gauge)
            axes.plot(rows["keyframe"], rows["position_m"], **look)
        axes.xaxis.set_major_locator(plt.MaxNLocator(integer=True))
        axes.set(title=title, xlabel="keyframe")
    panels[0].set_ylabel("σ of the position [m]")
    panels[0].legend()


def draw_flight(panels, mine, experiment):
    """From above, no further out than three rooms; and how far the flight is from the solution's."""
    above, apart = panels
    paths = {"truth": mine.truth(experiment), "solution": mine.path(experiment, "solution"), "own": mine.path(experiment, "own")}
    looks = {"truth": {"color": PALE, "linewidth": 6, "label": "truth"}, "solution": SOLUTION, "own": OWN}
    for name, path in paths.items():
        if len(path):
            above.plot(path[:, 0], path[:, 1], **looks[name])
    frame = np.vstack([paths["truth"], paths["solution"]])
    middle, half = (frame.max(0) + frame.min(0))[:2] / 2, 0.6 * np.ptp(frame, axis=0)[:2].max()
    outside = np.abs(paths["own"][:, :2] - middle).max(initial=0) > half
    half *= 3 if outside else 1
    above.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half), aspect="equal",
              title="from above", xlabel="x [m]", ylabel="y [m]")
    if len(paths["own"]):
        above.plot(*paths["own"][-1, :2], "o", color=BLUE, markersize=9)
        _, t, distance = mine.distance(experiment)
        apart.plot(t, np.maximum(distance, 1e-12), color=BLUE)
        apart.axhline(1e-3, color=GRAY, linestyle=":")
        apart.set_ylim(1e-12, max(10.0, 3 * np.nanmax(distance, initial=0)))
        style.log_axis(apart.yaxis)
    apart.set(title="your flight from the solution's [m]", xlabel="time [s]", visible=bool(len(paths["own"])))
    above.legend(fontsize=11)


def draw_blocks(panels, mine, experiment):
    left, right = panels
    draw_convergence(left, mine, experiment)
    times = mine.table(experiment, "own", "times")
    right.set_visible(times is not None)
    if times is not None:
        right.barh(times["solver"], times["milliseconds"], color=[BLUE if name == "PlainBlockSolver" else GRAY for name in times["solver"]])
        for name, value in zip(times["solver"], times["milliseconds"]):
            right.text(value, name, f" {style.number(value)}", va="center")
        right.invert_yaxis()
        right.set(title="milliseconds an iteration", xlim=(0, 1.25 * times["milliseconds"].max()))


def draw_beacons(panels, mine, experiment):
    left, right = panels
    draw_convergence(left, mine, experiment)
    own, solution = mine.both(experiment, "path")
    right.plot(solution["true_x_m"], solution["true_y_m"], color=PALE, linewidth=6, label="truth")
    for table, look in sides(mine, experiment, "path"):
        right.plot(table["x_m"], table["y_m"], **look)
    if own is not None:
        right.plot(own["guess_x_m"], own["guess_y_m"], ":", color=SKY, label="your IMU alone")
    right.set(title="from above", xlabel="x [m]", ylabel="y [m]", aspect="equal", xlim=(-6, 6), ylim=(-6, 6))
    right.legend(fontsize=11)


FLIGHT = (draw_flight, 2, {"gridspec_kw": {"width_ratios": (1.2, 1)}})
DRAW = {  # what fills the panels of an experiment, how many, and what else they ask for
    "hessian": (draw_matrices, 3, {}), "marginal": (draw_matrices, 3, {}), "weights": (draw_weights, 2, {"legend": 4}),
    "gauge": (draw_gauge, 4, {"sharey": True}), "okvis": FLIGHT, "vins": FLIGHT, "blocks": (draw_blocks, 2, {}),
    "beacons": (draw_beacons, 2, {})}


# ---- Words ----------------------------------------------------------------------------------------------------------

def told(finding, say):
    """A finding as a sentence."""
    shown = {name: style.number(value, 4) if isinstance(value, float) and not value.is_integer() else value
             for name, value in finding.values.items()}
    prefix = {"weight": "", "deviation": "gauge."}.get(finding.key)
    if prefix is not None:  # what the tables call it, in the page's words
        shown["column"] = say(prefix + shown["column"])
    in_words = translate if say.language == "zh" else str
    if "gauge" in shown:
        shown["gauge"] = in_words(dict(DEVIATIONS)[shown["gauge"]])
    if "message" in shown:
        shown["message"] = in_words(shown["message"])
    if "variant" in shown:
        shown["variant"] = say(f"variant.{shown['variant']}")
    return say(f"mine.{finding.key}", **{name: int(value) if isinstance(value, float) else value for name, value in shown.items()})


def whose(mine, stage, say):
    """Whose lines a stage runs on."""
    if errors := mine.files[stage["file"]]["errors"]:
        return say("mine.does_not_compile", file=stage["file"], why=errors[say.language])
    empty = mine.empty_todos(stage["file"])
    lost = [todo for todo in stage["todos"] + stage.get("deep", []) if todo in empty]
    if not lost:
        return say("mine.yours")
    functions = ", ".join(dict.fromkeys(empty[todo] for todo in lost))
    return say("mine.unfinished", todos=", ".join(lost), functions=functions)


def stages_of(experiment):
    return [stage for stage in STAGES if stage["id"] in EXPERIMENTS[experiment]]


def verdicts(mine, experiment, say):
    """(stage, mark, sentence) of each stage: ✓ where the student's lines do the same, ✗ where theirs are the first to differ,
    – where there are none of them, or an earlier stage's difference goes into it."""
    wrong, found = mine.wrong_stage(experiment), mine.finding(experiment)
    for stage in stages_of(experiment):
        if wrong == stage["id"]:
            yield stage, "✗", told(found, say)
        elif wrong and wrong < stage["id"]:
            yield stage, "–", say("mine.not_judged", stage=wrong)
        elif any(todo in mine.files[stage["file"]]["own"] for todo in stage["todos"]):
            yield stage, "✓", say("mine.same")
        else:
            yield stage, "–", say("mine.nothing_yet")


def body_of(directory, mine, say):
    """The page's pieces."""
    rows = []
    for experiment in mine.failures:
        for stage, mark, sentence in verdicts(mine, experiment, say):
            rows.append((f"{stage['id']} {stage['name']}", whose(mine, stage, say), f"{mark} {sentence}"))
    body = [*page.opening(say("mine.heading"), say("mine.lead"), say, PAGES),
            page.table((say("mine.stage"), say("mine.lines"), say("mine.finding")), rows, "words said")]
    for experiment in mine.failures:
        ids = say("list").join(EXPERIMENTS[experiment])
        found = " ".join(dict.fromkeys(sentence for _, _, sentence in verdicts(mine, experiment, say)))
        picture = page.figure(directory, f"mine_{experiment}", f"{say(f'mine.{experiment}.caption')} {found}",
                              say(f"mine.{experiment}"), say)
        body.append(page.PIECES.section(experiment, say("mine.section", stages=ids, title=say(f"mine.{experiment}")), [picture]))
    if len(mine.failures) == len(EXPERIMENTS) and all(lines == say("mine.yours") and found[0] == "✓" for _, lines, found in rows):
        questions = [Markup("<details><summary>{}</summary><p>{}</p></details>").format(say(f"mine.question.{name}"), say(f"mine.answer.{name}"))
                     for name in QUESTIONS]
        body.append(page.PIECES.section("questions", say("mine.questions"), questions))
    return body


def make(directory, language):
    mine = Mine(directory)
    for experiment in mine.failures:
        fill, columns, shape = DRAW[experiment]
        with style.panels(directory, f"mine_{experiment}", 1, columns, **shape) as panels:
            fill(panels, mine, experiment)
    page.write_all(directory, "mine.heading", lambda place, say: body_of(place, mine, say), PAGES)
    say = Words(language)
    for experiment in mine.failures:
        for stage, mark, sentence in verdicts(mine, experiment, say):
            print(f"{mark} {stage['id']:<9} {say('mine.line', title=say(f'mine.{experiment}'), finding=sentence)}")
    for stage in STAGES:
        if any(stage["id"] in EXPERIMENTS[experiment] for experiment in mine.failures) and whose(mine, stage, say) != say("mine.yours"):
            print(f"  {stage['id']:<9} {whose(mine, stage, say)}")
    print(say("mine.page", path=Path(directory) / PAGES[language]))


if __name__ == "__main__":
    *words, last = sys.argv[1:]
    make(Path(words[0]), last)
