"""The examples of the deck that need no solver: two numbers on a line, a walk into a valley, and a tilting book."""

from fractions import Fraction
from math import asin, atan2, cos, degrees, pi, radians, sin, sqrt

import numpy as np

SIGMA = 2                     # of the measurement x₂ − x₁
TILT = 6                      # degrees: the σ of the paper's initial rotations
DAMPING, STOP = 0.02, 5e-3    # of the walk: λ, and the step that ends it
WEAK = 0.05                   # its weak prior


def two_numbers():
    """H, U, the pseudo-inverse of H, V, Q and the covariance with x₁ held, in exact fractions."""
    J, U, V = (np.vectorize(Fraction)(rows) for rows in ([[-1, 1]], [[1], [1]], [[1], [0]]))
    H = J.T @ J / SIGMA ** 2
    free = J.T @ J * SIGMA ** 2 / (J @ J.T).item() ** 2  # J Jᵀ: the eigenvalue of JᵀJ
    Q = np.eye(2, dtype=int) - U @ V.T / (V.T @ U).item()
    return H, U, free, V, Q, Q @ free @ Q.T


def difference_variance(covariance):
    return covariance[0, 0] + covariance[1, 1] - 2 * covariance[0, 1]


def walk(weight):
    """The points (a, b) of damped steps on ½(b − a − 1)² + ½ w a², from the origin; weight None: a is held."""
    a = b = 0.0
    points = [(a, b)]
    while len(points) < 1000:
        r, w = b - a - 1, weight or 0.0
        # (H + λI) Δ = −g with H = [[1 + w, −1], [−1, 1]]
        haa, hbb, ga, gb = 1 + w + DAMPING, 1 + DAMPING, -r + w * a, r
        if weight is None:
            da, db = 0.0, -gb / hbb
        else:
            det = haa * hbb - 1
            da, db = (-ga * hbb - gb) / det, (-gb * haa - ga) / det
        a, b = a + da, b + db
        points.append((a, b))
        if sqrt(da * da + db * db) < STOP:
            break
    return points


def quaternion(axis, angle):
    return [cos(angle / 2)] + [sin(angle / 2) * (k == axis) for k in range(3)]


def times(p, q):
    (a, b, c, d), (e, f, g, h) = p, q
    return [a * e - b * f - c * g - d * h, a * f + b * e + c * h - d * g, a * g - b * h + c * e + d * f,
            a * h + b * g - c * f + d * e]


def tilted_yaw():
    """Yaw in degrees after tilting forward, sideways, back and sideways back, each a step without z component."""
    alpha = radians(TILT)
    q = [1.0, 0.0, 0.0, 0.0]
    for axis, angle in ((0, alpha), (1, alpha), (0, -alpha), (1, -alpha)):
        q = times(q, quaternion(axis, angle))
    w, x, y, z = q
    assert abs(asin(2 * (w * y - z * x))) < pi / 4  # far from where yaw has no meaning
    return degrees(atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
