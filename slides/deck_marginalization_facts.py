"""Every number of the deck, by name: from a table, or exact arithmetic on the examples of marginalization_examples.py."""

from ch5_backend.figures.numbers.systems import lost_to_schur, qr_by_schur
from ch5_backend.figures.numbers.windows import KEPT, cuts, spectra
from ch5_backend.figures.style import percent

from . import marginalization_examples as toy
from .facts import gathered, typed_in
from .tex import matrix, scientific, tex

STUDIES = "ch5_backend/experiments/studies"


def short(value):
    return f"{float(value):.6g}"


def row(values, cell=tex):
    return matrix([values], cell)


def column(values, cell=tex):
    return matrix([[value] for value in values], cell)


def chain_facts(tables):
    H, b, prior, b_prior = toy.solved_chain(tables)
    number = lambda value: f"{float(value):.4f}".rstrip("0").rstrip(".")  # noqa: E731
    return {"chain3.H": matrix(H, short), "chain3.b": column(b), "chain3.dx": column(toy.solve(H, b), short),
            "chain3.prior": matrix(prior, short), "chain3.b_prior": column(b_prior, number),
            "chain3.dx_after": column(toy.solve(prior, b_prior), short)}


def hand_facts(tables):
    H, marginal, conditional = toy.two_scalars()
    u, H1, b, e0 = toy.rank_one()
    square = sum(value * value for value in u)
    return {
        "two_scalars.H": "H = " + matrix(H, tex), "two_scalars.marginal": tex(marginal), "two_scalars.conditional": tex(conditional),
        "rank1.H": matrix(H1, tex), "rank1.b": column(b), "rank1.S": tex(square),
        "rank1.u": rf"\tfrac{{1}}{{\sqrt{{{tex(square)}}}}}{column(u)}", "rank1.J": row(u), "rank1.e0": tex(e0),
        "rank1.back": column([-value * e0 for value in u]), "rank1.knows": f"{tex(u[0])}x - y",
        "rank1.null": column([-u[1], u[0]]), "rank1.wrong_e0": f"+{tex(-e0)}",
        "rank1.wrong_back": column([value * e0 for value in u]),
    }


def study_facts(tables):
    fill = tables("marginalize_fill")
    frames, points = typed_in(f"{STUDIES}/marginalize_study.cc", r"kFrames = (\d+), kPoints = (\d+)")
    seconds, outliers = map(float, typed_in(f"{STUDIES}/odometry_study.cc", r"duration=\*/([\d.]+),.*outlier_fraction = ([\d.]+);"))
    return {"fill": fill, "fill.frames": frames, "fill.points": points,
            "fill.null": " / ".join(sorted({f"{dimension:.0f}" for dimension in fill["null_dimension"]})),
            "prior": tables("slide_priors", stage="after"), "flights": tables("odometry_policies"),
            "flight.outliers": percent(outliers), "flight.seconds": f"{seconds:.0f}"}


def spectrum_facts(tables):
    plain, scaled = spectra(tables)
    vins, okvis = cuts(scaled)
    return {"spectrum.shift": scientific(max(abs(value) for value in plain[:3]), 1), "spectrum.yaw": scientific(plain[3], 1),
            "spectrum.vins_cut": scientific(vins, 1), "spectrum.okvis_cut": scientific(okvis, 2),
            "spectrum.vins_zeros": str(sum(value <= vins for value in plain)), "spectrum.okvis_zeros": str(sum(value <= okvis for value in scaled))}


def slide_facts(tables):
    facts = {}
    for policy in ("vins", "okvis"):
        of = lambda fate: [one for one in tables("slide_vertices", policy=policy).rows() if one["fate"] == fate]  # noqa: B023,E731
        gone, held = of("marginalized"), of("in the prior")
        count = lambda rows, kind: sum(one["vertex"] == kind for one in rows)  # noqa: E731
        observations = tables("slide_observations", policy=policy).rows()
        facts.update({
            f"slide.{policy}_gone": "{:.0f}".format(next(one["number"] for one in gone if one["vertex"] == "pose")),
            f"slide.{policy}_depths": str(count(gone, "landmark")), f"slide.{policy}_speeds": str(count(gone, "speed")),
            f"slide.{policy}_poses": str(count(held, "pose")), f"slide.{policy}_m": f"{sum(one['rows'] for one in gone):.0f}",
            f"slide.{policy}_rehosted": str(len({one["landmark"] for one in observations if one["fate"] == "again"}))})
        for fate in ("prior", "again", "lost", "stays"):
            facts[f"fate.{policy}_{fate}"] = str(sum(one["fate"] == fate for one in observations))
    frames = int(typed_in(f"{STUDIES}/window/flight.h", r"kFlightWindow = (\d+)"))
    keyframes, temporal = typed_in(f"{STUDIES}/window/flight.cc", r"keyframes=\*/(\d+).*temporal_frames=\*/(\d+)")
    facts.update({"slide.frames": str(frames), "slide.okvis_temporal": temporal,
                  "slide.okvis_c": str(frames - int(temporal) - 1), "slide.okvis_keyframes": keyframes,
                  "slide.landmarks": str(len(set(tables("slide_observations", policy="vins")["landmark"].tolist())))})
    return facts


def film_facts(tables):
    """How long frames stay, and how often the second newest leaves at once."""
    facts = {}
    for policy in ("vins", "okvis"):
        rows = tables("slide_frames", policy=policy).rows()
        seen = {}
        for one in rows:
            seen.setdefault(one["frame"], []).append(one["image"])
        facts[f"film.{policy}_oldest"] = f"{max(len(images) for images in seen.values()):.0f}"
        last = max(images[-1] for images in seen.values())
        facts[f"film.{policy}_second_new"] = str(sum(len(images) < 3 and images[-1] < last for images in seen.values()))
        facts["film.images"] = f"{last + 1:.0f}"
    return facts


def back_end_facts(_):
    qr = lost_to_schur(KEPT)
    slower = qr_by_schur(KEPT)
    return {"back.digits": "19", "back.lost": f"${scientific(1 / qr['weakness'], 1)}$",
            "back.qr": f"${scientific(qr['worst_error'], 1)}$", "back.slower": f"{slower[0]:.0f}–{slower[-1]:.0f}"}


facts = gathered(chain_facts, hand_facts, study_facts, spectrum_facts, slide_facts, film_facts, back_end_facts)
