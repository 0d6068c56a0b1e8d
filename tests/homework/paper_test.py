"""./course paper: its numbers against matrices and against the handout, slips made by hand, and a student who answers."""

import os
import subprocess
import unittest
from fractions import Fraction
from pathlib import Path

import numpy as np

from ch5_backend.course.documents.paper import NAMES, QUESTIONS, Example, answers, example, laid_out, what_is_wrong
from tests.docs.markdown import plain
from tests.folder import FolderTest
from tests.homework.chinese import english_in
from tests.project import ROOT, run

EDGES = ((0, 0, "2.4", 2), (1, 0, "2.6", 2), (0, 1, "4.4", 3), (1, 1, "2.8", 6))
OF_THE_HANDOUT = Example(tuple((pose, landmark, Fraction(d), Fraction(W)) for pose, landmark, d, W in EDGES), (Fraction(1), Fraction(1)))


def numbers(one: Example) -> dict:
    return {name: np.array(matrix, dtype=float) for name, (_, _, matrix) in answers(one).items()}


def normal_equations(rows: list) -> tuple:
    """H and b of (J, r, W), by matrices."""
    J, r, W = (np.array(column, dtype=float) for column in zip(*rows))
    return J.T @ np.diag(W) @ J, -J.T @ np.diag(W) @ r


def rows_of(one: Example) -> list:
    """(J, r, W) of the edges, then of the prior, all states 0."""
    of_edge = lambda pose, landmark: [(k == 2 + landmark) - (k == pose) for k in range(4)]
    return [(of_edge(pose, landmark), -d, W) for pose, landmark, d, W in one.edges] + [([1, 0, 0, 0], -one.prior[0], one.prior[1])]


class Numbers(unittest.TestCase):
    def test_the_handouts_example_has_the_handouts_numbers(self):
        page = plain((ROOT / "ch5_homework" / "handout" / "paper.md").read_text(encoding="utf-8"))
        found = numbers(OF_THE_HANDOUT)
        for name, words in (("before", r"cost is \tfrac12 (2 · 2.4^2 + 2 · 2.6^2 + 3 · 4.4^2 + 6 · 2.8^2 + 1) = {}"), ("after", "65.58 → {}"), ("H1", "H = {},"),
                            ("b1", "b = {},"), ("J", r"\sqrt{{0.75}} = {}"), ("r0", "r_0 = {}")):
            self.assertIn(words.format(f"{found[name].item():.6g}".replace("-", "−")), page, name)
        self.assertEqual(found["dx"].tolist(), [[1, 2, 4, 5]])

    def test_other_numbers_are_those_of_matrices(self):
        for seed in range(300):
            one = example(seed)
            found, (H, b) = numbers(one), normal_equations(rows_of(one))
            P, x = np.linalg.inv(H), np.linalg.solve(H, b)
            np.testing.assert_allclose(found["H"], H)
            np.testing.assert_allclose(found["b"][0], b)
            np.testing.assert_allclose(found["dx"][0], x, atol=1e-12)
            np.testing.assert_allclose(x, np.round(x), atol=1e-9, err_msg="a whole solution")
            for name, kept in (("S", [0, 1]), ("Hp", [1, 2, 3]), ("H1", [1])):  # a marginal is a block of the inverse
                np.testing.assert_allclose(found[name], np.linalg.inv(P[np.ix_(kept, kept)]), atol=1e-9)
                vector = found[{"S": "bS", "Hp": "bp", "H1": "b1"}[name]][0]
                np.testing.assert_allclose(found[name] @ x[kept], vector, atol=1e-9)
            np.testing.assert_allclose(found["variance"].item(), P[1, 1])
            cost = lambda at: sum(W * float(np.dot(J, at) + float(r)) ** 2 for J, r, W in rows_of(one)) / 2
            np.testing.assert_allclose([found["before"].item(), found["after"].item()], [cost(np.zeros(4)), cost(x)])
            np.testing.assert_allclose([found["J"].item() ** 2, -found["J"].item() * found["r0"].item()], [found["H1"].item(), found["b1"].item()])


