"""The numbers of the gauge experiments' page that its words do not ask the tables for themselves, as they span several scenes."""
from .numbers import gauge_paper
from .numbers.gauge import VARIANTS
from .style import number, percent


def methods(n, say):
    extra = [n[f"{path} {points}", "mean iterations of free − fixation"] for path, points in gauge_paper.SCENES]
    more = [say("gauge.extra", scene=say("list").join(say(f"gauge.{one}") for one in scene), more=f"{value:.2f}")
            for scene, value in zip(gauge_paper.SCENES, extra) if value > 0]
    share = lambda what: percent(n["all scenes", f"share of trials in which free needs {what} iterations"])
    a_step = lambda method: [n[f"{path} {points} {method}", "median milliseconds an iteration"]
                             for path, points in gauge_paper.SCENES]
    faster = [100 * (fixed / free - 1) for fixed, free in zip(a_step("fixation"), a_step("free"))]
    return dict(trials=f"{n['all scenes', 'trials']:.0f}", fewer=share("fewer"), more=share("more"), saved=f"{-min(extra):.2f}",
                verdict=say("gauge_methods.but", scenes=say("list").join(more)) if more else say("gauge_methods.as"),
                low=f"{min(faster):.0f}", high=f"{max(faster):.0f}")


def sweep(n, say):
    values = lambda what: [n[f"{path} {points}", what] for path, points in gauge_paper.SCENES]
    span = lambda what: say("span", low=f"{min(values(what)):.1f}", high=f"{max(values(what)):.1f}")
    peaks = sorted({f"{weight:g}" for weight in values("weight of the peak")}, key=float)
    most = max(gauge_paper.SWEEP, key=gauge_paper.SWEEP.get)
    return dict(free=span("iterations at 0"), peak=span("iterations at the peak"), weights=say("list").join(peaks),
                recommended=span("iterations at the recommended weight"), most=gauge_paper.SWEEP[most], at=f"{most:g}")


def variants(n, say):
    times = [n[f"{variant}, {points}", "arc's rotation error / the next"]
             for variant in VARIANTS for points in ("planes", "random")]
    its = lambda of: "/".join(f"{n[of, f'mean {method}_iterations']:.1f}" for method in ("fixation", "free", "prior"))
    return dict(low=f"{min(times):.1f}", high=f"{max(times):.1f}", two=its("two views, rec planes"), four=its("as shown, rec planes"))


def audit(n, say):
    known = lambda constraints, part, direction: max(
        n[f"{policy} {constraints} {part}", f"largest relative {direction}"] for policy in ("vins", "okvis"))
    free = max(known(constraints, "measurements", direction) for constraints in ("none", "marginalized edges")
               for direction in ("x", "y", "z", "yaw"))
    yaw = lambda constraints, part: number(known(constraints, part, "yaw"), 2)
    return dict(free=number(free, 1), prior=yaw("none", "prior"), clean=yaw("marginalized edges", "prior"),
                window=yaw("none", "window"), constrained=yaw("marginalized edges", "window"))


OF_SCENES = {"gauge_methods": methods, "gauge_sweep": sweep, "gauge_variants": variants, "gauge_audit": audit}  # each of the study of its name


def caption(name, found, say):
    """What stands below a figure or above a table, of the studies that are there."""
    if name == "gauge_matrices" and "covariance" not in found:
        return say("gauge_matrices.alone")
    of_scenes = OF_SCENES[name](found[name.removeprefix("gauge_")], say) if name in OF_SCENES else {}
    return say(name, paper=gauge_paper, **found | of_scenes)
