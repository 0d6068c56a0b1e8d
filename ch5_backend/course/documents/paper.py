"""./course paper: the handout's example on paper with numbers of one's own, asked and checked, or as a sheet for an exam.

Two poses and two landmarks on a line, four edges that measure l − x, and a prior on x0 (handout/paper.md). All is exact, in
fractions: each question eliminates rows one after the other.
"""

import itertools
import math
import random
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

from markupsafe import Markup

from ch5_backend.figures import page

from ..base.cmake_build import ROOT
from ..base.errors import CourseError, warn
from ..base.language import Speaker, aligned, sentence, speaker
from ..homework.predict import is_near, numbers_in, read_row, shown

NAMES = ("x0", "x1", "l0", "l1")
WEIGHTS = ((2, 2), (3, 6), (6, 3), (4, 4), (4, 12), (12, 4), (6, 6))  # so that W W′ / (W + W′) is whole


@dataclass(frozen=True)
class Example:
    edges: tuple  # (pose, landmark, l − x as measured, W)
    prior: tuple  # (x0, W)

    def system(self) -> tuple:
        """H = JᵀWJ, b = −JᵀWr and the cost ½ rᵀWr, all states 0."""
        H, b = [[Fraction(0)] * 4 for _ in NAMES], [Fraction(0)] * 4
        terms = [({pose: -1, 2 + landmark: 1}, -d, W) for pose, landmark, d, W in self.edges] + [({0: 1}, -self.prior[0], self.prior[1])]
        for J, r, W in terms:
            for i in J:
                b[i] -= J[i] * W * r
                for j in J:
                    H[i][j] += J[i] * W * J[j]
        return H, b, sum(W * r * r for _, r, W in terms) / 2


def example(seed: int) -> Example:
    """Numbers that give a whole solution, in which the prior has no residual (the gauge is minimal)."""
    chance = random.Random(seed)
    x = [chance.randint(1, 3)]
    for least, most in ((1, 3), (1, 3), (1, 3)):
        x.append(x[-1] + chance.randint(least, most))
    t, edges = Fraction(chance.choice((-12, -6, 6, 12)), 10), []
    for landmark in (0, 1):
        for pose, W in enumerate(chance.choice(WEIGHTS)):
            e = (-1) ** (pose + landmark) * t / W  # the residual that is left: Jᵀ W e = 0
            edges.append((pose, landmark, x[2 + landmark] - x[pose] - e, Fraction(W)))
    return Example(tuple(edges), (Fraction(x[0]), Fraction(chance.randint(1, 4))))


def eliminated(H: list, b: list, k: int) -> tuple:
    """H_rr − H_rk H_kk⁻¹ H_kr and b_r − H_rk H_kk⁻¹ b_k: row k marginalized."""
    rest = [i for i in range(len(b)) if i != k]
    return ([[H[i][j] - H[i][k] * H[k][j] / H[k][k] for j in rest] for i in rest], [b[i] - H[i][k] * b[k] / H[k][k] for i in rest])


def solved(H: list, b: list) -> list:
    if not b:
        return []
    rest = solved(*eliminated(H, b, 0))
    return [(b[0] - sum(h * x for h, x in zip(H[0][1:], rest))) / H[0][0], *rest]


def answers(one: Example) -> dict:
    """{name: (names of the rows, of the columns, numbers row by row)}; a single number has no names. Where nothing holds the
    graph, what would need its inverse is missing."""
    found = {}
    try:
        for name, rows, columns, numbers in steps(one):
            found[name] = rows, columns, numbers
    except ZeroDivisionError:
        pass
    return found


