"""The fifth example: a curve fitted with a residual in Python, a pose graph that marginalizes, and, given a recording's folder,
the estimator.

usage: example.py [FOLDER]
"""
import sys

import ch5
import numpy as np


def fit_a_curve():
    """y = exp(a t² + b t + c), a hundred noisy points, of which some are false."""
    rng = np.random.default_rng(1)
    t = np.linspace(0, 1, 100)
    y = np.exp(1.0 * t**2 + 2.0 * t + 1.0) + rng.normal(0, 0.1, 100)
    y[::10] += 20
    graph, abc = ch5.Graph(), ch5.Vector(np.array([0.5, 1.0, 0.0]))
    graph.add(abc)
    for t_k, y_k in zip(t, y):
        edge = ch5.Edge([abc], lambda x, t=t_k, y=y_k: np.array([np.exp(x @ (t * t, t, 1.0)) - y]), 1)
        edge.information = np.array([[1 / 0.1**2]])
        edge.set_cauchy(1.0)
        graph.add(edge)
    summary = graph.solve(max_iterations=50)
    sigma = np.sqrt(np.diag(graph.covariance([abc])))
    print(f"a, b, c = {abc.x.round(3)}, sigma {sigma.round(3)}: {summary['message']}")
    print("cost by iteration:", summary["cost"].round(1))


def slide_a_window():
    """Poses in a row; the first ones leave, and a prior knows what was known by them."""
    identity, graph = np.array([0, 0, 0, 1.0]), ch5.Graph()
    poses = [ch5.Pose(np.array([k, 0.1 * k, 0.0]), identity) for k in range(6)]
    for pose in poses:
        graph.add(pose)
    anchor = ch5.Edge([poses[0]], lambda x: np.concatenate([x[:3], 2 * x[3:6]]), 6)
    anchor.information = 100 * np.eye(6)
    graph.add(anchor)
    for i, j in zip(poses, poses[1:]):
        graph.add(ch5.between(i, j, np.array([1.0, 0, 0]), identity))
    graph.solve()
    before = graph.covariance([poses[5]])
    J, r0 = graph.marginalize(poses[:4])
    after = graph.covariance([poses[5]])
    print(f"the prior is {J.shape[0]}x{J.shape[1]}; the last pose's covariance changes by {abs(after - before).max():.1e}")


def follow(folder):
    """A recording's images and IMU, in order of time."""
    calibration, imu, frames = ch5.read_recording(folder)
    estimator, k, path, report = ch5.Estimator(calibration), 0, [], None
    for t, ids, points in frames:
        while k < len(imu) and (k == 0 or imu[k - 1][0] < t):
            estimator.add_imu(imu[k][0], imu[k][1:4], imu[k][4:7])
            k += 1
        report = estimator.add_frame(t, ids, points)
        if report["state"]:
            path.append(report["state"]["p"])
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum() if path else 0.0
    print(f"{len(path)} of {len(frames)} images have a pose; the path is {length:.2f} m long; at last: {report['status']}")


fit_a_curve()
slide_a_window()
if len(sys.argv) > 1:
    follow(sys.argv[1])
