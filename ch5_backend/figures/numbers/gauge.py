"""The gauge paper's experiments: table → the numbers that their page, the fourth deck, the model answer of stage 4 and
the tests cite."""
from pathlib import Path

import numpy as np

from ..tables import TableError, read, write
from . import gauge_paper

STARTS = ("stated", "rotations nearer", "all nearer")
NOISY = "more noise"
UNKNOWN = ("stated", "less damping", "earlier stop", *STARTS[1:])  # what the paper leaves open, beside the place of w
VARIANTS = ("as shown", "two views", "few points", "more noise")
READINGS = {"the cost": 1, "the residual": 2}  # what the paper's w may multiply: w ‖r‖², or ‖w r‖²
METHODS = ("fixation", "free", "prior", "pseudo-inverse")
ERRORS = ("position_m", "rotation_deg", "velocity_m_s")
RECORDINGS = ("euroc_v1_01_easy", "tango_walk")
ZERO = 1e-8  # of the largest eigenvalue: below, it is rounding
FACTORS = {  # of prior_choice; the first value of each is the usual one
    "damping": ("diagonal", "identity", "radius"), "stop": ("relative", "absolute"), "start": ("perturbed", "truth"),
    "place": ("gauge", "pose 0", "poses 0 and 1")}


def of_scene(table, scene):
    return table.where(path=scene[0], points=scene[1])


def differences(table, column, method, scenes=gauge_paper.SCENES):
    """|error of the method / that of fixation − 1|, a value a trial and scene."""
    both = [np.concatenate([of_scene(table, scene).where(method=name)[column] for scene in scenes])
            for name in (method, "fixation")]
    return np.abs(both[0] / both[1] - 1)


def over_weight(table, column):
    """Weights, means and standard deviations over the trials."""
    weights = np.unique(table["weight"])
    found = [table.where(weight=weight)[column] for weight in weights]
    return weights, np.array([np.mean(values) for values in found]), np.array([np.std(values) for values in found])


def usual(table, **changes):
    """The rows in which nothing but `changes` differs from the usual values."""
    return table.where(**{**{factor: values[0] for factor, values in FACTORS.items()}, **changes})


def as_the_paper(weights, mean, power):
    """The paper's weights and its iterations, and ours where the cost has w to this power, between our weights."""
    theirs = {weight: iterations for weight, iterations in gauge_paper.SWEEP.items() if weight > 0}
    ours = np.interp(power * np.log(list(theirs)), np.log(weights[weights > 0]), mean[weights > 0])
    return np.array(list(theirs)), np.array(list(theirs.values())), ours


def gap(weights, mean, power, least):
    """Root mean square of ours − the paper's iterations, at the paper's weights from `least` on."""
    at, theirs, ours = as_the_paper(weights, mean, power)
    return np.sqrt(np.mean((ours - theirs)[at >= least]**2))


def right_weights(table):
    """(least, greatest) weight right of the peak at which no damping needs 5 % more than its fewest there."""
    good = None
    for damping in FACTORS["damping"]:
        weights, mean, _ = over_weight(usual(table, damping=damping), "iterations")
        right = weights >= 100
        near = right & (mean <= 1.05 * mean[right].min())
        good = near if good is None else good & near
    if not good.any():
        raise TableError("prior_choice: no weight suits all dampings")
    return weights[good].min(), weights[good].max()


def error_ratio(table, place, start="perturbed"):
    """Weights, and the mean error of the position at each next to that without a prior."""
    weights, mean, _ = over_weight(usual(table, place=place, start=start), "position_m")
    return weights, mean / mean[weights == 0]


def relative_spectrum(table, problem):
    """|λ| / λ_max, ascending; what rounds to 0 has a place at 1e-20."""
    values = table.where(problem=problem)["eigenvalue"]
    return np.sort(np.maximum(np.abs(values) / values.max(), 1e-20))


