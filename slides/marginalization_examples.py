"""The examples that a student computes by hand, in exact fractions, and the toy graph of the first picture."""

from fractions import Fraction as F

import numpy as np

from ch5_backend.figures.tables import dense

# A window of four poses; each landmark with the poses that see it.
POSES = (0, 1, 2, 3)
SEEN = {0: (0, 1), 1: (0, 1, 2), 2: (0, 2, 3), 3: (1, 2, 3), 4: (2, 3)}
LEAVING = 0

PRODUCT = 1                      # x y is measured twice
POINTS = ((F(1), F(1)), (F(2), F(1, 2)))  # where it is linearized


def edges():
    """Sets of vertices ("x", pose) and ("l", landmark): IMU between neighbors, one observation a view."""
    imu = [{("x", a), ("x", b)} for a, b in zip(POSES, POSES[1:])]
    return imu + [{("l", k), ("x", n)} for k, seen in SEEN.items() for n in seen]


def leaving():
    """The oldest pose, and the landmarks that it sees."""
    return {("x", LEAVING)} | {("l", k) for k, seen in SEEN.items() if LEAVING in seen}


def neighbors():
    """Those that share an edge with something that leaves: the prior's vertices."""
    gone = leaving()
    return sorted(set().union(*(edge for edge in edges() if edge & gone)) - gone)


def det(a):
    return a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]


def solve(a, b):
    """a x = b of any size, by Gauss' elimination in exact fractions."""
    rows = [[*map(F, row), F(value)] for row, value in zip(a, b)]
    for k in range(len(rows)):
        pivot = [value / rows[k][k] for value in rows[k]]
        rows = [pivot if i == k else [value - row[k] * mine for value, mine in zip(row, pivot)]
                for i, row in enumerate(rows)]
    return [row[-1] for row in rows]


def chain():
    """The course's three scalars: H, b with the hidden prior's residual −0.2, and what marginalizing the middle leaves."""
    w01, w1, w12 = (1 / F(s, 10) ** 2 for s in (1, 2, 3))
    H = np.array([[w01, -w01, F(0)], [-w01, w01 + w1 + w12, -w12], [F(0), -w12, w12]])
    b = np.array([F(0), w1 * F(2, 10), F(0)])
    kept, gain = [0, 2], H[[0, 2], 1] / H[1, 1]
    return H, b, H[np.ix_(kept, kept)] - np.outer(gain, H[1, kept]), b[kept] - gain * b[1]


def solved_chain(tables):
    """The same, once H and the prior are known to be what the solver has written."""
    H, b, prior, b_prior = chain()
    for name, exact in (("before", H), ("after", prior)):
        worst = np.abs(dense(tables("marginalize_chain", stage=name)) - exact.astype(float)).max()
        if worst > 1e-9 * 200:
            raise ValueError(f"marginalize_chain.csv, {name}: {worst} away from the exact fractions")
    return H, b, prior, b_prior


def two_scalars():
    """x₀ measured and x₁ − x₀ measured, σ = 1: H, and the information on x₁ with x₀ marginalized and fixed."""
    H = np.array([[F(2), F(-1)], [F(-1), F(1)]])
    return H, H[1, 1] - H[1, 0] * H[0, 1] / H[0, 0], H[1, 1]


def rank_one():
    """A prior on 2x − y alone: H = uᵀu, b₀ = −uᵀe₀."""
    u, b = np.array([F(2), F(-1)]), np.array([F(2), F(-1)])
    return u, np.outer(u, u), b, -(u @ b) / (u @ u)


def jacobian(point):
    """Of r = x y − 1."""
    x, y = point
    return np.array([[y, x]])


def two_tangents():
    """H of two measurements, linearized at the same point and at two points."""
    first, second = (jacobian(point).T @ jacobian(point) for point in POINTS)
    return first + first, first + second
