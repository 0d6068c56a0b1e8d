"""Every number of the deck, by name: from the kept tables, or Rodrigues' formula."""

from pathlib import Path

import numpy as np

from ch5_backend.figures.numbers.systems import rotation_by_sample
from ch5_backend.figures.numbers.windows import KEPT
from ch5_backend.figures.style import number, percent

from .facts import gathered, typed_in

FLIGHTS = ("ahead", "ahead with 100 tracks", "outward", "hand-held")

PHOTO = Path(__file__).parent / "photo.png"
PLACES = {"corner": "a corner", "edge": "an edge", "plain": "a plain surface"}
HALF, GRAY_SIGMA, DRAWN, LARGER = 10.5, 5.0, 3, 40  # of the patch's side [px]; noise of a gray value, assumed; how many σ, how much larger


def hat(a):
    return np.cross(a, np.eye(3)).T  # hat(a) b = a × b


def exp(theta):
    """The rotation matrix; theta is not zero."""
    angle, K = np.linalg.norm(theta), hat(theta)
    return np.eye(3) + np.sin(angle) / angle * K + (1 - np.cos(angle)) / angle**2 * K @ K


def right_jacobian(theta):
    angle, K = np.linalg.norm(theta), hat(theta)
    return np.eye(3) - (1 - np.cos(angle)) / angle**2 * K + (angle - np.sin(angle)) / angle**3 * K @ K


def eigenvalues(kind):
    """Of the first such place's H = Σ ∇I ∇Iᵀ, ascending, and their directions as columns."""
    rows = KEPT("corners", kind=kind)
    xx, xy, yy = (rows[name][0] for name in ("xx", "xy", "yy"))
    return np.linalg.eigh([[xx, xy], [xy, yy]])


def spread(kind):
    """The direction in which its place is least certain, and σ along it and across [px]: the roots of σ² H⁻¹'s eigenvalues."""
    values, directions = eigenvalues(kind)
    return directions[:, 0], GRAY_SIGMA / np.sqrt(values)


def short_number(value):
    return number(value, 2)


def paired(flights):
    """ATE with first estimates less that without, each flight; mean, its standard error, and the error were the flights not the same."""
    without, full = (KEPT("first_estimates", policy="vins", setting=one, recording=flights)["ate_m"] for one in ("none", "full"))
    error = lambda values: values.std(ddof=1) / len(values) ** 0.5  # noqa: E731
    return full - without, (full - without).mean(), error(full - without), np.hypot(error(full), error(without))


def calibrated(policy, quantity, at):
    """Mean and standard error over the flights, at the first (0) or last (-1) image of each."""
    rows = KEPT("calibration", policy=policy, quantity=quantity)
    errors = np.array([rows.where(trial=trial)["error"][at] for trial in np.unique(rows["trial"])])
    return f"{errors.mean():.2f} ± {errors.std(ddof=1) / len(errors) ** 0.5:.2f}"


def table_facts(_):
    return {"paired": paired, "flights": FLIGHTS, "calibrated": calibrated, "calibration": KEPT("calibration"), "walk": KEPT("walk_scale"),
            "corners": KEPT("corners", kind="corner"), "spread": spread, "gray_sigma": GRAY_SIGMA, "drawn": DRAWN, "larger": LARGER}


def imu_facts(_):
    rows = KEPT("preintegration")
    ratio = rows["claimed"] / rows["measured"]
    share = rotation_by_sample(KEPT)
    tuned, fast = 200, 1600
    draws = typed_in("ch5_backend/experiments/studies/systems/preintegration.cc", r"kDraws = (\d+)")
    return {"imu.draws": draws, "imu.worst": percent(np.abs(ratio - 1).max()),
            "imu.tuned": str(tuned), "imu.fast": str(fast), "imu.vins_tuned": percent(share[tuned]),
            "imu.vins_fast": percent(share[fast])}


facts = gathered(table_facts, imu_facts)
