"""Numbers of the experiments with what OKVIS, VINS-Mono and g2o do, of ch5_systems' tables."""
import numpy as np

WAYS = ("dropped", "fixed", "poses fixed", "marginalized", "first estimates")
BACK_ENDS = {"schur": "Schur, Cholesky", "eigen okvis": "Schur, OKVIS's cut", "eigen vins": "Schur, VINS-Mono's cut",
             "qr": "QR", "qr float": "QR, float"}
SCHUR_ROOTS = ("schur", "eigen okvis", "eigen vins")
WINDOWS = ("vio_S", "vio_M", "vio_L")
RECORDINGS = {"simulated": "simulated", "euroc_v1_01_easy": "EuRoC V1_01", "tango_walk": "Tango"}
CALIBRATION_GOALS = {"offset_ms": 1.0, "rotation_deg": 0.3}
SILENT = (10.0, 12.0)  # s without the IMU, in `restart`
TEMPORAL = (2, 3, 5, 8)
DATA_SETS = ("intel", "MIT", "parking-garage", "sphere2500")
SOLVERS = {"dense": ("dense Cholesky", "C1"), "sparse": ("sparse Cholesky", "C0"), "cholmod": ("CHOLMOD", "C2"), "pcg": ("PCG", "C3")}


def median_over_flights(rows):
    """Each half second at which most flights have a value near it, and the medians there: no two flights start at the same time."""
    nearest = np.round(2 * rows["t_s"]) / 2
    times, counts = np.unique(nearest, return_counts=True)
    times = times[2 * counts > counts.max()]
    return times, np.array([np.median(rows["error"][nearest == t]) for t in times])


def over_keyframes(tables, recording, temporal, column):
    """The numbers of keyframes, and the mean over the trials."""
    rows = tables("window_size", recording=recording, temporal_frames=temporal)
    keyframes = np.unique(rows["keyframes"])
    return keyframes, np.array([rows.where(keyframes=k)[column].mean() for k in keyframes])


def least_cost(tables, data_set):
    """The least cost known of a pose graph, from whatever start."""
    return min(tables(name, data_set=data_set)["cost"].min() for name in ("pose_graphs", "pose_graph_starts"))


def false_loops(tables, data_set, kind, count):
    """Cells of a row, of all draws: false loops given up/all, good ones with them, and how far positions end from the optimum without
    false loops, with --gnc and without, mean ± standard error [m]."""
    gnc, plain = (tables("false_loops", data_set=data_set, kind=kind, false_loops=count, way=way) for way in ("gnc", "plain"))
    off = [f"{rows['rmse_m'].mean():.2f} ± {rows['rmse_m'].std(ddof=1) / np.sqrt(len(rows)):.2f}" for rows in (gnc, plain)]
    return " | ".join([f"{gnc['found'].sum():.0f}/{gnc['false_loops'].sum():.0f}", f"{gnc['good_lost'].sum():.0f}", *off])


def solves(tables, **which):
    """A row a solve: median time of an iteration, memory, iterations, costs."""
    every = tables("pose_graphs", **which)
    found = []
    for data_set in DATA_SETS:
        rows = every.where(data_set=data_set)
        if len(rows) < 2:
            continue
        found.append({"data_set": data_set, "unknowns": rows["unknowns"][0], "poses": rows["poses"][0],
                      "edges": rows["edges"][0], "iterations": rows["iteration"].max(),
                      "milliseconds": 1e3 * np.median(np.diff(rows["seconds"])), "megabytes": rows["megabytes"][0],
                      "first": rows["cost"][0], "last": rows["cost"][-1]})
    return found


def lost_to_schur(tables):
    """QR's row at the first σ, in steps of ten, at which no root of Schur's knows anything of the worst direction: its
    error is 1 where the root has dropped it, and more where it makes it up."""
    of = {name: tables("back_ends", window="simulated", back_end=name) for name in ("qr", *SCHUR_ROOTS)}
    lost = np.all([of[name]["worst_error"] >= 1 - 1e-9 for name in SCHUR_ROOTS], axis=0)
    return of["qr"].rows()[np.argmax(lost)]


def qr_by_schur(tables):
    """QR's time by Schur's on the recorded windows, ascending."""
    qr, schur = ([tables("back_ends", window=window, back_end=name)["microseconds"][0] for window in WINDOWS]
                 for name in ("qr", "schur"))
    return sorted(np.divide(qr, schur))


def rotation_by_sample(tables):
    """{IMU's rate: σ of a rotation as VINS-Mono's σ of a sample claims it, by the measured one}"""
    turns = tables("preintegration", quantity="rotation", seconds=0.5)
    return dict(zip(turns["rate_hz"], turns["claimed_per_sample"] / turns["measured"]))


def by_sparse(tables, solver, data_set):
    """The time of an iteration by that of our sparse Cholesky."""
    times = [next(one["milliseconds"] for one in solves(tables, solver=name, algorithm="Levenberg-Marquardt")
                  if one["data_set"] == data_set) for name in (solver, "sparse")]
    return times[0] / times[1]


def end_by_least(tables, data_set, algorithm):
    """The cost where an algorithm ends, by the least that is known."""
    end = tables("pose_graphs", data_set=data_set, solver="sparse", algorithm=algorithm)["cost"][-1]
    return end / least_cost(tables, data_set)
