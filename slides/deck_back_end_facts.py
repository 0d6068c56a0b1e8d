"""Every number of the deck, by name. Each comes from a table of ./course run, or is exact arithmetic that is held
against one; the deck writes {{name}} and never a digit of a result."""

from fractions import Fraction
from math import gcd, lcm

import numpy as np

from ch5_backend.figures.numbers.chapter import Chapter
from ch5_backend.figures.tables import dense

from .facts import gathered, typed_in
from .marginalization_examples import solved_chain
from .tex import bracketed, decimal, matrix, scientific, tex


def chain_facts(tables):
    """The 3×3 example in exact fractions."""
    H, _, prior, _ = solved_chain(tables)
    steps = [rf"{tex(H[i][j])} - {bracketed(H[i][1])}\cdot{bracketed(H[1][j])}\,/\,{tex(H[1][1])} &= "
             rf"{tex(prior[i // 2][j // 2])} = {decimal(prior[i // 2][j // 2]).replace('−', '-')}" for i, j in ((0, 0), (0, 2), (2, 2))]
    return {"chain.H": matrix(H, tex), "chain.step00": steps[0], "chain.step02": steps[1], "chain.step22": steps[2],
            "chain.fraction": common_factor(prior)}


def common_factor(rows):
    """A matrix of fractions as one fraction times whole numbers, in TeX."""
    entries = [v for row in rows for v in row]
    factor = Fraction(gcd(*(v.numerator for v in entries)), lcm(*(v.denominator for v in entries)))
    return tex(factor) + matrix([[v / factor for v in row] for row in rows], tex)


def bundle_facts(tables):
    facts = {}
    for name in ("course", "large"):
        row = Chapter(tables).solve(name)
        for column in ("frames", "points", "unknowns", "edges", "iterations"):
            facts[f"{name}.{column}"] = f"{row[column]:.0f}"
        facts[f"{name}.initial_cost"] = scientific(row["initial_cost"])
        facts[f"{name}.final_cost"] = scientific(row["final_cost"])
        facts[f"{name}.rmse_before_mm"] = f"{1e3 * row['initial_rmse_landmark_m']:.0f}"
        facts[f"{name}.rmse_after_mm"] = f"{1e3 * row['final_rmse_landmark_m']:.1f}"
    facts["course.poses_dim"] = str(len(dense(tables("hessian", scene="course", matrix="S"))))
    facts["course.size"] = str(len(dense(tables("hessian", scene="course", matrix="H"))))
    return facts


def gauge_facts(tables):
    """The gap in the spectrum of the free problem: zeros, then the smallest true eigenvalue."""
    sizes, zeros = Chapter(tables).spectrum("free")
    return {"gauge.zeros": str(zeros), "gauge.largest_zero": scientific(sizes[zeros - 1], 1),
            "gauge.smallest": scientific(sizes[zeros], 1)}


def prior_facts(tables):
    n = Chapter(tables)
    mean = lambda weight: n.at("prior_trials", "mean_iterations", weight, variant="perturbed")  # noqa: E731
    damping = lambda name, column: n.ends("prior_damping", column, damping=name)  # noqa: E731
    cost, rmse = (n.ends("prior_sweep", column, variant="perturbed") for column in ("reprojection_cost", "rmse_position"))
    weights, minimal = tables("prior_trials", variant="course")["weight"], tables("prior_sweep", variant="minimal")["reprojection_cost"]
    peak_weight, peak = n.peak("perturbed")
    return {
        "prior.trials": f"{tables('prior_trials')['trials'][0]:.0f}",
        "prior.peak_weight": scientific(peak_weight, 1), "prior.peak": f"{peak:.1f}",
        "prior.free": f"{mean(0.0):.1f}", "prior.plateau": f"{mean(1e10):.1f}",
        "prior.heaviest": scientific(weights.max(), 1),
        "prior.identity_heaviest": f"{damping('identity', 'iterations')[1]:.0f}",
        "prior.diagonal_heaviest": f"{damping('diagonal', 'iterations')[1]:.0f}",
        "prior.lambda0_light": scientific(damping("identity", "lambda0")[0], 2),
        "prior.lambda0_heavy": scientific(damping("identity", "lambda0")[1], 2),
        "prior.cost_light": f"{cost[0]:.2f}", "prior.cost_heavy": f"{cost[1]:.2f}",
        "prior.minimal_spread": scientific(np.ptp(minimal) / minimal.min(), 1),
        "prior.rmse_light": f"{1e3 * rmse[0]:.1f}", "prior.rmse_heavy": f"{1e3 * rmse[1]:.1f}",
    }


def study_facts(tables):
    """How the experiment is set up: the starts from its source, the weights from its table."""
    position, rotation = typed_in("ch5_backend/experiments/studies/prior_study.cc",
                                  r"position_sigma = ([\d.]+);.*rotation_sigma = ([\d.]+) \* M_PI / 180\.0;")
    weights = [w for w in tables("prior_sweep", variant="course")["weight"].tolist() if w > 0]
    return {"study.position_cm": f"{100 * float(position):g}", "study.rotation_deg": f"{float(rotation):g}",
            "study.lightest": scientific(min(weights), 1, shortest=False), "study.heaviest": scientific(max(weights), 1)}


facts = gathered(bundle_facts, chain_facts, gauge_facts, prior_facts, study_facts)
