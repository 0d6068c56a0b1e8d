"""A student's run beside the solution's: where the two first differ, and by how much."""
import json
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..tables import TableError, read_table

EXPERIMENTS = {"hessian": ("1.1", "1.2"), "marginal": ("2",), "weights": ("3",), "gauge": ("4",), "okvis": ("5",),
               "vins": ("6",), "blocks": ("7",), "beacons": ("8",)}
FLIGHTS = ("okvis", "vins")
BUILT_ON = {"weights": "hessian"}  # whose H and solver are the student's too
SAME = 1e-6       # relative: other orders of summation stay far below
SAME_PATH = 1e-3  # [m]


class Finding(NamedTuple):
    """What a run shows: the key of its sentence and the values in it."""
    key: str
    values: dict

    @property
    def same(self):
        return self.key == "same"


class Mine:
    """The runs of one folder."""

    def __init__(self, directory):
        self.place = Path(directory) / "mine"
        told = json.loads((self.place / "runs.json").read_text(encoding="utf-8"))
        self.files, self.failures = told["files"], told["experiments"]

    @cache
    def table(self, experiment, side, name):
        """A table of "own" or "solution"; None where the run broke off before it, or the table has no row."""
        try:
            return read_table(self.place / experiment / side / f"{name}.csv")
        except TableError:
            return None

    def both(self, experiment, name):
        return self.table(experiment, "own", name), self.table(experiment, "solution", name)

    def empty_todos(self, file):
        """{TODO: function} of what the solution does in place of the student."""
        return {todo: function for function, todos in self.files[file]["unfinished"].items() for todo in todos}

    @cache
    def finding(self, experiment):
        """Where the two runs first differ."""
        if experiment in FLIGHTS:
            found = self._flight(experiment)
        else:
            found = {"hessian": self._hessian, "marginal": self._matrices, "weights": self._weights,
                     "gauge": self._deviations, "blocks": self._convergence,
                     "beacons": self._convergence}[experiment](experiment)
        failure = self.failures[experiment]
        return Finding("failed", {"message": failure}) if failure and found.same else found

    def wrong_stage(self, experiment):
        """The stage whose lines the first difference shows, be it one that another experiment tries; None without any."""
        before = BUILT_ON.get(experiment)
        if before in self.failures and (wrong := self.wrong_stage(before)):
            return wrong
        found = self.finding(experiment)
        if found.same:
            return None
        is_first = self.table(experiment, "own", "matrices") is None or found.values.get("name") in ("H", "b")
        return EXPERIMENTS[experiment][0 if is_first else -1]

    # ---- Where two tables first differ --------------------------------------------------------------------------

    def _hessian(self, experiment):
        found = self._matrices(experiment)
        return self._convergence(experiment) if found.same else found

    def _matrices(self, experiment):
        own, solution = self.both(experiment, "matrices")
        if own is None:
            return self._nothing(experiment)
        for name in dict.fromkeys(solution["matrix"].tolist()):
            if self.failures[experiment] and name not in own["matrix"]:
                return self._nothing(experiment)
            a, b = (dense_of(table, name, solution) for table in (own, solution))
            wrong = different(a, b)
            if wrong.any():
                row, column = np.argwhere(wrong)[0]
                return Finding("matrix", {"name": name, "row": row, "column": column, "own": a[row, column],
                                          "solution": b[row, column], "wrong": int(wrong.sum()), "of": b.size})
        return Finding("same", {})

    def _convergence(self, experiment):
        return self._rows(experiment, "convergence", "iteration", ("iteration",), ("cost",))

    def _weights(self, experiment):
        return self._rows(experiment, "weights", "weight", ("variant", "weight"), ("iterations", "cost"))

    def _deviations(self, experiment):
        return self._rows(experiment, "deviations", "deviation", ("gauge", "keyframe"),
                          ("position_m", "rotation_deg", "velocity_m_s"))

    def _rows(self, experiment, table, key, at, columns):
        """The first row in which one of the columns differs, or that only one of the two tables has."""
        own, solution = self.both(experiment, table)
        if own is None:
            return self._nothing(experiment)
        pairs = list(zip(own.rows(), solution.rows()))
        for a, b in pairs:
            for column in columns:
                if different(np.array([a[column]]), np.array([b[column]])).any():
                    return Finding(key, {**{name: b[name] for name in at}, "column": column, "own": a[column],
                                         "solution": b[column]})
        if len(own) != len(solution):
            return Finding("length", {"own": len(own), "solution": len(solution)})
        return Finding("same", {})

    def _flight(self, experiment):
        """The first image whose position is not the solution's, and the errors at the end."""
        own, solution = self.both(experiment, "path")
        if own is None:
            return self._nothing(experiment)
        image, t, distance = self.distance(experiment)
        apart = np.flatnonzero(~(distance <= SAME_PATH))
        if len(apart):
            found = {"t": t[apart[0]], "image": image[apart[0]], "apart": distance[apart[-1]],
                     "restarts": self.restarts(experiment, "own"), "solution_restarts": self.restarts(experiment, "solution")}
            if self.table(experiment, "solution", "truth") is None:
                return Finding("flight", found)
            return Finding("flight_with_truth", {**found, "error": self.error_at_end(experiment, "own"),
                                                 "solution": self.error_at_end(experiment, "solution")})
        if len(own) != len(solution):
            return Finding("silent", {"own": len(own), "solution": len(solution)})
        return Finding("same", {})

    def _nothing(self, experiment):
        return Finding("failed", {"message": self.failures[experiment] or "–"})

    # ---- Flights ------------------------------------------------------------------------------------------------

    def distance(self, experiment):
        """(image, t, ‖own − solution‖) of those that both have answered; NaN and infinity stay what they are."""
        own, solution = self.both(experiment, "path")
        image, a, b = np.intersect1d(own["image"], solution["image"], return_indices=True)
        return image, own["t_s"][a], np.linalg.norm(points(own)[a] - points(solution)[b], axis=1)

    def path(self, experiment, side):
        """n×3 positions, laid upon the truth as the solution's are: both begin alike."""
        table, summary = self.table(experiment, side, "path"), self.table(experiment, "solution", "summary")
        if table is None:
            return np.empty((0, 3))
        if summary is None or np.isnan(summary["yaw_rad"][0]):
            return points(table)
        c, s = np.cos(summary["yaw_rad"][0]), np.sin(summary["yaw_rad"][0])
        return points(table) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T + points(summary)[0]

    def truth(self, experiment):
        table = self.table(experiment, "solution", "truth")
        return np.empty((0, 3)) if table is None else points(table)

    def restarts(self, experiment, side):
        summary = self.table(experiment, side, "summary")
        return "–" if summary is None else int(summary["restarts"][0])

    def error_at_end(self, experiment, side):
        """Distance from the truth at the last image with an estimate [m]."""
        truth, table = self.table(experiment, "solution", "truth"), self.table(experiment, side, "path")
        there = [np.interp(table["t_s"][-1], truth["t_s"], column) for column in points(truth).T]
        return float(np.linalg.norm(self.path(experiment, side)[-1] - there))


def points(table):
    return table.matrix("x_m", "y_m", "z_m")


def different(a, b):
    """Which entries are not the same; a NaN is not, unless both are."""
    scale = max(np.abs(b[np.isfinite(b)]).max(initial=0), 1e-300)
    return ~((np.abs(a - b) <= SAME * scale) | (np.isnan(a) & np.isnan(b)))


def dense_of(table, name, solution):
    """The matrix `name` of a table, as large as the solution's."""
    there = solution.where(matrix=name)
    matrix = np.zeros((int(there["row"].max()) + 1, int(there["column"].max()) + 1))
    for row in table.where(matrix=name).rows():
        if row["row"] < matrix.shape[0] and row["column"] < matrix.shape[1]:
            matrix[int(row["row"]), int(row["column"])] = row["value"]
    return matrix
