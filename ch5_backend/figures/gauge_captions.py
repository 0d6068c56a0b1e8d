"""The words of the gauge experiments' page, with every number taken from the tables: what matches the paper, and why the
rest differs."""
from .numbers import gauge_paper
from .numbers.gauge import VARIANTS
from .style import number, percent


def methods(n, say):
    extra = [n[f"{path} {points}", "mean iterations of free − fixation"] for path, points in gauge_paper.SCENES]
    more = [say("gauge.extra", scene=scene_name(say, scene), more=f"{value:.2f}")
            for scene, value in zip(gauge_paper.SCENES, extra) if value > 0]
    share = lambda what: percent(n["all scenes", f"share of trials in which free needs {what} iterations"])
    worst = lambda method, where: number(n[f"{method} and fixation", where], 2)
    tight = "largest relative difference of an RMSE at convergence"
    usual = "largest relative difference of the position's RMSE at the usual stop"
    a_step = lambda method: [n[f"{path} {points} {method}", "median milliseconds an iteration"]
                             for path, points in gauge_paper.SCENES]
    faster = [100 * (fixed / free - 1) for fixed, free in zip(a_step("fixation"), a_step("free"))]
    return {
        "gauge_methods": say(
            "gauge_methods", trials=f"{n['all scenes', 'trials']:.0f}", fewer=share("fewer"), more=share("more"), saved=f"{-min(extra):.2f}",
            verdict=say("gauge_methods.but", scenes=say("list").join(more)) if more else say("gauge_methods.as"),
            low=f"{min(faster):.0f}", high=f"{max(faster):.0f}"),
        "gauge_errors": say("gauge_errors", prior=worst("prior", tight), free=worst("free", tight), prior_usual=worst("prior", usual),
                            free_usual=worst("free", usual))}


def scene_name(say, scene):
    path, points = scene
    return say("list").join((say(f"gauge.{path}"), say(f"gauge.{points}")))


def sweep(n, say):
    values = lambda what: [n[f"{path} {points}", what] for path, points in gauge_paper.SCENES]
    span = lambda what: say("span", low=f"{min(values(what)):.1f}", high=f"{max(values(what)):.1f}")
    peaks = sorted({f"{weight:g}" for weight in values("weight of the peak")}, key=float)
    most = max(gauge_paper.SWEEP, key=gauge_paper.SWEEP.get)
    return {"gauge_sweep": say("gauge_sweep", free=span("iterations at 0"), peak=span("iterations at the peak"), weights=say("list").join(peaks),
                               recommended=span("iterations at the recommended weight"), most=gauge_paper.SWEEP[most], at=f"{most:g}")}


def near_start(n, say):
    gap = lambda start, reading: f"{n[start, f'gap from w = 7 on if w multiplies the {reading}']:.1f}"
    pixels = lambda start: f"{n[start, 'mean first reprojection error [px]']:.1f}"
    at = lambda start: f"{n[start, 'iterations at 3']:.1f}"
    return {"gauge_readings": say(
        "gauge_readings", stated=gap("stated", "cost"), noisy=gap("more noise", "cost"), residual=gap("stated", "residual"),
        paper=gauge_paper.SWEEP[3], ours=at("stated"), pixels=pixels("stated"), rotations_px=pixels("rotations nearer"),
        all_px=pixels("all nearer"), rotations_at=at("rotations nearer"), all_at=at("all nearer"),
        rotations_cost=gap("rotations nearer", "cost"), rotations_residual=gap("rotations nearer", "residual"),
        all_cost=gap("all nearer", "cost"), all_residual=gap("all nearer", "residual"))}


def variants(n, say):
    times = [n[f"{variant}, {points}", "arc's rotation error / the next"]
             for variant in VARIANTS for points in ("planes", "random")]
    its = lambda of: "/".join(f"{n[of, f'mean {method}_iterations']:.1f}" for method in ("fixation", "free", "prior"))
    return {"gauge_variants": say("gauge_variants", low=f"{min(times):.1f}", high=f"{max(times):.1f}",
                                  two=its("two views, rec planes"), four=its("as shown, rec planes"))}