def steps(one: Example):
    H, b, cost = one.system()
    yield "H", NAMES, NAMES, H
    yield "b", (), NAMES, [b]
    yield "before", (), (), [[cost]]
    Hp, bp = eliminated(H, b, 0)
    yield "Hp", NAMES[1:], NAMES[1:], Hp
    yield "bp", (), NAMES[1:], [bp]
    S, bS = eliminated(*eliminated(H, b, 3), 2)
    yield "S", NAMES[:2], NAMES[:2], S
    yield "bS", (), NAMES[:2], [bS]
    dx = solved(H, b)
    yield "dx", (), NAMES, [dx]
    yield "after", (), (), [[cost - sum(x * y for x, y in zip(b, dx)) / 2]]
    [[H1]], [b1] = eliminated(S, bS, 0)
    yield "H1", (), (), [[H1]]
    yield "b1", (), (), [[b1]]
    yield "variance", (), (), [[1 / H1]]
    yield "J", (), (), [[math.sqrt(H1)]]
    yield "r0", (), (), [[-float(b1) / math.sqrt(H1)]]


QUESTIONS = (  # each with what it asks for, by its name in `answers` and in words
    ("paper.question_1", {"H": "H:", "b": "b:", "before": sentence("paper.before")}),
    ("paper.question_2", {"S": "S:", "bS": sentence("paper.bS"), "dx": "Δx:", "after": sentence("paper.after")}),
    ("paper.question_3", {"Hp": "H_prior:", "bp": "b_prior:"}),
    ("paper.question_4", {"H1": "H:", "b1": "b:", "variance": sentence("paper.variance"), "J": "J:", "r0": "r₀:"}))


def slips(one: Example):
    """(sentence, what comes of it): a slip gives the right answers of another example, or a step of the right one left undone."""
    for k, (pose, landmark, d, W) in enumerate(one.edges):
        name = f"x{pose}–l{landmark}"
        for id, changed in (("paper.left_out", (pose, landmark, d, Fraction(0))), ("paper.twice", (pose, landmark, d, 2 * W)),
                            ("paper.sign", (pose, landmark, -d, W)), ("paper.without_weight", (pose, landmark, d, Fraction(1)))):
            yield sentence(id, edge=name), answers(replace(one, edges=(*one.edges[:k], changed, *one.edges[k + 1:])))
    for id, W in (("paper.prior_left_out", Fraction(0)), ("paper.prior_twice", 2 * one.prior[1])):
        yield sentence(id), answers(replace(one, prior=(one.prior[0], W)))
    right = answers(one)
    scaled = lambda factor: {name: (rows, columns, [[factor * x for x in row] for row in numbers]) for name, (rows, columns, numbers) in right.items()}
    yield sentence("paper.other_sign"), scaled(-1)
    yield sentence("paper.no_half"), {name: answer for name, answer in scaled(2).items() if name in ("before", "after")}
    H, b, _ = one.system()
    before = {"S": [row[:2] for row in H[:2]], "bS": [b[:2]], "Hp": [row[1:] for row in H[1:]], "bp": [b[1:]]}
    yield sentence("paper.nothing_subtracted"), {name: (*right[name][:2], numbers) for name, numbers in before.items()}
    yield sentence("paper.added"), {name: (*right[name][:2], [[2 * x - y for x, y in zip(*rows)] for rows in zip(numbers, right[name][2])])
                                   for name, numbers in before.items()}


def are_near(got: list, right: list) -> bool:
    return all(is_near(*pair) for rows in zip(got, right) for pair in zip(*rows))


def what_is_wrong(one: Example, name: str, got: list) -> list:
    """Nothing if it is right; else the entries that are not, and the slip that gives this answer, if one is known."""
    rows, columns, right = answers(one)[name]
    if are_near(got, right):
        return []
    wrong = [f"({row}, {column})" if rows else column for i, row in enumerate(rows or ("",)) for j, column in enumerate(columns or ("",))
             if not is_near(got[i][j], right[i][j])]
    said = [sentence("paper.wrong_entries", entries=", ".join(wrong))] if columns else [sentence("paper.wrong")]
    named = (told for told, result in slips(one) if name in result and are_near(got, result[name][2]))
    return [*said, *itertools.islice(named, 1)]


def laid_out(answer: tuple) -> str:
    rows, columns, numbers = answer
    cells = [[shown(value) for value in row] for row in numbers]
    return aligned([["", *columns]] * bool(columns) + [[row, *line] for row, line in zip(rows or ("",), cells)], math.inf)


