"""The examples of the deck that need no solver: two numbers on a line, a walk into a valley, and a tilting book."""

from fractions import Fraction
from math import atan2, cos, degrees, hypot, radians, sin

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
    x, points, w, free = np.zeros(2), [(0.0, 0.0)], weight or 0.0, slice(weight is None, 2)
    damped = np.array([[1 + w, -1], [-1, 1]]) + DAMPING * np.eye(2)  # (H + λI) Δ = −g
    while len(points) < 2 or hypot(*(x - points[-2])) >= STOP:
        r = x[1] - x[0] - 1
        x[free] -= np.linalg.solve(damped[free, free], np.array([-r + w * x[0], r])[free])
        points.append(tuple(x.tolist()))
    return points


def tilted_yaw():
    """Yaw in degrees after tilting forward, sideways, back and sideways back, each a step without z component."""
    c, s = cos(radians(TILT)), sin(radians(TILT))
    X, Y = np.array([[1, 0, 0], [0, c, -s], [0, s, c]]), np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    R = X @ Y @ X.T @ Y.T
    return degrees(atan2(R[1, 0], R[0, 0]))