def methods(table):
    """{(of, what): value}; `of` names a scene and a method."""
    found, extra = {}, []
    for scene in gauge_paper.SCENES:
        rows = of_scene(table, scene)
        of_method = {method: rows.where(method=method) for method in METHODS}
        for method, own in of_method.items():
            for what in ("iterations", *ERRORS):
                found[f"{scene[0]} {scene[1]} {method}", f"mean {what}"] = own[what].mean()
            found[f"{scene[0]} {scene[1]} {method}", "median milliseconds an iteration"] = np.median(
                own["milliseconds"] / own["iterations"])
        extra.append(of_method["free"]["iterations"] - of_method["fixation"]["iterations"])
        found[" ".join(scene), "mean iterations of free − fixation"] = extra[-1].mean()
    extra = np.concatenate(extra)
    for what, share in (("fewer", extra < 0), ("as many", extra == 0), ("more", extra > 0)):
        found["all scenes", f"share of trials in which free needs {what} iterations"] = share.mean()
    for method in ("prior", "free", "pseudo-inverse"):
        worst = max(differences(table, column, method).max() for column in ERRORS)
        found[f"{method} and fixation", "largest relative difference of an RMSE at convergence"] = worst
        worst = differences(table, "usual_position_m", method).max()
        found[f"{method} and fixation", "largest relative difference of the position's RMSE at the usual stop"] = worst
    found["all scenes", "trials"] = len(np.unique(table["trial"]))
    return found


def sweep(table):
    found = {}
    for scene in gauge_paper.SCENES:
        weights, mean, _ = over_weight(of_scene(table, scene), "iterations")
        at = mean.argmax()
        for what, value in (("weight of the peak", weights[at]), ("iterations at the peak", mean[at]),
                            ("iterations at 0", mean[0]), ("iterations at the greatest weight", mean[-1]),
                            ("iterations at the recommended weight", mean[weights == gauge_paper.RECOMMENDED][0]),
                            ("peak / greater end", mean[at] / max(mean[0], mean[-1]))):
            found[" ".join(scene), what] = value
    return found


def near_start(table):
    """How far our sweep is from the paper's, by start and by what the paper's w multiplies."""
    found = {}
    for start in (*UNKNOWN, NOISY):
        rows = table.where(start=start)
        weights, mean, _ = over_weight(rows, "iterations")
        found[start, "mean first reprojection error [px]"] = rows.where(weight=0)["start_px"].mean()
        found[start, "iterations at 0"], found[start, "iterations at 3"] = mean[0], mean[weights == 3][0]
        for reading, power in READINGS.items():
            for least in (3, 7):
                found[start, f"gap from w = {least} on if w multiplies {reading}"] = gap(weights, mean, power, least)
    return found


def variants(table):
    """Table II and Fig. 7 with other scenes: whose error is greatest, and what the free gauge saves."""
    found = {}
    for variant in VARIANTS:
        for path, points in gauge_paper.SCENES:
            rows, of = of_scene(table, (path, points)).where(variant=variant), f"{variant}, {path} {points}"
            for column in ("seen_per_keyframe", *ERRORS, *(f"{method}_iterations" for method in METHODS[:3])):
                found[of, f"mean {column}"] = rows[column].mean()
        for points in ("planes", "random"):
            turned = {path: found[f"{variant}, {path} {points}", "mean rotation_deg"] for path in ("sine", "arc", "rec")}
            found[f"{variant}, {points}", "arc's rotation error / the next"] = turned.pop("arc") / max(turned.values())
    return found


def convergence(table):
    """When the reprojection error has arrived, and how far the prior error is then from its greatest."""
    found = {}
    for weight in np.unique(table["weight"]):
        arrived, left, last = [], [], []
        for trial in np.unique(table["trial"]):
            rows = table.where(weight=weight, trial=trial)
            pixels, prior = rows["reprojection_px"], rows["prior_error"]
            arrived.append(int(np.argmax(pixels < 1.05 * pixels[-1])))
            left.append(prior[arrived[-1]] / prior.max())
            last.append(len(prior) - 1)
        found[f"w = {weight:g}", "mean iteration at which the reprojection error is within 5 %"] = np.mean(arrived)
        found[f"w = {weight:g}", "mean prior error left then, of its greatest"] = np.mean(left)
        found[f"w = {weight:g}", "mean last iteration"] = np.mean(last)
    strong = table.where(weight=gauge_paper.RECOMMENDED)
    last = [strong.where(trial=trial)["reprojection_px"][-1] for trial in np.unique(table["trial"])]
    found["start", "mean reprojection error [px]"] = strong.where(iteration=0)["reprojection_px"].mean()
    found["end", "mean reprojection error [px]"] = np.mean(last)
    return found


