"""The report's sliders: step through iterations and prior weights. Without a script all positions lie faintly on
top of each other, and the tables have all rows."""

import numpy as np

from . import page
from .digits import MISSING, number
from .drawing import Axes, powers
from .tables import read

COLORS = {"course": "c1", "perturbed": "c0", "minimal": "c2"}  # as in prior.py

player = page.PIECES.player
"""player(name, title, words, labels, start, curves, drawings, head, rows): a slider with a label for each position, drawings
of the named curves, and a table of (position, cells…)."""


def iterations(directory, say):
    """The points of both scenes and the cost, iteration by iteration."""
    trace, points = read(directory, "mono_ba_trace"), read(directory, "mono_ba_iterations")
    truth = read(directory, "mono_ba_points").where(state="truth")
    scenes = {scene: f"c{2 * i}" for i, scene in enumerate(dict.fromkeys(trace["scene"]))}
    last = int(trace["iteration"].max())
    ratio = {scene: trace.where(scene=scene)["cost"] / trace.where(scene=scene)["cost"][0] for scene in scenes}
    cost = Axes(say("cost_ratio"), (0, last), powers([*ratio["course"], *ratio["large"]]), say("iteration"),
                y_log=True)
    maps, rows = [], []
    for scene, color in scenes.items():
        of = trace.where(scene=scene)
        cost.curve(of["iteration"], ratio[scene], f"thin {color}")
        maps.append(point_map(say, scene, points.where(scene=scene), truth.where(scene=scene), last, color))
        for k in range(last + 1):
            now = min(k, len(of) - 1)  # a scene that has converged stays as it is
            cost.dots(of["iteration"][now:now + 1], ratio[scene][now:now + 1], color, k)
            rows.append((k, say(f"scene.{scene}"), f"{now}" if now == k else say("iteration.done", k=now),
                         number(of["cost"][now], 6), *(number(of[name][now]) if now else MISSING for name in ("lambda", "gain_ratio", "step_norm")),
                         number(of["gradient_max"][now])))
    return player("iteration", say("iteration.title"), say("iteration.words"),
                  [say("iteration.of", k=k) for k in range(last + 1)], 0,
                  [(say(f"scene.{scene}"), color) for scene, color in scenes.items()], [cost.svg(say("cost.alt")), *maps],
                  (say("scene"), say("iteration"), say("cost"), "λ", say("gain_ratio"), "‖Δx‖", "max |b|"), rows)


def point_map(say, scene, points, truth, last, color):
    """x and z of each point at each iteration, tied to its true place."""
    x_span, z_span = (-7, 7), (2, 11)
    title = say(f"scene.{scene}")
    shown = Axes(say("points", scene=title), x_span, z_span)
    true = np.column_stack(shown.at(truth["x_m"], truth["z_m"]))
    shown.path("".join(f"M{a - 2.5:.1f} {b:.1f}a2.5 2.5 0 1 0 5 0a2.5 2.5 0 1 0 -5 0" for a, b in true), "truth")
    for k in range(last + 1):
        now = points.where(iteration=min(k, points["iteration"].max()))
        x, z = now["x_m"], now["z_m"]
        inside = (x > x_span[0]) & (x < x_span[1]) & (z > z_span[0]) & (z < z_span[1])
        ways = np.column_stack((*shown.at(x, z), true))[inside]
        shown.path("".join(f"M{a:.1f} {b:.1f}h0L{u:.1f} {v:.1f}" for a, b, u, v in ways),
                   f"point {'many' if len(x) > 50 else 'few'} {color}", k)
    return shown.svg(say("points.alt", scene=title), "single")


def weights(directory, say):
    """Iterations against the weight, and the way that the solver takes at the chosen one."""
    sweep, trace = read(directory, "prior_sweep"), read(directory, "prior_trace")
    steps = np.unique(sweep["weight"])
    place = np.where(steps > 0, steps, steps[1] / 30)  # w = 0 stands apart
    most = sweep["iterations"].max()
    count = Axes(say("count"), (place[0], steps[-1]), (1, most + 1), say("weight"), True, True)
    way = Axes(say("excess"), (1, most + 1), (1e-14, 1), say("next_iteration"), True, True)
    rows = []
    for variant, color in COLORS.items():
        of = sweep.where(variant=variant)
        count.curve(place[1:], of["iterations"][1:], f"thin {color}")
        for k, weight in enumerate(steps):
            row, costs = of.row(weight=weight), trace.where(variant=variant, weight=weight)["cost"]
            excess = (costs - costs[-1]) / costs[0]
            keep = excess > 1e-14
            way.curve(np.arange(1, len(costs) + 1)[keep], excess[keep], color, k)
            count.dots(place[k:k + 1], [row["iterations"]], color, k)
            rows.append((k, say(f"variant.{variant}"), f"{row['iterations']:.0f}", number(row["reprojection_cost"], 4),
                         *(number(row[name]) for name in ("prior_cost", "drift_position")),
                         number(1e3 * row["rmse_position"], 4), say(row["termination"])))
    return player("prior-weight", say("prior-weight.title"), say("prior-weight.words"),
                  [f"w = {number(w, 1)}" for w in steps], len(steps) // 2,
                  [(say(f"variant.{variant}.words"), color) for variant, color in COLORS.items()],
                  [count.svg(say("count.alt")), way.svg(say("cost.alt"))],
                  (say("variant"), say("iterations"), say("reprojection_cost"), say("prior_cost"), say("drift_position"),
                   "RMSE [mm]", say("stopped_by")), rows)
