"""What the report says of the chapter's tables: a finding at its head for each section, and the words below each figure. All
numbers are from the tables; the sentences around them are in words/."""
from . import nees
from .numbers.chapter import Chapter
from .odometry import NAMES
from .style import number
from .tables import Tables

whole = "{:.0f}".format


def bundle_adjustment(n):
    small, large = n.solve("course"), n.solve("large")
    return {
        "scene_course": dict(frames=whole(small["frames"]), points=whole(small["points"]),
                             start=number(small["initial_rmse_landmark_m"]), iterations=whole(small["iterations"]),
                             end=number(1e3 * small["final_rmse_landmark_m"])),
        "scene_large": dict(frames=whole(large["frames"]), points=whole(large["points"]),
                            points_mm=number(1e3 * large["final_rmse_landmark_m"]),
                            cameras_mm=number(1e3 * large["final_rmse_position_m"])),
        "mono_ba_convergence": dict(first=number(large["initial_cost"]), last=number(large["final_cost"])),
    }


def the_hessian(n):
    large = n.solve("large")
    return {
        "hessian_course": {},
        "hessian_large": dict(frames=whole(large["frames"]), points=whole(large["points"])),
        "spectrum": dict(free=n.spectrum("free")[1], minimal=n.spectrum("minimal prior")[1]),
    }


def marginalization(n):
    fill = n.tables("marginalize_fill")
    before, after = fill.row(stage="before"), fill["null_dimension"][-1]
    return {
        "marginalize_chain": dict(shared=number(n.tables("marginalize_chain", stage="after")["value"][1], 6).replace("-", "−")),
        "marginalize_scene": dict(density=whole(100 * before["density"]), null=whole(after)),
    }


def the_priors_weight(n):
    rmse, cost = (n.ends("prior_sweep", column, variant="perturbed") for column in ("rmse_position", "reprojection_cost"))
    weight, most = n.peak("perturbed")
    trials = n.ends("prior_trials", "mean_iterations", variant="perturbed")
    identity, diagonal = (n.ends("prior_damping", "iterations", damping=name) for name in ("identity", "diagonal"))
    return {
        "prior_sweep": dict(first=number(1e3 * rmse[0]), last=number(1e3 * rmse[1]),
                            spread=number(n.spread("minimal", "rmse_position"), 1)),
        "prior_costs": dict(first=number(cost[0]), last=number(cost[1])),
        "prior_traces": {},
        "prior_trials": dict(most=number(most), weight=number(weight, 1), free=number(trials[0]), strong=number(trials[1])),
        "prior_damping": dict(identity_free=whole(identity[0]), identity_strong=whole(identity[1]),
                              diagonal_free=whole(diagonal[0]), diagonal_strong=whole(diagonal[1])),
    }


SECTIONS = {"bundle-adjustment": bundle_adjustment, "the-hessian": the_hessian, "marginalization": marginalization,
            "the-priors-weight": the_priors_weight}


def sections(n, say):
    """Per section its figures, and per figure its words."""
    return {section: {figure: say(figure, **numbers) for figure, numbers in of(n).items()}
            for section, of in SECTIONS.items()}


def findings(n, say):
    """{section: what it has found}"""
    poses, size = n.rows_of_h("large")
    weight, most = n.peak("perturbed")
    free, strong = n.ends("prior_trials", "mean_iterations", variant="perturbed")
    policies = {name: n.tables("odometry_policies").row(policy=name) for name in NAMES}
    both = lambda tell: say("both", **{name: tell(row) for name, row in policies.items()})  # noqa: E731
    return {
        "bundle-adjustment": solved(n, say),
        "the-hessian": say("finding.the-hessian", free=n.spectrum("free")[1], size=size, poses=poses),
        "the-priors-weight": say("finding.the-priors-weight", most=number(most), weight=number(weight, 1), free=number(free),
                                 strong=number(strong)),
        "odometry": say("finding.odometry", policies=say("both", **NAMES), error=both(lambda row: f"{100 * row['ate_m']:.1f}"),
                        times=both(lambda row: whole(row["realtime_factor"]))),
        "consistency": say("finding.consistency", **nees.in_short()),
    }


def solved(n, say):
    """The first finding."""
    large = n.solve("large")
    return say("finding.bundle-adjustment", frames=whole(large["frames"]), points=whole(large["points"]),
               iterations=whole(large["iterations"]), start=number(large["initial_rmse_landmark_m"], 2),
               end=number(1e3 * large["final_rmse_landmark_m"], 2), ms=number(large["milliseconds"], 2))


def first_finding(directory, say):
    """The same from the tables in DIR/csv, for the terminal."""
    return solved(Chapter(Tables(directory / "csv")), say)