class Slips(unittest.TestCase):
    def told(self, name: str, got, one=example(5)) -> list:
        return [said["id"] for said in what_is_wrong(one, name, np.array(got, dtype=float).tolist())]

    def test_what_is_right_to_three_digits_is_right(self):
        for seed in range(50):
            for name, matrix in numbers(example(seed)).items():
                rounded = [[float(f"{x:.4g}") for x in row] for row in matrix]
                self.assertEqual(what_is_wrong(example(seed), name, rounded), [], (seed, name))

    def test_slips_are_named(self):
        one, right = example(5), numbers(example(5))
        rows = rows_of(one)
        H, b = normal_equations(rows[1:])
        self.assertEqual(self.told("H", H), ["paper.wrong_entries", "paper.left_out"])
        self.assertEqual(self.told("b", [b]), ["paper.wrong_entries", "paper.left_out"])
        self.assertEqual(self.told("H", normal_equations([*rows, rows[2]])[0]), ["paper.wrong_entries", "paper.twice"])
        self.assertEqual(self.told("H", normal_equations(rows[:4])[0]), ["paper.wrong_entries", "paper.prior_left_out"])
        self.assertEqual(self.told("b", -right["b"]), ["paper.wrong_entries", "paper.other_sign"])
        self.assertEqual(self.told("before", 2 * right["before"]), ["paper.wrong", "paper.no_half"])
        whole = right["H"]
        A, B, C = whole[:2, :2], whole[:2, 2:], whole[2:, 2:]
        self.assertEqual(self.told("S", A), ["paper.wrong_entries", "paper.nothing_subtracted"])
        self.assertEqual(self.told("S", A + B @ np.linalg.inv(C) @ B.T), ["paper.wrong_entries", "paper.added"])
        self.assertEqual(self.told("S", right["S"] + [[0, 0.5], [0, 0]]), ["paper.wrong_entries"])

    def test_wrong_entries_are_named_by_their_rows_and_columns(self):
        one = example(5)
        got = numbers(one)["H"]
        got[0, 3] += 1
        self.assertEqual(what_is_wrong(one, "H", got.tolist())[0]["entries"], "(x0, l1)")


class Dialogue(FolderTest):
    def paper(self, lines: list, *words) -> subprocess.CompletedProcess:
        return run(ROOT / "course", "paper", "--seed", "3", *words, input="".join(line + "\n" for line in lines),
                   env={**os.environ, "LC_ALL": "C.UTF-8"})

    def right(self) -> list:
        return [" ".join(f"{float(x):.6g}" for x in row) for _, parts in QUESTIONS for name in parts for row in answers(example(3))[name][2]]

    def test_who_knows_is_told_so(self):
        done = self.paper(self.right())
        self.assertEqual((done.returncode, done.stdout.count("✓"), done.stderr), (0, 14, ""))
        self.assertIn("14 of 14 right at once", done.stdout)
        chinese = self.paper(self.right(), "--language", "zh")
        self.assertEqual(english_in(chinese.stdout.replace(str(NAMES), "")), "", chinese.stdout)

    def test_a_wrong_answer_is_asked_again_and_an_empty_line_shows_it(self):
        right = self.right()
        done = self.paper(["1/0", "one two three four", "0 0 0 0", *right[1:4], *right])
        self.assertEqual(done.returncode, 0, "all is answered in the end")
        self.assertIn("13 of 14", done.stdout)
        self.assertEqual(done.stdout.count("numbers needed: 4"), 2)
        shown = self.paper(["", *right[4:]])
        self.assertEqual(shown.returncode, 1)
        self.assertIn(laid_out(answers(example(3))["H"]), shown.stdout)
        self.assertEqual(self.paper(right[:3]).returncode, 1, "the input ends")

    def test_a_sheet_has_no_answers_and_the_other_has(self):
        done = self.paper([], "--sheet", "--out", self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        one, solution = (Path(line).read_text(encoding="utf-8") for line in done.stdout.splitlines()[:2])
        for name in ("H", "S", "Hp"):
            text = laid_out(answers(example(3))[name])
            self.assertNotIn(text, one)
            self.assertIn(text, solution)
        self.assertEqual(self.paper([], "--out", self.folder).returncode, 2)
