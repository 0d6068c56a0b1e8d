"""The words of the report: two sentences a figure, with every measured number taken from the tables."""
import style
from style import number


class Numbers:
    """Every number that the words of the page need, taken from the tables."""

    def __init__(self, directory):
        read = lambda name: style.read(directory, name)
        self.summary, self.sweep, self.trials = read("mono_ba_summary"), read("prior_sweep"), read("prior_trials")
        self.damping, self.fill, self.spectrum = read("prior_damping"), read("marginalize_fill"), read("spectrum")
        self.chain = read("marginalize_chain")

    def solve(self, name):
        return self.summary.row(scene=name)

    def null_dimension(self, gauge):
        values = self.spectrum.where(gauge=gauge)["eigenvalue"]
        return int((abs(values) <= 1e-10 * values.max()).sum())

    def ends(self, table, column, **conditions):
        """The values at w = 0 and at the greatest weight."""
        rows = table.where(**conditions)
        return rows[column][0], rows[column][-1]

    def spread(self, variant, column):
        """Greatest relative difference from w = 0, among the runs that converged."""
        rows = self.sweep.where(variant=variant)
        values = rows[column][rows["termination"] != "maximum of iterations"]
        return abs(values / rows[column][0] - 1).max()

    def peak(self, variant):
        """Weight and mean iterations where the trials need the most."""
        rows = self.trials.where(variant=variant)
        at = rows["mean_iterations"].argmax()
        return rows["weight"][at], rows["mean_iterations"][at]


def bundle_adjustment(n):
    small, large = n.solve("course"), n.solve("large")
    return {
        "scene_course": f"The course's scene: {small['frames']:.0f} cameras start at the truth, two of them fixed, and "
        f"{small['points']:.0f} points start at wrong depths, {number(small['initial_rmse_landmark_m'])} m from the truth. "
        f"{small['iterations']:.0f} "
        f"iterations bring the points to {number(1e3 * small['final_rmse_landmark_m'])} mm of the truth.",
        "scene_large": f"{large['frames']:.0f} cameras and {large['points']:.0f} points, the cameras perturbed too. "
        f"The points end {number(1e3 * large['final_rmse_landmark_m'])} mm and the cameras "
        f"{number(1e3 * large['final_rmse_position_m'])} mm from the truth, after a similarity takes the gauge out.",
        "mono_ba_convergence": f"On the large scene the cost falls from {number(large['initial_cost'])} to "
        f"{number(large['final_cost'])}. The damping λ shrinks with every good step, and the last steps shrink "
        "quadratically: Levenberg-Marquardt ends as Gauss-Newton.",
    }


def the_hessian(n):
    large = n.solve("large")
    return {
        "hessian_course": "Poses first, landmarks last: no residual ties two landmarks, so their corner is diagonal "
        "and cheap to invert. The Schur complement leaves a small system of the poses alone, and fills it.",
        "hessian_large": f"The same with {large['frames']:.0f} × {large['points']:.0f}: most rows are landmarks, and "
        "most of H is empty. Frame 0 hosts every landmark, hence the arrow among the poses that the Schur complement "
        "fills.",
        "spectrum": "A monocular reconstruction may be moved, turned and scaled at no cost: the free H has "
        f"{n.null_dimension('free')} zero eigenvalues, three for position, three for rotation, one for scale. A "
        f"minimal prior leaves {n.null_dimension('minimal prior')}, and so do the stronger gauges.",
    }


def marginalisation(n):
    shared = number(n.chain.where(stage="after")["value"][1], 6).replace("-", "−")
    before, after = n.fill.row(stage="before"), n.fill["null_dimension"][-1]
    return {
        "marginalize_chain": "The slides' chain of three scalars loses its middle one: first its row and column move "
        "to the end, then the Schur complement folds it into the others. The two that had no common entry now share "
        f"one, {shared}.",
        "marginalize_scene": f"H of a small scene is {100 * before['density']:.0f} % filled; taking variables away "
        f"fills in what they were tied to, so the order matters. What remains keeps its {after:.0f} free directions: "
        "marginalising adds no information.",
    }


def the_priors_weight(n):
    first, last = n.ends(n.sweep, "rmse_position", variant="perturbed")
    cost0, cost1 = n.ends(n.sweep, "reprojection_cost", variant="perturbed")
    weight, most = n.peak("perturbed")
    trials0, trials1 = n.ends(n.trials, "mean_iterations", variant="perturbed")
    identity0, identity1 = n.ends(n.damping, "iterations", damping="identity")
    diagonal0, diagonal1 = n.ends(n.damping, "iterations", damping="diagonal")
    return {
        "prior_sweep": "Two priors of six constraints hold seven free directions, so a strong prior on true poses also "
        f"informs: the RMSE falls from {number(1e3 * first)} to {number(1e3 * last)} mm. The minimal gauge changes "
        f"only the convergence, never the answer (by {number(n.spread('minimal', 'rmse_position'), 1)} of it at most).",
        "prior_costs": "Twelve constraints pull against the observations and raise their cost from "
        f"{number(cost0)} to {number(cost1)}; seven cannot. Frame 0 drifts the less the greater the weight.",
        "prior_traces": "With a weak prior the observations are satisfied in a few steps, and then the whole scene "
        "creeps along the free directions towards the prior. The course's variant creeps at great weights instead, and "
        "for another reason: see the last figure.",
        "prior_trials": f"Under the usual stop rules (cost to 10⁻⁶) a peak of {number(most)} iterations stands at "
        f"w = {number(weight, 1)}, between {number(trials0)} without a prior and {number(trials1)} with a strong one. "
        "Left of the peak it is the rule that gives up: the frame has not arrived.",
        "prior_damping": "The same problem from the same start, only the damping differs: λ₀ = τ max diag(H) grows "
        "once the weight outgrows H, and from there every factor of three costs one more iteration, from "
        f"{identity0:.0f} to {identity1:.0f} at the end. With damping in proportion to the diagonal it is "
        f"{diagonal0:.0f} and {diagonal1:.0f}: the usual rising curve is an artefact.",
    }


def sections(n):
    """Per section its title, and per figure its name and words."""
    return {"Bundle adjustment": bundle_adjustment(n), "The Hessian": the_hessian(n),
            "Marginalisation": marginalisation(n), "The prior's weight": the_priors_weight(n)}
