"""Numbers of the chapter's studies: bundle adjustment, the Hessian, and the prior's weight."""
import numpy as np


class Chapter:
    """What the chapter's tables say."""

    def __init__(self, tables):
        self.tables = tables

    def solve(self, scene):
        """The summary of a scene's bundle adjustment."""
        return self.tables("mono_ba_summary").row(scene=scene)

    def spectrum(self, gauge):
        """(|eigenvalues| of H, ascending, and how many of them are zero)."""
        sizes = np.sort(np.abs(self.tables("spectrum", gauge=gauge)["eigenvalue"]))
        return sizes, int((sizes <= 1e-10 * sizes[-1]).sum())

    def rows_of_h(self, scene):
        """(rows of the poses, of all vertices) in a free H."""
        rows = self.tables("hessian_vertices", scene=scene)["rows"]
        return int(rows[rows > 1].sum()), int(rows.sum())

    def at(self, table, column, weight, **conditions):
        """The value at a weight of the prior."""
        return self.tables(table, **conditions).row(weight=weight)[column]

    def ends(self, table, column, **conditions):
        """The values at w = 0 and at the greatest weight."""
        values = self.tables(table, **conditions)[column]
        return values[0], values[-1]

    def spread(self, variant, column):
        """Greatest relative difference from w = 0, among the runs that converged."""
        rows = self.tables("prior_sweep", variant=variant)
        values = rows[column][rows["termination"] != "maximum of iterations"]
        return abs(values / rows[column][0] - 1).max()

    def peak(self, variant):
        """Weight and mean iterations where the trials need the most."""
        rows = self.tables("prior_trials", variant=variant)
        at = rows["mean_iterations"].argmax()
        return rows["weight"][at], rows["mean_iterations"][at]
