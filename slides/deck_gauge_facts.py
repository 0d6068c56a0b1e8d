"""Every number of the deck, by name: from the tables of ./course plots gauge, the sources, or the examples of gauge_examples.py."""

import re

from ch5_backend.figures.numbers import gauge, gauge_paper
from ch5_backend.figures.style import percent
from ch5_backend.figures.tables import TableError

from . import gauge_examples as toy
from .facts import ROOT, gathered, typed_in
from .tex import matrix, power, scientific, tex


def scene_facts(tables):
    header = "ch5_backend/simulate/sensors/visual_inertial_ba.h"
    value = lambda name: typed_in(header, rf"{name} = ([\d.]+);")  # noqa: E731
    focal, rate = typed_in(header, r"f = (\d+) px.*?IMU of (\d+) Hz")
    return {"scene.keyframes": value("keyframes"), "scene.points": value("num_points"), "scene.focal": focal,
            "scene.pixel": f"{float(value('pixel_sigma')):g}", "scene.imu": rate}


def toy_facts(tables):
    H, U, free, V, Q, fixed = toy.two_numbers()
    return {"hand.sigma": str(toy.SIGMA), "hand.H": matrix(H, tex), "hand.U": matrix(U, tex), "hand.free": matrix(free, tex),
            "hand.V": matrix(V.T, tex), "hand.Q": matrix(Q, tex), "hand.fixed": matrix(fixed, tex),
            "hand.difference_free": tex(toy.difference_variance(free)),
            "hand.difference_fixed": tex(toy.difference_variance(fixed)),
            "tilt.step": str(toy.TILT), "tilt.yaw": f"{abs(toy.tilted_yaw()):.2f}",
            "creep.steps": str(len(toy.walk(toy.WEAK)) - 1), "creep.free": str(len(toy.walk(0.0)) - 1)}


def cited_facts(tables):
    """What the page of the experiments cites too, and the paper's own."""
    found = gauge.numbers(tables.folder.parent / "gauge")
    if missing := {"methods", "sweep", "near_start", "variants", "convergence", "spectrum", "covariance", "deviations", "prior_choice"} - found.keys():
        raise TableError(f"{tables.folder.parent / 'gauge'}: tables of {', '.join(sorted(missing))} are missing; run ./course plots gauge first")
    facts = dict(found)
    methods = tables("../gauge/csv/methods")
    for scene in gauge_paper.SCENES:
        name, paper = "rmse." + "_".join(scene), gauge_paper.RMSE[scene]
        facts[f"{name}.paper"] = f"{paper['fixation'][0]:.5f}, {paper['free'][0]:.5f} m"
        for method in ("prior", "free"):
            facts[f"{name}.{method}"] = scientific(gauge.differences(methods, "position_m", method, [scene]).max(), 1)
    extra = [found["methods"][" ".join(scene), "mean iterations of free − fixation"] for scene in gauge_paper.SCENES]
    pixels = [value for (_, what), value in found["convergence"].items() if what.endswith("is within 5 %")]
    paper = max(gauge_paper.SWEEP, key=gauge_paper.SWEEP.get)
    untransformed = min(found["covariance"][f"{name} untransformed", "least relative Frobenius distance"]
                        for name in ("free", "fixed"))
    return {**facts, "methods.saved": f"{-min(extra):.2f}", "methods.more": f"{max(extra):.2f}",
            "methods.weight": power(gauge_paper.RECOMMENDED), "sweep.recommended_weight": power(gauge_paper.RECOMMENDED),
            "sweep.paper_peak": str(gauge_paper.SWEEP[paper]), "sweep.paper_weight": str(paper),
            "arrival.pixels": f"{max(pixels):.1f}", "arrival.weight": "100", "arrival.strong_weight": power(1e5),
            "damping.heaviest": power(tables("../gauge/csv/prior_choice")["weight"].max()), "place.weight": power(1e5),
            "place.twelve": "12", "place.freedoms": "4", "cov.untransformed": percent(untransformed),
            "cov.paper": percent(gauge_paper.COVARIANCE_DISTANCE, 2)}


def reading_facts(tables):
    """Whose weight the paper's is, what its start is, and what is selected."""
    folder = tables.folder.parent / "gauge"
    found = gauge.numbers(folder)
    variants, methods = found["variants"], found["methods"]
    scenes = list(map(" ".join, gauge_paper.SCENES))
    step = lambda scene, method: methods[f"{scene} {method}", "median milliseconds an iteration"]  # noqa: E731
    longer = [step(scene, "fixation") / step(scene, "free") - 1 for scene in scenes]
    turned = [value for (_, what), value in variants.items() if what.startswith("arc's rotation")]
    mean = lambda variant: "/".join(  # noqa: E731
        f"{variants[f'{variant}, rec planes', f'mean {method}_iterations']:.1f}" for method in gauge.METHODS[:3])
    return {"start.paper": f"{gauge_paper.FIRST_PIXELS}", "readings.least": "7", "readings.noise": "4.5", "readings.tau": "5·10⁻⁶", "readings.tolerance": "10⁻⁵", "time.least": percent(min(longer)),
            "time.most": percent(max(longer)), "views.two": "2", "views.four": "4", "views.rec_two": mean("two views"),
            "views.rec_four": mean("as shown"), "variants.least": f"{min(turned):.1f}", "variants.most": f"{max(turned):.1f}"}


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


facts = gathered(scene_facts, toy_facts, cited_facts, reading_facts, recording_facts)
