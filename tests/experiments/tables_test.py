"""ch5_chapter's tables and the figures drawn from them. CH5_CHAPTER names the executable."""

import math
import os
import re
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

sys.dont_write_bytecode = True
from ch5_backend.figures import marginalize, report, style, tables, translate
from ch5_backend.figures.numbers.windows import KEPT
from ch5_backend.figures.words import Words
from tests.experiments import report_texts
from tests.folder import FolderTest
from tests.project import ROOT, run

CHAPTER = os.environ["CH5_CHAPTER"]


class Columns(FolderTest):
    """What a column of words in a file is: numbers, or names."""

    def test_of_digits(self):
        for cells, wanted in (("1,8646911284551352321", ["1", "8646911284551352321"]),  # GTSAM's ids: a float would round
                              ("0,7", [0.0, 7.0]),
                              ("1.5,12345678901234567890", [1.5, 12345678901234567890.0]),  # costs
                              ("2,", [2.0, math.nan])):
            path = self.folder / "one.csv"
            path.write_text("other,column\n" + "".join(f"0,{cell}\n" for cell in cells.split(",")), encoding="utf-8")
            np.testing.assert_array_equal(tables.read_table(path)["column"], wanted)


class Missing(unittest.TestCase):
    def test_what_brings_a_table_back_is_said(self):
        for folder, kept, ways in (("out/csv", None, "; run ./course run first"), ("kept", Path("kept"), "; git checkout kept brings .*"),
                                   ("out/csv", Path("kept"), "; run ./course run first; git checkout kept brings .*")):
            with self.assertRaisesRegex(tables.TableError, f"^{folder}/none.csv is missing{ways}$"):
                tables.Tables(folder, kept)("none")


