"""Every number of the deck, by name. Each comes from a table of ./course run, or is exact arithmetic that is held
against one; the deck writes {{name}} and never a digit of a result."""

from fractions import Fraction
from math import gcd, lcm

from ch5_backend.figures.numbers.chapter import Chapter

from .facts import gathered, typed_in
from .marginalization_examples import solved_chain
from .tex import bracketed, decimal, matrix, scientific, tex


def chain_facts(tables):
    """The 3×3 example in exact fractions."""
    H, _, prior, _ = solved_chain(tables)
    steps = [rf"{tex(H[i][j])} - {bracketed(H[i][1])}\cdot{bracketed(H[1][j])}\,/\,{tex(H[1][1])} &= "
             rf"{tex(prior[i // 2][j // 2])} = {decimal(prior[i // 2][j // 2]).replace('−', '-')}" for i, j in ((0, 0), (0, 2), (2, 2))]
    return {"chain.H": matrix(H, tex), "chain.step00": steps[0], "chain.step02": steps[1], "chain.step22": steps[2],
            "chain.fraction": common_factor(prior)}


def common_factor(rows):
    """A matrix of fractions as one fraction times whole numbers, in TeX."""
    entries = [v for row in rows for v in row]
    factor = Fraction(gcd(*(v.numerator for v in entries)), lcm(*(v.denominator for v in entries)))
    return tex(factor) + matrix([[v / factor for v in row] for row in rows], tex)


def chapter_facts(tables):
    """What the pages ask: the scenes' bundle adjustments, the gap in the spectrum of the free problem (zeros, then the smallest true
    eigenvalue)."""
    chapter = Chapter(tables)
    sizes, zeros = chapter.spectrum("free")
    return {"chapter": chapter, "course": chapter.solve("course"), "large": chapter.solve("large"), "sizes": sizes, "zeros": zeros}


def study_facts(tables):
    """How the experiment is set up: the starts from its source, the weights from its table."""
    position, rotation = typed_in("ch5_backend/experiments/studies/prior_study.cc",
                                  r"position_sigma = ([\d.]+);.*rotation_sigma = ([\d.]+) \* M_PI / 180\.0;")
    weights = [w for w in tables("prior_sweep", variant="course")["weight"].tolist() if w > 0]
    return {"study.position_cm": f"{100 * float(position):g}", "study.rotation_deg": f"{float(rotation):g}",
            "study.lightest": scientific(min(weights), 1, shortest=False), "study.heaviest": scientific(max(weights), 1)}


facts = gathered(chapter_facts, chain_facts, study_facts)
