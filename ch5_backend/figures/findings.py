"""What the chapter has found: five sentences, each with numbers from the tables, and the section that shows it."""
from . import nees
from .numbers.chapter import Chapter
from .odometry import NAMES
from .style import number
from .tables import Tables, read


def bundle_adjustment(n, directory, say):
    large = n.solve("large")
    return say("finding.bundle-adjustment", frames=f"{large['frames']:.0f}", points=f"{large['points']:.0f}",
               iterations=f"{large['iterations']:.0f}", start=number(large["initial_rmse_landmark_m"], 2),
               end=number(1e3 * large["final_rmse_landmark_m"], 2), ms=number(large["milliseconds"], 2))


def the_hessian(n, directory, say):
    poses, size = unknowns(directory, "large")
    return say("finding.the-hessian", free=n.spectrum("free")[1], size=size, poses=poses)


def the_priors_weight(n, directory, say):
    weight, most = n.peak("perturbed")
    free, strong = n.ends("prior_trials", "mean_iterations", variant="perturbed")
    return say("finding.the-priors-weight", most=number(most), weight=number(weight, 1), free=number(free), strong=number(strong))


def odometry_of_both(n, directory, say):
    rows = {name: read(directory, "odometry_policies").row(policy=name) for name in NAMES}
    both = lambda tell: say("both", **{name: tell(row) for name, row in rows.items()})
    return say("finding.odometry", policies=say("both", **NAMES), error=both(lambda row: f"{100 * row['ate_m']:.1f}"),
               times=both(lambda row: f"{row['realtime_factor']:.0f}"))


def consistency(n, directory, say):
    return say("finding.consistency", **nees.in_short())


OF = {"bundle-adjustment": bundle_adjustment, "the-hessian": the_hessian, "the-priors-weight": the_priors_weight,
      "odometry": odometry_of_both, "consistency": consistency}


def unknowns(directory, scene):
    """(rows of the poses, of all vertices) in a free H."""
    rows = read(directory, "hessian_vertices").where(scene=scene)["rows"]
    return int(rows[rows > 1].sum()), int(rows.sum())


def bundle_adjustment_of(directory, say):
    """The first finding."""
    return bundle_adjustment(Chapter(Tables(directory / "csv")), directory, say)


def sentences(directory, say):
    """{section: what it has found}"""
    n = Chapter(Tables(directory / "csv"))
    return {section: tell(n, directory, say) for section, tell in OF.items()}