def convergence(n, say):
    tell = lambda w: (f"{n[f'w = {w}', 'mean iteration at which the reprojection error is within 5 %']:.1f}",
                      percent(n[f"w = {w}", "mean prior error left then, of its greatest"]), f"{n[f'w = {w}', 'mean last iteration']:.1f}")
    pixels = lambda when: number(n[when, "mean reprojection error [px]"])
    within, left, end = tell("100")
    return {"gauge_convergence": say("gauge_convergence", start=pixels("start"), last=pixels("end"), within=within, left=left, end=end,
                                     strong=tell("100000")[2])}


def spectrum(n, say):
    tell = lambda problem: say("gauge_spectrum.zeros", count=f"{n[problem, 'zero eigenvalues']:.0f}",
                               zero=number(n[problem, "greatest zero / greatest"], 1), next=number(n[problem, "least other / greatest"], 2))
    return {"gauge_spectrum": say("gauge_spectrum", both=tell("camera and IMU"), camera=tell("camera alone"))}


def covariance(n, say):
    worst = lambda of: number(n[of, "largest relative Frobenius distance"], 2)
    return {"gauge_matrices": say(
        "gauge_matrices", apart=percent(n["free untransformed", "mean relative Frobenius distance"]), there=worst("free to fixed"),
        back=worst("fixed to free"), paper=number(100 * gauge_paper.COVARIANCE_DISTANCE, 2))}


def deviations(n, say):
    sigma = lambda gauge, which: number(100 * n[gauge, f"{which} [m]"], 2)
    return {"gauge_deviations": say("gauge_deviations", first=sigma("fixed", "σ of the first position"),
                                    last=sigma("fixed", "σ of the last position"), least=sigma("free", "least σ of a position"))}


def prior_choice(n, say):
    its = lambda of, what: f"{n[of, f'iterations {what}']:.1f}"
    times = lambda of: number(n[of, "error / that without a prior at 10¹⁰"], 2)
    moved = 100 * abs(n["gauge, perturbed", "error / that without a prior farthest from 1"] - 1)
    return {"gauge_prior_choice": say(
        "gauge_prior_choice", diagonal=its("damping diagonal", "at the peak"), radius=its("damping radius", "at the peak"),
        identity=its("damping identity", "at 10¹⁰"), absolute=its("stop absolute", "at the peak"),
        weight=f"{n['stop absolute', 'weight of the peak']:g}", moved=number(moved, 1), pose=times("pose 0, perturbed"),
        poses=times("poses 0 and 1, perturbed"), truth=times("poses 0 and 1, truth"))}


def audit(n, say):
    known = lambda constraints, part, direction: max(
        n[f"{policy} {constraints} {part}", f"largest relative {direction}"] for policy in ("vins", "okvis"))
    free = max(known(constraints, "measurements", direction) for constraints in ("none", "marginalized edges")
               for direction in ("x", "y", "z", "yaw"))
    yaw = lambda constraints, part: number(known(constraints, part, "yaw"), 2)
    return {"gauge_audit": say("gauge_audit", free=number(free, 1), prior=yaw("none", "prior"), clean=yaw("marginalized edges", "prior"),
                               window=yaw("none", "window"), constrained=yaw("marginalized edges", "window"))}


def recordings(n, say):
    agree = lambda name: percent(n[name, "share of trials whose fixed and free position errors agree to 1 %"])
    its = lambda name: "/".join(f"{n[f'{name} {method}', 'median iterations']:g}" for method in ("fixation", "free", "prior"))
    return {"gauge_recordings": say("gauge_recordings", trials=f"{n['tango_walk', 'trials']:.0f}", euroc=its("euroc_v1_01_easy"),
                                    tango=its("tango_walk"), euroc_agree=agree("euroc_v1_01_easy"), tango_agree=agree("tango_walk"))}


def captions(found, say):
    """{figure: its words} of the studies that are there."""
    words = {}
    for name, of_study in found.items():
        words.update(globals()[name](of_study, say))
    words.setdefault("gauge_matrices", say("gauge_matrices.alone"))
    return words
