"""Every number of deck 2, from the tables of ch5_solvers or by exact counting."""

from math import log10

from ch5_backend.figures.numbers.chapter import Chapter

from .facts import gathered
from .tex import scientific


def schur_facts(_):
    """Multiplications of a Cholesky factorization, n³/6, of H and of S, and those of forming S: a landmark that k poses
    see costs k(k+1)/2 blocks of 6 × 6."""
    frames, points = 30, 1000
    n, p = 6 * frames + points, 6 * frames
    whole, reduced = n ** 3 / 6, p ** 3 / 6
    form = points * frames * (frames + 1) / 2 * 36
    return {"schur.frames": str(frames), "schur.points": str(points), "schur.size": str(n), "schur.reduced": str(p),
            "schur.whole": f"{whole / 1e6:.0f}", "schur.factor": f"{reduced / 1e6:.1f}", "schur.form": f"{form / 1e6:.1f}",
            "schur.ratio": f"{whole / (reduced + form):.0f}"}


def pcg_facts(tables):
    facts, condition, iterations = {}, {}, {}
    for name in ("none", "diagonal", "blocks"):
        rows = tables("solver_pcg", preconditioner=name).rows()
        sizes = tables("solver_spectrum", preconditioner=name)["eigenvalue"].tolist()
        done = next((r["iteration"] for r in rows if r["relative_residual"] < 1e-8), None)
        condition[name], iterations[name] = max(sizes) / min(sizes), done or rows[-1]["iteration"]
        facts |= {f"pcg.{name}": f"{done:.0f}" if done else f"> {rows[-1]['iteration']:.0f}",
                  f"pcg.{name}.condition": scientific(condition[name], 1)}
    rows = tables("solver_pcg", preconditioner="blocks").rows()
    facts |= {"pcg.size": str(len(tables("solver_spectrum", preconditioner="none").rows())),
              "pcg.correct": scientific(rows[-1]["relative_residual"], 1), "pcg.course": f"{rows[-1]['without_first_step']:.2f}",
              "pcg.condition_ratio": f"{condition['diagonal'] / condition['blocks']:.1f}",
              "pcg.iteration_ratio": f"{iterations['diagonal'] / iterations['blocks']:.1f}"}
    return facts


def rule_facts(tables):
    facts = {}
    for problem in ("curve", "valley", "bundle"):
        for rule in ("nielsen", "ceres", "tenfold"):
            rows = tables("solver_rules", problem=problem, rule=rule).rows()
            facts[f"rules.{problem}.{rule}"] = f"{rows[-1]['trial']:.0f} ({sum(r['accepted'] == 0 for r in rows)})"
    return facts


def half_facts(tables):
    half = tables("solver_half_damped")
    one = min(half.rows(), key=lambda r: abs(log10(r["relative_lambda"])))
    return {"half": half, "half.gain_one": f"{one['half_damped_gain_ratio']:.2f}"}


def stop_facts(tables):
    """At which iteration the homework's and VINS-Course's rules end the run; their χ² is twice the cost."""
    facts = {}
    for information in sorted({r["information"] for r in tables("solver_stop").rows()}):
        rows = tables("solver_stop", information=information).rows()
        chi = [2 * r["cost"] for r in rows]
        steps = range(1, len(rows))
        name = f"stop.{round(log10(information))}"
        homework = next((k for k in steps if chi[k] ** 0.5 <= 1e-6 * chi[0]), None)
        absolute = next((k for k in steps if abs(chi[k - 1] - chi[k]) < 1e-5), None)
        relative = next(k for k in steps if chi[k - 1] - chi[k] <= 1e-6 * chi[k - 1])
        facts |= {f"{name}.homework": str(homework or "–"), f"{name}.absolute": str(absolute or "–"),
                  f"{name}.relative": str(relative), f"{name}.w": scientific(information, 1, shortest=False)}
    return facts


def step_facts(tables):
    return {"newton": tables("solver_paths", algorithm="gauss-newton")}


def weight_facts(tables):
    """What the prior's weight does to the course's scene."""
    return {"chapter": Chapter(tables), "trials": tables("prior_trials", variant="perturbed"),
            "sweep": tables("prior_sweep", variant="perturbed"),
            "minimal": tables("prior_sweep", variant="minimal")["reprojection_cost"]}


facts = gathered(schur_facts, pcg_facts, rule_facts, half_facts, stop_facts, step_facts, weight_facts)