def spectrum(table):
    found = {}
    for problem in ("camera and IMU", "camera alone"):
        values = relative_spectrum(table, problem)
        zeros = int((values < ZERO).sum())
        found |= {(problem, "zero eigenvalues"): zeros, (problem, "greatest zero / greatest"): values[zeros - 1],
                  (problem, "least other / greatest"): values[zeros]}
    return found


def covariance(table):
    return {(column.replace("_", " "), f"{what} relative Frobenius distance"): value(table[column])
            for column in ("free_untransformed", "fixed_untransformed", "free_to_fixed", "fixed_to_free")
            for what, value in (("least", np.min), ("mean", np.mean), ("largest", np.max))}


def deviations(table):
    return {(gauge, f"{what} [m]"): value(table.where(gauge=gauge)["position_m"]) for gauge in ("fixed", "free")
            for what, value in (("σ of the first position", lambda sigmas: sigmas[0]), ("σ of the last position", lambda sigmas: sigmas[-1]),
                                ("least σ of a position", np.min))}


def prior_choice(table):
    low, high = right_weights(table)
    found = {("any damping", "least right weight"): low, ("any damping", "greatest right weight"): high}
    for factor, values in FACTORS.items():
        for value in values:
            weights, mean, _ = over_weight(usual(table, **{factor: value}), "iterations")
            for what, iterations in (("at 0", mean[0]), ("at 10⁵", mean[weights == 1e5][0]), ("at 10¹⁰", mean[-1]),
                                     ("at the peak", mean[weights > 0].max())):
                found[f"{factor} {value}", f"iterations {what}"] = iterations
            found[f"{factor} {value}", "weight of the peak"] = weights[1:][mean[1:].argmax()]
    for start in FACTORS["start"]:
        for place in FACTORS["place"]:
            weights, ratio = error_ratio(table, place, start)
            for what, value in (("at 10⁵", ratio[weights == 1e5][0]), ("at 10¹⁰", ratio[-1]),
                                ("farthest from 1", ratio[np.abs(ratio - 1).argmax()])):
                found[f"{place}, {start}", f"error / that without a prior {what}"] = value
    return found


def audit(table):
    """What each part of H claims to know of each direction, at most over the flight: ‖P⁻¹Hn‖/‖Pn‖ and nᵀHn."""
    keys = ("policy", "constraints", "part", "direction")
    return {(" ".join(case[:3]), f"largest {what} {case[3]}"): np.abs(table.where(**dict(zip(keys, case)))[what]).max()
            for case in sorted(set(zip(*map(table.__getitem__, keys)))) for what in ("relative", "information")}


def recordings(table):
    found = {}
    for recording in RECORDINGS:
        for method in ("fixation", "free", "prior"):
            rows = table.where(recording=recording, method=method)
            for what in ("iterations", "milliseconds", *ERRORS, "reprojection_px"):
                found[f"{recording} {method}", f"median {what}"] = np.median(rows[what])
        one, other = (table.where(recording=recording, method=m)["position_m"] for m in ("fixation", "free"))
        found[recording, "share of trials whose fixed and free position errors agree to 1 %"] = np.mean(
            np.abs(other / one - 1) < 0.01)
        found[recording, "trials"] = len(one)
    return found


STUDIES = {function.__name__: function for function in
           (methods, sweep, near_start, variants, convergence, spectrum, covariance, deviations, prior_choice, audit, recordings)}


def numbers(directory):
    """{study: {(of, what): value}} of each table that is there."""
    return {name: study(read(directory, name)) for name, study in STUDIES.items()
            if (Path(directory) / "csv" / f"{name}.csv").exists()}


def write_summary(path, found):
    write(path, ("study", "of", "what", "value"), ((study, of, what, f"{value:.6g}") for study, values in found.items()
                                                   for (of, what), value in values.items()))
