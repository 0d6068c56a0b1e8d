"""Every number of deck 5, from the tables that measure_speed.py keeps, and that of ch5_systems."""

from ch5_backend.figures.numbers.peers import BEST as AT_BEST, LDLT, SAME, VINS, kept, pairs_of, spans
from ch5_backend.figures.numbers.systems import by_sparse, end_by_least

from .tex import short

NAMES = {"scene/30x1000": "scene", "window/vio_M": "window", "bal/49-7776": "bal49", "bal/16-22106": "bal16"}
PROBLEMS = tuple(NAMES)
STEPS = ("linearize", "invert", "schur", "poses", "back", "update", "cost")
WHOLE = ("linearize", "solve", "update", "cost")  # of a solver that is one piece
BEST = ("sparse", "avx2")
RUNGS = {"dense": ("dense", "portable"), "plain": ("plain", "portable"), "fixed": ("sparse", "portable"), "avx2": BEST}
ROOFED = "bal/16-22106"


def time_of(tables, problem, step, solver, simd):
    """Milliseconds of a step."""
    return tables("speed_steps").row(problem=problem, step=step, solver=solver, simd=simd)["milliseconds"]


def iteration(tables, problem, solver, simd):
    """Milliseconds of one linearization, one solve, one update and one cost."""
    steps = STEPS if solver == "sparse" else WHOLE
    return sum(time_of(tables, problem, step, solver, simd) for step in steps)


def ladder(tables, problem):
    """{rung: milliseconds an iteration} of the rungs that were measured."""
    there = {(r["solver"], r["simd"]) for r in tables("speed_steps", problem=problem).rows()}
    return {name: iteration(tables, problem, *rung) for name, rung in RUNGS.items() if rung in there}


def refined_facts(tables):
    """How far above the minimum a window's cost is after each step, and when it is within 0.1 %."""
    best = min(r["cost"] for r in tables("speed_refined").rows())
    found = {}
    for name, steps in (("plain", 0), ("refined", 2)):
        rows = tables("speed_refined", landmark_steps=steps).rows()
        for r in rows[1:4]:
            found[f"landmarks.{name}.{r['iteration']:.0f}"] = f"{100 * (r['cost'] / best - 1):.3f}"
        found[f"landmarks.{name}.ms"] = f"{1e3 * next(r['seconds'] for r in rows if r['cost'] <= 1.001 * best):.2f}"
    return found


def ray_facts(tables):
    """After how many iterations 49 cameras are within each fraction of the least cost, by how their points move."""
    best = min(r["cost"] for r in tables("speed_rays").rows())
    return {f"rays.{points}.{name}": f"{next(r['iteration'] for r in tables('speed_rays', points=points).rows() if r['cost'] <= (1 + within) * best):.0f}"
            for points in ("xyz", "ray") for name, within in (("percent", 1e-2), ("thousandth", 1e-3), ("myriad", 1e-4))}


def peer_facts(tables):
    """Beside the peers, over all problems of a kind."""
    rows = kept(tables)
    found = {"peers.processor": rows[0]["processor"], "peers.date": "/".join(sorted({row["date"] for row in rows})), "peers.load": f"{rows[0]['load']:.0f}"}
    for (kind, setting, question), span in spans(rows).items():
        column = {SAME: "same", AT_BEST: "best", VINS: "vins", LDLT: "ldlt"}[setting]
        if question in ("to 0.1 %", "total"):
            found[f"peers.{kind.replace(' ', '_')}.{column}{'' if question == 'to 0.1 %' else '.whole'}"] = span
    memory = next(r for r in rows if r["problem"] == "bal/16-22106 total" and r["setting"] == SAME and r["threads"] == 1)
    return found | {"peers.ours.mb": f"{memory['ours_peak_mb']:.0f}", "peers.ceres.mb": f"{memory['peer_peak_mb']:.0f}"}


def start_facts(tables):
    """Over the problems of measure_start.py, the best λ₀ of either kind of points, relative to each problem's best pair; and the library
    unasked, with and without steps of the landmarks where a step has raised the cost."""
    rows = tables("speed_start").rows()
    pairs = pairs_of(rows)
    found = {"start.problems": str(len({row["problem"] for row in rows}))}
    for points in ("ray", "xyz"):
        name, mean, _, most, arrives = next(pair for pair in pairs if f",{points}," in pair[0] and "whole" not in pair[0])
        found |= {f"start.{points}": f"{mean:.2f}", f"start.{points}.most": f"{most:.1f}", f"start.{points}.arrives": str(arrives),
                  f"start.{points}.lambda": f"{1 / float(name.split('=')[1]):.0e}".replace("e-0", "e-")}
    return found | {f"start.{key}": f"{next(pair for pair in pairs if word in pair[0])[1]:.2f}" for key, word in (("unasked", "unasked"), ("whole", "whole"))}


def reduced_facts(tables):
    """When each solver for the cameras' system is within 1 % of the least cost, and how far above it it ends."""
    rows, found = tables("speed_reduced").rows(), {}
    best = min(r["cost"] for r in rows)
    for name, solver in (("sparse", "sparse"), ("pcg", "implicit-pcg"), ("series", "power-series")):
        mine = [r for r in rows if r["solver"] == solver]
        reached = next((r["seconds"] for r in mine if r["cost"] <= 1.01 * best), None)
        found[f"reduced.{name}"] = short(reached) if reached else "–"
        found[f"reduced.{name}.end"] = f"{100 * (min(r['cost'] for r in mine) / best - 1):.1f}"
    return found


def facts(tables):
    found = {"by_sparse": by_sparse, "end_by_least": end_by_least}
    for problem in PROBLEMS:
        name, whole, rungs = NAMES[problem], iteration(tables, problem, *BEST), ladder(tables, problem)
        for step in STEPS:
            found[f"{name}.{step}.share"] = f"{100 * time_of(tables, problem, step, *BEST) / whole:.0f}"
        for a, b in (("plain", "fixed"), ("fixed", "avx2"), ("dense", "plain")):
            if a in rungs and b in rungs:
                found[f"{name}.{a}.{b}"] = short(rungs[a] / rungs[b])
    peak = tables("speed_machine").row(simd="avx2", limit="peak")["value"]
    for step in ("linearize", "schur", "back"):
        row = tables("speed_steps").row(problem=ROOFED, step=step, solver="sparse", simd="avx2")
        speed = 1e-6 * row["flop"] / row["milliseconds"]
        found |= {f"roof.{step}.intensity": f"{row['flop'] / row['bytes']:.1f}", f"roof.{step}.share": f"{100 * speed / peak:.0f}"}
    return found | peer_facts(tables) | start_facts(tables) | refined_facts(tables) | ray_facts(tables) | reduced_facts(tables)
