"""The examples that a student computes by hand, in exact fractions, and the toy graph of the first picture."""

from fractions import Fraction as F

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


def product(a, b):
    return [[sum(x * y for x, y in zip(row, column)) for column in zip(*b)] for row in a]


def transpose(a):
    return [list(row) for row in zip(*a)]


def plus(a, b):
    return [[x + y for x, y in zip(*rows)] for rows in zip(a, b)]


def det(a):
    return a[0][0] * a[1][1] - a[0][1] * a[1][0]


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
    H = [[w01, -w01, F(0)], [-w01, w01 + w1 + w12, -w12], [F(0), -w12, w12]]
    b = [F(0), w1 * F(2, 10), F(0)]
    prior = [[H[i][j] - H[i][1] / H[1][1] * H[1][j] for j in (0, 2)] for i in (0, 2)]
    b_prior = [b[i] - H[i][1] / H[1][1] * b[1] for i in (0, 2)]
    return H, b, prior, b_prior


def two_scalars():
    """x₀ measured and x₁ − x₀ measured, σ = 1: H, and the information on x₁ with x₀ marginalized and fixed."""
    H = [[F(2), F(-1)], [F(-1), F(1)]]
    return H, H[1][1] - H[1][0] * H[0][1] / H[0][0], H[1][1]


def rank_one():
    """A prior on 2x − y alone: H = uᵀu, b₀ = −uᵀe₀."""
    u = [F(2), F(-1)]
    H = product([[value] for value in u], [u])
    b = [F(2), F(-1)]
    e0 = -sum(x * y for x, y in zip(u, b)) / sum(x * x for x in u)
    return u, H, b, e0


def jacobian(point):
    """Of r = x y − 1."""
    x, y = point
    return [[y, x]]


def two_tangents():
    """H of two measurements, linearized at the same point and at two points."""
    blocks = [product(transpose(jacobian(point)), jacobian(point)) for point in POINTS]
    return plus(blocks[0], blocks[0]), plus(*blocks)
