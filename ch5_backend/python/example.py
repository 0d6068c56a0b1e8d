"""The fifth example: a curve fitted with a residual in Python, a pose graph that marginalizes, and, given a recording's folder,
the estimator. In cells (# %%), which editors run one by one as in a notebook; the last draws curve.png.

usage: example.py [FOLDER]
"""
# %% what it needs
import sys

import ch5
import numpy as np


# %% a curve
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
        edge.set_loss("cauchy", 1.0)
        graph.add(edge)
    costs = []
    summary = graph.solve(max_iterations=50, callback=lambda iteration: costs.append(iteration["cost"]))
    sigma = np.sqrt(np.diag(graph.covariance([abc])))
    print(f"a, b, c = {abc.x.round(3)}, sigma {sigma.round(3)}: {summary['message']}")
    print("cost by iteration:", np.round(costs, 1))
    return t, y, abc.x, costs


# %% a window
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


# %% a recording
def follow(folder):
    """A recording's images and IMU, in order of time."""
    calibration, imu, frames = ch5.read_recording(folder)
    estimator, k, path, report = ch5.Estimator(calibration), 0, [], None
    for t, ids, points in frames:
        end = np.searchsorted(imu[:, 0], t) + 1  # one beyond the image
        estimator.add_imu(imu[k:end])
        k = max(k, end)
        report = estimator.add_frame(t, ids, points)
        if report["state"]:
            path.append(report["state"]["p"])
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum() if path else 0.0
    print(f"{len(path)} of {len(frames)} images have a pose; the path is {length:.2f} m long; at last: {report['status']}")


# %% the picture
def draw(t, y, abc, costs):
    try:
        import matplotlib
    except ImportError:
        return print("without Matplotlib there is no picture")
    matplotlib.use("Agg")
    from matplotlib import pyplot
    _, (left, right) = pyplot.subplots(1, 2, figsize=(9, 3.2))
    left.plot(t, y, ".", t, np.exp(abc @ (t * t, t, np.ones_like(t))), linewidth=2)
    left.set(xlabel="t", ylabel="y", title="one point in ten is false")
    right.semilogy(costs, "o-")
    right.set(xlabel="iteration", ylabel="cost", title="convergence")
    pyplot.savefig("curve.png", dpi=120, bbox_inches="tight")
    print("curve.png")


# %% all of it
draw(*fit_a_curve())
slide_a_window()
if len(sys.argv) > 1:
    follow(sys.argv[1])
