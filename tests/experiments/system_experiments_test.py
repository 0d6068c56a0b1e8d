"""What the experiments with the systems must show, on their first trials. Those that take long or measure time are kept
(experiments/evidence.json)."""

from tests.experiments import programs_under_test
from tests.project import BUILD

from ch5_backend.figures import tables


class SystemExperiments(programs_under_test.AppTest):
    app = "ch5_systems"

    def test_what_is_fixed_is_worse_and_far_too_certain(self):
        programs_under_test.make_trials(BUILD / "bin" / self.app, "ablation", 1, self.folder / "trial.csv")
        table = tables.read_table(self.folder / "trial.csv")
        for policy in ("vins", "okvis"):
            of = {row["way"]: row for row in table.where(policy=policy).rows()}
            self.assertGreater(of["dropped"]["restarts"], 0)
            for way in ("fixed", "poses fixed"):
                self.assertGreater(of[way]["ate_m"], 2 * of["marginalized"]["ate_m"], (policy, way))
                self.assertGreater(of[way]["nees_motion"], 100 * of["marginalized"]["nees_motion"], (policy, way))
            self.assertLess(of["first estimates"]["nees_motion"], 15)

    def test_an_unknown_study_and_a_trial_too_many_are_errors(self):
        for words, naming in ((("frobnicate",), "there is no study 'frobnicate'"),
                              (("pose_graphs", "--trial", 99), "pose_graphs has no trial 99")):
            done = self.program(*words, "--out", self.folder / "none.csv")
            self.assertEqual(done.returncode, 2)
            self.assertIn(naming, done.stderr)