def drawing(one: Example, say: Speaker) -> str:
    of = [f"{shown(d)}, W = {shown(W)}".center(16) for _, _, d, W in one.edges]
    line = lambda left, landmark, right: f"     {left}{'─' * 15} l{landmark} {'─' * 15}{right}"
    prior = say("paper.prior", x=shown(one.prior[0]), W=shown(one.prior[1]))
    return "\n".join(["", f"     {of[0]}    {of[1]}", line("┌", 0, "┐"), "     x0" + " " * 33 + "x1     " + prior,
                      line("└", 1, "┘"), f"     {of[2]}    {of[3]}", ""])


def ask(one: Example, name: str, say: Speaker) -> str:
    """"at once", "later" or "shown": a wrong answer is asked again, an empty line shows the right one."""
    rows, columns, right = answers(one)[name]
    outcome = "at once"
    while True:
        got = []
        while len(got) < len(right) and [] not in got:
            got.append(numbers_in(read_row(f"  {(rows or ('',))[len(got)]:3}> ", max(len(columns), 1), say)))
        if [] in got:
            print(laid_out((rows, columns, right)))
            return "shown"
        wrong = what_is_wrong(one, name, got)
        if not wrong:
            print("  ✓")
            return outcome
        outcome = "later"
        print(*(f"  ✗ {say.text(words)}" for words in wrong), sep="\n")


def sheet(one: Example, seed: int, folder: Path, say: Speaker) -> list:
    """FOLDER/paper_SEED.html and the same with its answers, as PDF too where Chromium is; their paths."""
    title, solution, paths = say("paper.title", seed=seed), answers(one), []
    for solved_too in (False, True):
        body = [Markup("<h1>{}</h1><p>{}</p><pre>{}</pre>").format(title, say("paper.lead"), drawing(one, say))]
        for number, (question, parts) in enumerate(QUESTIONS, 1):
            body.append(Markup("<p><strong>{}.</strong> {}</p>").format(number, say(question)))
            body.append(Markup("<pre>{}</pre>").format("\n\n".join(f"{say.text(words)}\n{laid_out(solution[name])}" for name, words in parts.items())) if solved_too
                        else Markup('<p style="height:9em"></p>'))
        paths.append(folder / f"paper_{seed}{'_answers' if solved_too else ''}.html")
        page.write(paths[-1], title, body, say.language)
    try:
        from slides import browser
        for path in list(paths):
            browser.pdf(path, path.with_suffix(".pdf"))
            paths.append(path.with_suffix(".pdf"))
    except (ImportError, browser.BuildError) as missing:  # the students' archive has no slides
        warn(say("paper.no_pdf", why=missing))
    return paths


def paper(seed, as_sheet: bool, out: str, language: str) -> int:
    """0 if all was right in the end, or written; 1 if something was shown or left open. Raises CourseError."""
    say, seed = speaker(language), random.SystemRandom().randrange(10**6) if seed is None else seed
    one = example(seed)
    if as_sheet:
        folder = Path(out or ROOT / "out" / "paper")
        folder.mkdir(parents=True, exist_ok=True)
        print(*sheet(one, seed, folder, say), sep="\n")
        return 0
    if out:
        raise CourseError(sentence("paper.out_without_sheet"))
    print(say("paper.title", seed=seed), say("paper.lead"), drawing(one, say), say("paper.how"), sep="\n")
    outcomes = []
    try:
        for number, (question, parts) in enumerate(QUESTIONS, 1):
            print(f"\n{number}. {say(question)}")
            for name, words in parts.items():
                print(say.text(words))
                outcomes.append(ask(one, name, say))
    except EOFError:
        print()
    total = sum(len(parts) for _, parts in QUESTIONS)
    print(say("paper.score", first=outcomes.count("at once"), total=total, seed=seed))
    return 0 if len(outcomes) == total and "shown" not in outcomes else 1
