"""The trajectories of ch5_recording by the documented rules of evo (its wiki, "Formats") and of rpg_trajectory_evaluation (its
README, "Poses"), neither of which need be installed."""

import csv

import numpy as np

from tests.experiments.programs_under_test import AppTest
from tests.project import BUILD, run


def rows_of(path, delimiter, columns):
    """As both tools read: "#" begins a comment, one delimiter between two cells and none at the end, as many cells in each row."""
    text = path.read_text(encoding="ascii")
    assert text.endswith("\n") and "\r" not in text, path
    rows = [line.split(delimiter) for line in text.splitlines() if not line.startswith("#")]
    assert {len(row) for row in rows} == {columns} and all(cell == cell.strip() != "" for row in rows for cell in row), path
    return rows


def stamped(text) -> int:
    """Decimal seconds, such as 1403715273.262143232, in nanoseconds."""
    seconds, nanoseconds = text.split(".")
    assert len(nanoseconds) == 9, text
    return int(seconds) * 10**9 + int(nanoseconds)


def up(quaternion):
    """The world's z axis as the body sees it, which no alignment of position and yaw changes; w x y z."""
    w, x, y, z = quaternion.T
    return np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=1)


class TrajectoryFormats(AppTest):
    app = "ch5_recording"

    def test_both_tools_read_both_files(self):
        recording = self.folder / "room"
        run(BUILD / "tests" / "experiments" / "simulate_recording", recording, 14)
        imu = (recording / "imu.csv").read_text().splitlines(keepends=True)
        (recording / "imu.csv").write_text("".join(imu[:1201] + imu[1601:]))  # two seconds: a second segment
        self.solve(recording, "--out", self.out)
        with open(recording / "groundtruth.csv", encoding="ascii") as file:
            truth = {int(row[0]): row[1:] for row in csv.reader(file) if not row[0].startswith("#")}
        names = {path.stem for path in self.out.glob("*.tum")}
        self.assertEqual(names, {"vins", "vins_1", "okvis", "okvis_1"})
        for name in names:
            tum = rows_of(self.out / f"{name}.tum", " ", 8)  # seconds, p, q as x y z w
            euroc = rows_of(self.out / f"{name}.csv", ",", 17)  # nanoseconds, p, q as w x y z, v, b_g, b_a
            self.assertTrue((self.out / f"{name}.csv").read_text().startswith("#timestamp [ns],"))
            stamps = [int(row[0]) for row in euroc]
            self.assertEqual([stamped(row[0]) for row in tum], stamps)
            self.assertEqual(stamps, sorted(set(stamps)), "ascending, none twice")
            one, other = np.array([row[1:] for row in tum], float), np.array([row[1:8] for row in euroc], float)
            np.testing.assert_array_equal(one, other[:, [0, 1, 2, 4, 5, 6, 3]])
            np.testing.assert_allclose(np.linalg.norm(one[:, 3:], axis=1), 1.0, atol=1e-9)
            # By the data: a quaternion in another order, or from the world into the body, would tilt elsewhere.
            true = np.array([truth[stamp][3:7] for stamp in stamps], float)
            tilt = np.arccos(np.clip(np.sum(up(other[:, 3:]) * up(true), axis=1), -1.0, 1.0))
            self.assertLess(np.degrees(np.median(tilt)), 2.0, name)
            self.assertGreater(np.degrees(np.std(np.arccos(up(true)[:, 2]))), 1.0, "else any order would do")