class Tables(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.out = Path(folder.name) / "out"
        cls.done = run(CHAPTER, "--out", cls.out)

    def test_chapter_succeeds_and_is_quiet_in_a_pipe(self):
        self.assertEqual((self.done.returncode, self.done.stdout, self.done.stderr), (0, "", ""))

    def test_every_table_in_the_list_exists_with_its_columns_and_no_other(self):
        listed = tables.read_table(ROOT / "ch5_backend/experiments/tables.csv").where(program="ch5_chapter").rows()
        self.assertEqual({path.stem: " ".join(tables.read_table(path, may_be_empty=True).columns) for path in (self.out / "csv").iterdir()},
                         {row["table"]: row["columns"] for row in listed})

    def test_each_scene_converges_much_nearer_to_the_truth(self):
        for row in tables.read(self.out, "mono_ba_summary").rows():
            self.assertIn("converged", row["termination"], row["scene"])
            self.assertLess(row["final_rmse_landmark_m"], 0.05 * row["initial_rmse_landmark_m"], row["scene"])

    def test_sweep_has_a_row_for_each_variant_and_weight(self):
        sweep = tables.read(self.out, "prior_sweep")
        for variant in ("course", "perturbed", "minimal"):
            weights = sweep.where(variant=variant)["weight"]
            self.assertEqual(len(weights), 28)
            self.assertEqual((weights[0], weights[1], weights[-1]), (0.0, 1e-3, 1e10))
        self.assertEqual(len(sweep), 3 * 28)
        # W = w nnᵀ of the minimal gauge is rank one but for its rounding, w·1e-16: rᵀWr of a residual of less than a
        # meter across n may fall as far below zero.
        self.assertTrue((sweep["prior_cost"] >= -1e-16 * sweep["weight"]).all())
        for column in sweep.columns.keys() - {"variant", "weight", "termination", "prior_cost"}:
            self.assertTrue((sweep[column] >= 0).all(), column)
        self.assertTrue((sweep["milliseconds"] > 0).all())
        self.assertTrue((sweep["cost_evaluations"] >= sweep["iterations"]).all())

    def test_traces_end_where_the_sweep_says(self):
        sweep, trace = tables.read(self.out, "prior_sweep"), tables.read(self.out, "prior_trace")
        for variant in ("course", "minimal"):
            for weight in (0.0, 1.0, 1e10):
                row = sweep.row(variant=variant, weight=weight)
                cost = trace.where(variant=variant, weight=weight)["cost"]
                total = row["reprojection_cost"] + row["prior_cost"]
                self.assertAlmostEqual(cost[-1] / total, 1.0, delta=1e-12)
                self.assertTrue((cost[1:] <= cost[:-1]).all())

    def test_blocks_of_the_hessian_are_those_that_edges_and_landmarks_made(self):
        names = ("hessian", "hessian_vertices", "hessian_blocks")
        for scene, edges in (("course", 40), ("large", 2700)):
            entries, vertices, blocks = (tables.read(self.out, name).where(scene=scene) for name in names)
            vertex_of = {first + k: vertex for vertex, first, rows in
                         zip(*(vertices[name] for name in ("vertex", "first_row", "rows"))) for k in range(int(rows))}
            for matrix in ("H", "S"):
                of, made = entries.where(matrix=matrix), blocks.where(matrix=matrix)
                filled = {(vertex_of[row], vertex_of[column]) for row, column in zip(of["row"], of["column"])}
                self.assertEqual({(i, j) for i, j in filled if i >= j}, set(zip(made["row_vertex"], made["column_vertex"])))
            rows = [*zip(*(blocks.where(matrix="S", by="landmark")[name] for name in ("number", "row_vertex", "column_vertex")))]
            self.assertEqual(rows, sorted(rows), "the order of each run")
            corner = blocks.where(matrix="H", row_vertex=0, column_vertex=0)
            self.assertEqual(len(set(corner["number"])), edges, "frame 0 hosts every landmark")

    def test_both_policies_slide_the_same_window_and_only_vins_uses_observations_twice(self):
        table = tables.read(self.out, "slide_observations")
        seen = {policy: sorted(zip(rows["landmark"], rows["frame"])) for policy in ("vins", "okvis")
                for rows in [table.where(policy=policy)]}
        self.assertEqual(seen["vins"], seen["okvis"])
        self.assertEqual(len(set(seen["vins"])), len(seen["vins"]), "an observation with two fates")
        again = {policy: len(table.where(policy=policy, fate="again")) for policy in seen}
        self.assertGreater(again["vins"], 10)
        self.assertEqual(again["okvis"], 0)
        for policy in seen:
            for fate in ("prior", "lost", "stays"):
                self.assertGreater(len(table.where(policy=policy, fate=fate)), 0, (policy, fate))

    def test_a_slide_marginalizes_what_its_policy_says(self):
        table, priors = tables.read(self.out, "slide_vertices"), tables.read(self.out, "slide_priors")
        for policy, speeds in (("vins", [0]), ("okvis", [0, 1, 2, 3])):
            gone = table.where(policy=policy, fate="marginalized")
            self.assertEqual(list(gone.where(vertex="pose")["number"]), [0], policy)
            self.assertEqual(list(gone.where(vertex="speed")["number"]), speeds, policy)
            held, after = table.where(policy=policy, fate="in the prior"), priors.row(policy=policy, stage="after")
            self.assertEqual(after["columns"], held["rows"].sum(), policy)
            self.assertLessEqual(after["rank"], after["columns"] - 3, "position is free")
            self.assertEqual(priors.row(policy=policy, stage="before")["null_dimension"], 4)

    def test_a_keyframe_takes_landmarks_along_and_another_frame_does_not(self):
        gone = tables.read(self.out, "film_vertices").where(fate="marginalized")
        kinds = {case: set(gone.where(case=case)["vertex"].tolist()) for case in ("keyframe", "no keyframe")}
        self.assertEqual(kinds, {"keyframe": {"pose", "speed", "landmark"}, "no keyframe": {"pose", "speed"}})

    def test_the_film_has_covariances_and_a_prior_of_what_the_slide_has_left(self):
        blocks, vertices, frames = (tables.read(self.out, f"film_{name}") for name in ("blocks", "vertices", "frames"))
        for policy in ("vins", "okvis"):
            of = frames.where(policy=policy)
            self.assertTrue(np.all(of["xx_m2"] * of["yy_m2"] > of["xy_m2"] ** 2) and np.all(of["xx_m2"] > 0), policy)
            apart = [np.hypot(row["x_m"] - row["true_x_m"], row["y_m"] - row["true_y_m"]) / np.sqrt(row["xx_m2"] + row["yy_m2"])
                     for row in of.rows() if row["frame"] == row["image"]]
            self.assertLess(np.median(apart), 2, "of what is claimed")
            gone = {(row["image"], row["row"]) for row in vertices.where(policy=policy, fate="marginalized").rows()}
            left = blocks.where(policy=policy, stage="prior")
            self.assertGreater(left["fill"].sum(), 30, policy)
            for side in ("window_row", "window_column"):
                self.assertFalse(gone & set(zip(left["image"], left[side])), "in the prior is nothing that has left")
            self.assertEqual(blocks.where(policy=policy, stage="window")["fill"].sum(), 0)

    def test_each_kept_table_tells_when_it_was_measured(self):
        kept = {path.stem for path in KEPT.folder.glob("*.csv")} - {"measured"}
        self.assertEqual(set(KEPT("measured")["table"]), kept)
        self.assertLessEqual({name for names in report.KEPT_OF.values() for name in names}, kept)
        self.assertTrue(all(KEPT("measured")["date"]))

    def test_after_a_second_without_imu_a_segment_begins_which_is_nearer_the_truth_alone(self):
        for policy in ("vins", "okvis"):
            rows = tables.read(self.out, "restart").where(policy=policy)
            self.assertEqual(set(rows["segment"]), {0, 1}, policy)
            self.assertLess(rows["error_m"].mean(), rows["joint_error_m"].mean(), policy)

    def test_figures_are_the_same_to_the_byte_when_drawn_again(self):
        def drawn():
            marginalize.chain(self.out)
            return {path.name: path.read_bytes() for path in (self.out / "figures").glob("marginalize_chain.*")}

        first, second = drawn(), drawn()
        self.assertEqual(sorted(first), [f"marginalize_chain.{kind}" for kind in (
            "pdf", "png", "svg", *["zh.png", "zh.svg"] * bool(translate.font()))])
        self.assertIn(b">move</text>", first["marginalize_chain.svg"])
        self.assertIn(b"/CIDFontType2", first["marginalize_chain.pdf"])  # TrueType
        self.assertEqual(first, second)
        self.assertTrue(first["marginalize_chain.png"].startswith(b"\x89PNG"))

    def test_page_explains_every_figure_with_the_tables_numbers(self):
        figures = self.out / "figures"
        figures.mkdir(exist_ok=True)
        say = Words("en")
        for name in report_texts.figures_of(self.out):
            if not (figures / f"{name}.png").exists():
                style.plt.imsave(figures / f"{name}.png", [[0.0]])
        page = "".join(report.body_of(self.out, say))
        self.assertIn("−8.16327", page)
        self.assertIn("has 7 zero eigenvalues", page)
        self.assertNotIn("nan", re.sub(r'src="[^"]*"', "", page))
        self.assertNotRegex(re.sub(r'src="data:[^"]*"', "", page), r'(src|href)="(https?:|/)')


class BadInput(FolderTest):
    def test_plots_name_the_table_and_line_at_fault(self):
        table = self.folder / "csv" / "consistency.csv"
        table.parent.mkdir()
        for text, words in ((None, "No such file"), ("", "no rows"), ("a,b\n1,2\n3\n", "line 3"), ("\xff", "read")):
            with self.subTest(text=text):
                if text is not None:
                    table.write_text(text, encoding="latin-1")
                done = run(sys.executable, "-m", "ch5_backend.figures.nees", self.folder)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertRegex(done.stderr, "^nees.py: ")
                self.assertIn("consistency.csv", done.stderr)
                self.assertIn(words, done.stderr)
                self.assertFalse((self.folder / "figures").exists())
