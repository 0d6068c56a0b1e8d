"""Every number of the deck, by name: from the tables of ./course plots gauge, the sources, or the examples of toy.py."""

import re
from pathlib import Path

from ch5_backend.figures import gauge_paper
from ..tex import matrix, scientific, tex

from . import toy
from .plots import ZERO, error_ratio, mean, over_weight, relative_spectrum, table, usual

ROOT = Path(__file__).resolve().parents[2]
ERRORS = ("position_m", "rotation_deg", "velocity_m_s")


def power(weight):
    """A weight of the sweep, 10⁵."""
    return f"${scientific(weight, 1, shortest=weight < 1e3)}$"


def scene_facts(tables):
    header = (ROOT / "ch5_backend/simulate/visual_inertial_ba.h").read_text(encoding="utf-8")
    value = lambda name: re.search(rf"{name} = ([\d.]+);", header)[1]  # noqa: E731
    focal, rate = re.search(r"f = (\d+) px.*?IMU of (\d+) Hz", header).groups()
    return {"scene.keyframes": value("keyframes"), "scene.points": value("num_points"), "scene.focal": focal,
            "scene.pixel": f"{float(value('pixel_sigma')):g}", "scene.imu": rate}


def zeros_facts(tables):
    facts = {}
    for name, problem in (("imu", "camera and IMU"), ("camera", "camera alone")):
        values = relative_spectrum(tables, problem)
        zeros = sum(value < ZERO for value in values)
        facts.update({f"zeros.{name}": str(zeros), f"zeros.{name}_largest": scientific(values[zeros - 1], 1),
                      f"zeros.{name}_next": scientific(values[zeros], 1)})
    return facts


def toy_facts(tables):
    H, U, free, V, Q, fixed = toy.two_numbers()
    return {"hand.sigma": str(toy.SIGMA), "hand.H": matrix(H, tex), "hand.U": matrix(U, tex), "hand.free": matrix(free, tex),
            "hand.V": matrix(toy.transpose(V), tex), "hand.Q": matrix(Q, tex), "hand.fixed": matrix(fixed, tex),
            "hand.difference_free": tex(toy.difference_variance(free)),
            "hand.difference_fixed": tex(toy.difference_variance(fixed)),
            "tilt.step": str(toy.TILT), "tilt.yaw": f"{abs(toy.tilted_yaw()):.2f}",
            "creep.steps": str(len(toy.walk(toy.WEAK)) - 1), "creep.free": str(len(toy.walk(0.0)) - 1)}


def of_method(tables, scene, method, column):
    return tables.column(table("methods"), column, path=scene[0], points=scene[1], method=method)


def difference(tables, scene, method, column):
    """Largest |error / fixation's − 1| over the trials."""
    both = zip(of_method(tables, scene, method, column), of_method(tables, scene, "fixation", column))
    return max(abs(one / other - 1) for one, other in both)


def method_facts(tables):
    facts, extra, equal = {}, {}, []
    for scene in gauge_paper.SCENES:
        name, paper = "rmse." + "_".join(scene), gauge_paper.RMSE[scene]
        facts.update({f"{name}.fixation": f"{mean(of_method(tables, scene, 'fixation', 'position_m')):.4f}",
                      f"{name}.paper": f"{paper['fixation'][0]:.5f}, {paper['free'][0]:.5f} m"})
        for method in ("prior", "free"):
            facts[f"{name}.{method}"] = scientific(difference(tables, scene, method, "position_m"), 1)
        pairs = list(zip(of_method(tables, scene, "free", "iterations"), of_method(tables, scene, "fixation", "iterations")))
        extra[scene] = mean([one - other for one, other in pairs])
        equal += [one == other for one, other in pairs]
    worst = lambda method, columns: max(  # noqa: E731
        difference(tables, scene, method, column) for scene in gauge_paper.SCENES for column in columns)
    facts.update({"methods.trials": str(len(of_method(tables, gauge_paper.SCENES[0], "free", "iterations"))),
                  "methods.weight": power(gauge_paper.RECOMMENDED), "methods.prior": scientific(worst("prior", ERRORS), 1),
                  "methods.free": scientific(worst("free", ERRORS), 1),
                  "methods.usual": scientific(worst("prior", ("usual_position_m",)), 1, shortest=False),
                  "methods.saved": f"{-min(extra.values()):.2f}", "methods.more": f"{max(extra.values()):.2f}",
                  "methods.as_many": f"{mean(equal):.0%}"})
    return facts


