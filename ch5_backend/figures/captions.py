"""What the report says of the chapter's tables: a finding at its head for each section, and the words below each figure. The
sentences are in words/ and ask the tables for their numbers."""
from .numbers.chapter import Chapter
from .odometry import NAMES
from .tables import Tables

SECTIONS = {"bundle-adjustment": ("scene_course", "scene_large", "mono_ba_convergence"),
            "the-hessian": ("hessian_course", "hessian_large", "spectrum"),
            "marginalization": ("marginalize_chain", "marginalize_scene"),
            "the-priors-weight": ("prior_sweep", "prior_costs", "prior_traces", "prior_trials", "prior_damping")}


def names_of(n):
    """What these sentences can name."""
    return {"n": n, "table": n.tables, "course": n.solve("course"), "large": n.solve("large")}


def sections(n, say):
    """Per section its figures, and per figure its words."""
    names = names_of(n)
    return {section: {figure: say(figure, **names) for figure in figures} for section, figures in SECTIONS.items()}


def findings(n, say):
    """{section: what it has found}"""
    policies = {name: n.tables("odometry_policies").row(policy=name) for name in NAMES}
    both = lambda tell: say("both", **{name: tell(row) for name, row in policies.items()})  # noqa: E731
    names = names_of(n) | {"policies": say("both", **NAMES), "error": both(lambda row: f"{100 * row['ate_m']:.1f}")}
    return {section: say(f"finding.{section}", **names)
            for section in ("bundle-adjustment", "the-hessian", "the-priors-weight", "odometry")}


def first_finding(directory, say):
    """The first one from the tables in DIR/csv, for the terminal."""
    return say("finding.bundle-adjustment", **names_of(Chapter(Tables(directory / "csv"))))
