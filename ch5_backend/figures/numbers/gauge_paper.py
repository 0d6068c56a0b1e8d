"""What the gauge paper reports, next to which our numbers stand.

Zhang, Gallego, Scaramuzza: On the Comparison of Gauge Freedom Handling in Optimization-based Visual-Inertial State
Estimation, IEEE RA-L 3(3), 2018. Its simulator was not released: its number of points, intrinsics, noise and rates are
unknown, so structure can be compared and digits cannot.
"""

TRIALS = 50  # of each scene

SCENES = tuple((path, points) for points in ("planes", "random") for path in ("sine", "arc", "rec"))

# Fig. 7, read off: mean iterations of each method, from, to.
ITERATIONS = {
    ("sine", "planes"): {"fixation": (5, 5), "free": (4, 5), "prior": (5, 5)},
    ("arc", "planes"): {"fixation": (6, 7), "free": (6, 6), "prior": (6, 7)},
    ("rec", "planes"): {"fixation": (5, 5), "free": (4, 5), "prior": (5, 5)},
    ("sine", "random"): {"fixation": (5, 5), "free": (5, 5), "prior": (5, 5)},
    ("arc", "random"): {"fixation": (6, 7), "free": (6, 6), "prior": (6, 7)},
    ("rec", "random"): {"fixation": (5, 5), "free": (4, 4), "prior": (5, 5)},
}

# Table II: RMSE of position [m], rotation [deg] and velocity [m/s]. The prior's equal the fixation's to eight digits.
RMSE = {
    ("sine", "planes"): {"fixation": (0.04141, 0.1084, 0.02182), "free": (0.04141, 0.1084, 0.02183)},
    ("arc", "planes"): {"fixation": (0.02328, 0.6987, 0.01303), "free": (0.02329, 0.6987, 0.01303)},
    ("rec", "planes"): {"fixation": (0.01772, 0.1668, 0.01496), "free": (0.01774, 0.1668, 0.01495)},
    ("sine", "random"): {"fixation": (0.03932, 0.0885, 0.01902), "free": (0.03908, 0.0874, 0.01886)},
    ("arc", "random"): {"fixation": (0.02680, 0.6895, 0.01167), "free": (0.02678, 0.6895, 0.01166)},
    ("rec", "random"): {"fixation": (0.02218, 0.1330, 0.009882), "free": (0.02220, 0.1330, 0.009881)},
}

# Table III, the same for EuRoC's machine hall.
EUROC = {"fixation": (0.06936, 0.07845, 0.03092), "free": (0.06918, 0.07857, 0.03091)}

# Fig. 5: iterations at each weight of the prior, and the weight that the paper recommends.
SWEEP = {0: 4, 3: 4, 7: 12, 10: 11, 50: 8, 100: 7, 300: 6, 500: 5, 1e3: 5, 5e3: 5}
RECOMMENDED = 1e5
FIRST_PIXELS = 14.7  # Fig. 6: the reprojection error at the start [px]

COVARIANCE_DISTANCE = 0.0011  # §VI: the transformed free covariance from the fixed one
