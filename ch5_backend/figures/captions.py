"""The numbers in the words below each figure, all taken from the tables; the sentences around them are in words/."""
from .style import number


def bundle_adjustment(n):
    small, large = n.solve("course"), n.solve("large")
    return {
        "scene_course": dict(frames=f"{small['frames']:.0f}", points=f"{small['points']:.0f}",
                             start=number(small["initial_rmse_landmark_m"]), iterations=f"{small['iterations']:.0f}",
                             end=number(1e3 * small["final_rmse_landmark_m"])),
        "scene_large": dict(frames=f"{large['frames']:.0f}", points=f"{large['points']:.0f}",
                            points_mm=number(1e3 * large["final_rmse_landmark_m"]),
                            cameras_mm=number(1e3 * large["final_rmse_position_m"])),
        "mono_ba_convergence": dict(first=number(large["initial_cost"]), last=number(large["final_cost"])),
    }


def the_hessian(n):
    large = n.solve("large")
    return {
        "hessian_course": {},
        "hessian_large": dict(frames=f"{large['frames']:.0f}", points=f"{large['points']:.0f}"),
        "spectrum": dict(free=n.spectrum("free")[1], minimal=n.spectrum("minimal prior")[1]),
    }


def marginalization(n):
    fill = n.tables("marginalize_fill")
    before, after = fill.row(stage="before"), fill["null_dimension"][-1]
    return {
        "marginalize_chain": dict(shared=number(n.tables("marginalize_chain", stage="after")["value"][1], 6).replace("-", "−")),
        "marginalize_scene": dict(density=f"{100 * before['density']:.0f}", null=f"{after:.0f}"),
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
        "prior_damping": dict(identity_free=f"{identity[0]:.0f}", identity_strong=f"{identity[1]:.0f}",
                              diagonal_free=f"{diagonal[0]:.0f}", diagonal_strong=f"{diagonal[1]:.0f}"),
    }


SECTIONS = {"bundle-adjustment": bundle_adjustment, "the-hessian": the_hessian, "marginalization": marginalization,
            "the-priors-weight": the_priors_weight}


def sections(n, say):
    """Per section its figures, and per figure its words."""
    return {section: {figure: say(figure, **numbers) for figure, numbers in of(n).items()}
            for section, of in SECTIONS.items()}
