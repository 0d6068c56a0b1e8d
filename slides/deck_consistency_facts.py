"""Every number of the deck, by name: from a table, or exact arithmetic on the examples of marginalization_examples.py."""

from math import degrees, sqrt

import numpy as np

from ch5_backend.figures.numbers.systems import WAYS
from ch5_backend.figures.numbers.windows import KEPT, consistency, kept_summary, leak
from ch5_backend.figures.style import percent
from ch5_backend.figures.systems import nees_of

from . import marginalization_examples as toy
from .facts import gathered, typed_in
from .tex import matrix, scientific, tex

RECORDED = "euroc_v1_01_easy"
REMEDIES = ("outliers beyond 1.5 px", "T_B_C and clock estimated")  # that explain little of a recording's NEES


def hand_facts(tables):
    J1, J2 = (toy.jacobian(point) for point in toy.POINTS)
    same, mixed = toy.two_tangents()
    point = lambda p: rf"({tex(p[0])},\, {tex(p[1])})"  # noqa: E731
    return {
        "product.value": str(toy.PRODUCT), "product.p1": point(toy.POINTS[0]), "product.p2": point(toy.POINTS[1]),
        "product.J1": matrix(J1, tex), "product.J2": matrix(J2, tex), "product.same": matrix(same, tex),
        "product.mixed": matrix(mixed, tex), "product.same_det": tex(toy.det(same)), "product.mixed_det": tex(toy.det(mixed)),
    }


def consistency_facts(tables):
    """`case` is the row of one case over all flights, see numbers/windows.py; `first` the first row over time."""
    return {"nees.dof": "6", "nees.band": percent(0.95), "yaw.dof": "1", "flown.tracks": "22", "flown.path": f"{KEPT('distance', recording=RECORDED)['path_m'][0]:.1f}",
            "nees.published_sigma": typed_in("ch5_backend/window/window.h", r"pixel_sigma = ([\d.]+)"), "case": kept_summary,
            "first": consistency(KEPT, "vins", "none").rows()[0]}


def leak_facts(tables):
    """What the priors of the longer flight claim."""
    facts, positions = {}, []
    for policy in ("vins", "okvis"):
        last = leak(tables("odometry_gauge"), policy)[-1]
        facts[f"leak.{policy}"] = f"{last:.0f}"
        facts[f"leak.{policy}_deg"] = f"{degrees(1 / sqrt(last)):.1f}"
        positions += [abs(one["information"]) for axis in "xyz"
                      for one in tables("odometry_gauge", policy=policy, direction=axis).rows()]
    return {**facts, "leak.position": f"${scientific(max(positions), 1)}$"}


def band_facts(_):
    """Where the mean NEES of a pose over n flights lies, by Wilson and Hilferty's approximation (evaluate/nees.h)."""
    facts = {}
    for k, flights in enumerate((1, 10, 50, 200), start=1):
        dof = 6 * flights
        low, high = (dof * (1 - 2 / (9 * dof) + z * sqrt(2 / (9 * dof))) ** 3 / flights for z in (-1.96, 1.96))
        facts.update({f"band.n{k}": str(flights), f"band.low{k}": f"{low:.1f}", f"band.high{k}": f"{high:.1f}"})
    return facts


def ablation_facts(_):
    """Medians over the flights; the time of an image by that of marginalizing, which is measured in the same run."""
    facts = {"recorded": lambda **case: KEPT("consistency_recording", recording=RECORDED).row(**case)["nees_motion"],
             "ablation.flights": str(len(np.unique(KEPT("ablation")["trial"])))}
    for policy in ("vins", "okvis"):
        usual = np.median(KEPT("ablation", policy=policy, way="marginalized")["milliseconds"])
        recorded = KEPT("consistency_recording", recording=RECORDED, policy=policy)
        facts[f"ablation.real_{policy}_helped"] = f"{min(recorded.row(setting=name)['nees_motion'] for name in REMEDIES):.0f}"
        for way in WAYS:
            rows, name = KEPT("ablation", policy=policy, way=way), f"ablation.{policy}_{way.replace(' ', '_')}"
            facts.update({f"{name}_ate": f"{np.nanmedian(rows['ate_m']):.2f}",
                          f"{name}_nees": nees_of(rows),
                          f"{name}_lost": percent((rows['restarts'] > 0).mean()),
                          f"{name}_time": f"{np.median(rows['milliseconds']) / usual:.1f} ×"})
    return facts


facts = gathered(hand_facts, consistency_facts, leak_facts, band_facts, ablation_facts)