def sweep_facts(tables):
    weights, found = over_weight(tables, "sweep", "iterations", path="sine", points="planes")
    paper = max(gauge_paper.SWEEP, key=gauge_paper.SWEEP.get)
    facts = {"sweep.zero": f"{found[0]:.1f}", "sweep.peak": f"{max(found):.1f}",
             "sweep.peak_weight": f"{weights[found.index(max(found))]:g}",
             "sweep.recommended": f"{found[weights.index(gauge_paper.RECOMMENDED)]:.1f}",
             "sweep.recommended_weight": power(gauge_paper.RECOMMENDED),
             "sweep.paper_peak": str(gauge_paper.SWEEP[paper]), "sweep.paper_weight": str(paper)}
    arrived, last = {}, {}
    for row in tables.rows(table("convergence")):
        last.setdefault((row["weight"], row["trial"]), []).append(row["reprojection_px"])
    for (weight, _), pixels in last.items():
        arrived.setdefault(weight, []).append((next(k for k, px in enumerate(pixels) if px < 1.05 * pixels[-1]),
                                               len(pixels) - 1))
    means = {weight: [mean(values) for values in zip(*pairs)] for weight, pairs in arrived.items()}
    facts.update({"arrival.pixels": f"{max(pixels for pixels, _ in means.values()):.1f}", "arrival.weight": "100",
                  "arrival.last": f"{means[100.0][1]:.1f}", "arrival.strong_weight": power(1e5),
                  "arrival.strong_last": f"{means[1e5][1]:.1f}"})
    return facts


def choice_facts(tables):
    curves = {name: over_weight(tables, "prior_choice", "iterations", **usual(damping=name))
              for name in ("identity", "diagonal", "radius")}
    weights = curves["diagonal"][0]
    facts = {f"damping.{name}": f"{found[-1]:.1f}" for name, (_, found) in curves.items()}
    # Right of the peak, where no damping needs 5 % more than its fewest there (ch5_backend/figures/gauge_choice.py).
    right = [k for k, weight in enumerate(weights) if weight >= 100]
    good = [weights[k] for k in right
            if all(found[k] <= 1.05 * min(found[i] for i in right) for _, found in curves.values())]
    at = weights.index(1e5)
    for name, place in (("gauge", "gauge"), ("pose", "pose 0"), ("poses", "poses 0 and 1")):
        facts[f"place.{name}"] = f"{error_ratio(tables, place)[1][at]:.2f}"
    moved = max(abs(ratio - 1) for ratio in error_ratio(tables, "gauge")[1])
    facts.update({"damping.heaviest": power(weights[-1]), "place.weight": power(1e5), "place.twelve": "12",
                  "place.freedoms": "4", "choice.low": power(min(good)), "choice.high": power(max(good)),
                  "choice.moved": f"{moved:.1%}"})
    return facts


def covariance_facts(tables):
    sigma = {name: tables.column(table("deviations"), "position_m", gauge=name) for name in ("fixed", "free")}
    column = lambda name: tables.column(table("covariance"), name)  # noqa: E731
    least = min(column("free_untransformed") + column("fixed_untransformed"))
    return {"sigma.fixed_last": f"{100 * sigma['fixed'][-1]:.1f}", "sigma.free_least": f"{100 * min(sigma['free']):.1f}",
            "cov.untransformed": f"{least:.0%}", "cov.free_to_fixed": scientific(max(column("free_to_fixed")), 1),
            "cov.fixed_to_free": scientific(max(column("fixed_to_free")), 1),
            "cov.paper": f"{100 * gauge_paper.COVARIANCE_DISTANCE:.2g} %"}


def recording_facts(tables):
    """Out of the model answer, which holds them with their source: the recording is not part of the repository."""
    answer = (ROOT / "solutions/gauge_freedom.md").read_text(encoding="utf-8")
    cited = dict(re.findall(r"<!-- recordings; euroc_v1_01_easy([^>]*?); [.\w%]+ -->([^<]+)<!-- -->", answer))
    facts = {"real.recording": "EuRoC V1_01", "real.trials": cited["; trials"], "real.paper_fixation": f"{gauge_paper.EUROC['fixation'][0]:.4f}",
             "real.paper_free": f"{gauge_paper.EUROC['free'][0]:.4f}"}
    for method in ("fixation", "free"):
        facts[f"real.{method}_position"] = cited[f" {method}; median position_m"]
        facts[f"real.{method}_iterations"] = cited[f" {method}; median iterations"]
    return facts


def all_facts(tables):
    facts = {}
    for part in (scene_facts, zeros_facts, toy_facts, method_facts, sweep_facts, choice_facts, covariance_facts,
                 recording_facts):
        facts.update(part(tables))
    return facts
