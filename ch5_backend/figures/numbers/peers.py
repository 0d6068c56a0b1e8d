"""How many times as fast ours is than a peer, over all problems of a kind: from the rows of ./course bench."""

from itertools import product
from math import isnan
from statistics import geometric_mean

# The settings of a comparison. In the first, both sides are told the same: variables, first damping (Ceres' default), no steps
# of landmarks alone. In the second ours does what the library does unasked, and Ceres what serves it best.
SAME, BEST = "same problem", "each at its best"
QUESTIONS = ("iteration", "total", "to 1 %", "to 0.1 %", "to the peer's cost")  # an iteration: a trial, rejected or not
KINDS = {"scenes": "scene/", "windows": "window/", "bundle adjustment": "bal/", "cities": "city/", "pose graphs": "pose_graph/"}
VINS, LDLT = "VINS-Mono's way", "Eigen's LDLT"  # who else marginalizes: two eigendecompositions, or what a user writes with Eigen


def kinds_of(rows) -> list:
    """With one thread, where both sides have an answer: (kind, setting or peer, question, geometric mean, least, most, how many
    have one, of how many)."""
    found = []
    for kind, setting, question in product(KINDS, (SAME, BEST), QUESTIONS[:-1]):
        found += _over([row for row in rows if row["problem"].startswith(KINDS[kind]) and row["problem"].endswith(f" {question}")
                        and row["setting"] == setting and row["peer"]], kind, setting, question)
    for peer in (VINS, LDLT):
        found += _over([row for row in rows if row["problem"].startswith("marginalize/") and row["peer"] == peer], "marginalization",
                       peer, "total")
    return found


def _over(rows, *names):
    every = [row["ratio"] for row in rows if row["threads"] == 1]
    ratios = [ratio for ratio in every if ratio and not isnan(ratio)]
    return [(*names, geometric_mean(ratios), min(ratios), max(ratios), len(ratios), len(every))] if ratios else []


def kept(tables) -> list:
    """The rows of slides/measured/speed_peers.csv that the processor measured last gave."""
    rows = tables("speed_peers").rows()
    return [row for row in rows if row["processor"] == rows[0]["processor"]]


def spans(rows) -> dict:
    """{(kind, setting or peer, question): "mean (least–most)"}, and on how many problems where one has no answer."""
    return {key: f"{mean:.1f} ({least:.1f}–{most:.1f}" + (f"; {there}/{every})" if there < every else ")")
            for *key, mean, least, most, there, every in kinds_of(rows) for key in [tuple(key)]}


def pairs_of(rows) -> list:
    """Of measure_start.py's rows, for each pair of variables and first damping, the best one first: (pair, geometric mean, least, most
    of its times relative to each problem's best, on how many problems it arrives)."""
    best = {}
    for row in rows:
        best[row["problem"]] = min(row["ms"], best.get(row["problem"], row["ms"]))
    found = []
    for pair in dict.fromkeys(row["pair"] for row in rows):
        mine = [row for row in rows if row["pair"] == pair]
        ratios = [row["ms"] / best[row["problem"]] for row in mine]
        found.append((pair, geometric_mean(ratios), min(ratios), max(ratios), sum(int(row["arrives"]) for row in mine)))
    return sorted(found, key=lambda pair: pair[1])
