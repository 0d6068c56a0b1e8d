#!/usr/bin/python3
"""Draws every figure of the chapter and writes one self-contained page, DIR/report.html.

usage: report.py [DIR]        DIR is out/ unless given; ch5_chapter --out DIR must have filled DIR/csv

Tables, DIR/csv (one row of names, then numbers; metres, radians; costs are ½ Σ rᵀWr):
  mono_ba_summary.csv    one row a scene ("course" 3×20, "large" 10×300): sizes, costs, iterations, RMSE, termination
  mono_ba_trace.csv      scene,iteration,cost,lambda,gain_ratio,step_norm,gradient_max,trials,seconds
  mono_ba_frames.csv     scene,state,frame,x_m…qw       state: truth, initial, final (aligned by a similarity)
  mono_ba_points.csv     scene,state,point,x_m,y_m,z_m
  hessian.csv            scene,matrix,row,column,value  matrix: H (poses, then landmarks; gauge free), S (Schur)
  spectrum.csv           gauge,index,eigenvalue         of H, 3×20 scene, W = 1/σ²
  marginalize_chain.csv  stage,row,column,value         stage: before, moved, after; the slides' 3×3
  marginalize_scene.csv  stage,row,column,value         non-zeros of a 5×12 scene's H as it loses variables
  marginalize_fill.csv   stage,size,non_zeros,density,null_dimension
  prior_sweep.csv        variant,weight,…               variant: course, perturbed, minimal; tight stop rules
  prior_trace.csv        variant,weight,iteration,cost,lambda
  prior_trials.csv       variant,weight,… means over many scenes, usual stop rules
  prior_damping.csv      damping,weight,… the course's variant, identity against diagonal damping

Figures, DIR/figures/NAME.png and NAME.svg:
  scene_course, scene_large        cameras and points in 3-D, before and after
  mono_ba_convergence              cost, λ and step against the iteration
  hessian_course, hessian_large    H and its Schur complement
  spectrum                         eigenvalues of H: seven zeros without a gauge
  marginalize_chain                the slides' chain of three, with numbers
  marginalize_scene                fill-in: landmarks first, or a frame first
  prior_sweep                      iterations, time and RMSE against the weight, one scene
  prior_costs                      reprojection cost, prior cost and drift against the weight
  prior_traces                     cost against iteration, one line a weight
  prior_trials                     mean iterations and drift over many scenes under the usual stop rules
  prior_damping                    identity against diagonal damping: where the usual curve comes from
"""

import base64
import html
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import convergence
import hessian
import marginalize
import prior
import scene
import style

# The longest first, so that two processes finish together.
SCRIPTS = (prior, scene, hessian, convergence, marginalize)

CSS = """
:root { color-scheme: light dark; --ink: #222; --paper: #fff; --pale: #f4f4f2; --line: #d9d9d9; --accent: #0072b2; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e6e6; --paper: #17191c; --pale: #22252a; --line: #3a3e44; --accent: #56b4e9; }
}
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 62rem; padding: 2rem 1.2rem 4rem; background: var(--paper); color: var(--ink);
       font: 1rem/1.6 system-ui, sans-serif; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .4rem; }
h2 { font-size: 1.3rem; margin: 3rem 0 .5rem; padding-top: .8rem; border-top: 1px solid var(--line); }
a { color: var(--accent); }
figure { margin: 1.4rem 0 2rem; }
figure img { width: 100%; background: #fff; border: 1px solid var(--line); border-radius: .5rem; padding: .6rem; }
figcaption { margin-top: .5rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: .35rem .7rem; text-align: right; border-bottom: 1px solid var(--line); white-space: nowrap; }
th { background: var(--pale); font-weight: 600; }
th:first-child, td:first-child { text-align: left; }
nav { columns: 2; }
nav a { display: block; }
code { background: var(--pale); padding: .1em .3em; border-radius: .2em; }
"""


def number(value, digits=3):
    """A number for reading: 0.0132, 4620, 2.17 × 10⁹."""
    if value == 0:
        return "0"
    if 1e-3 <= abs(value) < 1e5:
        return f"{value:.{digits}g}" if abs(value) < 10**digits else f"{value:.0f}"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    power = style.power_of_ten(int(exponent))
    return power if float(mantissa) == 1 else f"{mantissa} × {power}"


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


def captions(n):
    """Per section: its title, and per figure the two sentences that explain it."""
    small, large = n.solve("course"), n.solve("large")
    prior_entries = n.chain.where(stage="after")["value"]
    first, last = n.ends(n.sweep, "rmse_position", variant="perturbed")
    cost0, cost1 = n.ends(n.sweep, "reprojection_cost", variant="perturbed")
    weight, most = n.peak("perturbed")
    trials0, trials1 = n.ends(n.trials, "mean_iterations", variant="perturbed")
    identity0, identity1 = n.ends(n.damping, "iterations", damping="identity")
    diagonal0, diagonal1 = n.ends(n.damping, "iterations", damping="diagonal")
    before = n.fill.row(stage="before")
    return {
        "Bundle adjustment": {
            "scene_course": f"The course's scene: {small['frames']:.0f} cameras start at the truth, two of them fixed, "
            f"and {small['points']:.0f} points start at depths that are wrong by about a metre. "
            f"{small['iterations']:.0f} iterations bring the points to {number(1e3 * small['final_rmse_landmark_m'])} mm "
            "of the truth.",
            "scene_large": f"{large['frames']:.0f} cameras and {large['points']:.0f} points, the cameras perturbed too. "
            f"The points end {number(1e3 * large['final_rmse_landmark_m'])} mm and the cameras "
            f"{number(1e3 * large['final_rmse_position_m'])} mm from the truth, after a similarity takes the gauge out.",
            "mono_ba_convergence": f"The cost falls from {number(large['initial_cost'])} to "
            f"{number(large['final_cost'])} on the large scene. The damping λ shrinks with every good step, and the "
            "last steps shrink quadratically: Levenberg-Marquardt ends as Gauss-Newton.",
        },
        "The Hessian": {
            "hessian_course": "Poses first, landmarks last: no residual ties two landmarks, so their corner is "
            "diagonal and cheap to invert. The Schur complement leaves a small system of the poses alone, and fills it.",
            "hessian_large": f"The same with {large['frames']:.0f} × {large['points']:.0f}: most rows are landmarks, and "
            "most of H is empty. Frame 0 hosts every landmark, hence the arrow among the poses that the Schur "
            "complement fills.",
            "spectrum": f"A monocular reconstruction may be moved, turned and scaled at no cost: the free H has "
            f"{n.null_dimension('free')} zero eigenvalues, three for position, three for rotation, one for scale. "
            f"A minimal prior leaves {n.null_dimension('minimal prior')}, and so do the stronger gauges.",
        },
        "Marginalisation": {
            "marginalize_chain": "The slides' chain of three scalars loses its middle one: first its row and column move "
            "to the end, then the Schur complement folds it into the others. The two that had no common entry now share "
            f"one, {number(prior_entries[1], 6)}.".replace("-", "−"),
            "marginalize_scene": f"H of a scene of five frames and twelve points is {100 * before['density']:.0f} % "
            "filled; taking variables away fills in what they were tied to, so the order matters. "
            f"What remains keeps its {n.fill['null_dimension'][-1]:.0f} free directions: marginalising adds no "
            "information.",
        },
        "The prior's weight": {
            "prior_sweep": f"Two priors of six constraints hold seven free directions, so a strong prior on true poses "
            f"also informs: the RMSE falls from {number(1e3 * first)} to {number(1e3 * last)} mm. The minimal gauge "
            f"changes only the convergence, never the answer (by {number(n.spread('minimal', 'rmse_position'), 1)} at "
            "most, relatively).",
            "prior_costs": f"Twelve constraints pull against the observations and raise their cost from {number(cost0)} to "
            f"{number(cost1)}; seven cannot. Frame 0 drifts the less the greater the weight.",
            "prior_traces": "With a weak prior the observations are satisfied in five steps, and then the whole scene "
            "creeps along the free directions towards the prior. The course's variant creeps at great weights "
            "instead, and for another reason: see the last figure.",
            "prior_trials": f"Under the usual stop rules (cost to 10⁻⁶) a peak of {number(most)} iterations stands at "
            f"w = {number(weight, 1)}, between {number(trials0)} without a prior and {number(trials1)} with a strong "
            "one. Left of the peak it is the rule that gives up: the frame has not arrived.",
            "prior_damping": f"The same problem, the same start, only the damping differs: λ₀ = τ max diag(H) grows with "
            f"the weight, and every factor of three costs one more iteration, {identity0:.0f} → {identity1:.0f}. "
            f"Damping in proportion to the diagonal takes {diagonal0:.0f} → {diagonal1:.0f}: the usual rising curve is "
            "an artefact.",
        },
    }


def solves_table(n):
    """The table of the solves."""
    head = ("scene", "frames × points", "unknowns", "residuals' edges", "first cost", "last cost", "iterations",
            "time [ms]", "stopped by")
    rows = []
    for i in range(len(n.summary)):
        row = {name: column[i] for name, column in n.summary.columns.items()}
        rows.append((row["scene"], f"{row['frames']:.0f} × {row['points']:.0f}", f"{row['unknowns']:.0f}",
                     f"{row['edges']:.0f}", number(row["initial_cost"]), number(row["final_cost"], 4),
                     f"{row['iterations']:.0f}", number(row["milliseconds"], 2), row["termination"]))
    cells = lambda tag, row: "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in row) + "</tr>"
    return ('<div class="scroll"><table>\n' + cells("th", head) + "\n" + "\n".join(cells("td", row) for row in rows) +
            "\n</table></div>\n<p>Cost: ½ Σ rᵀWr. The small scene has W = I as in the course, the large one W = 1/σ².</p>")


def page(directory):
    """The whole page as text, pictures embedded."""
    n = Numbers(directory)
    sections = captions(n)
    anchor = lambda title: title.lower().replace("'", "").replace(" ", "-")
    body = ["<h1>Chapter 5: a hand-written back end at work</h1>",
            "<p>Simulated scenes, solved by the code of this repository; every number below is read from the tables "
            "beside this page.</p>",
            "<nav>" + "".join(f'<a href="#{anchor(title)}">{html.escape(title)}</a>' for title in sections) +
            '<a href="#tables">Tables</a></nav>', solves_table(n)]
    for title, figures in sections.items():
        body.append(f'<h2 id="{anchor(title)}">{html.escape(title)}</h2>')
        for name, caption in figures.items():
            data = base64.b64encode((Path(directory) / "figures" / f"{name}.png").read_bytes()).decode()
            text = html.escape(caption, quote=False)
            body.append(f'<figure><img alt="{name.replace("_", " ")}" src="data:image/png;base64,{data}">'
                        f'<figcaption>{text} <a href="figures/{name}.svg">SVG</a></figcaption></figure>')
    tables = sorted(path.name for path in (Path(directory) / "csv").glob("*.csv"))
    links = "".join(f'<li><a href="csv/{name}">{name}</a></li>' for name in tables)
    body.append(f'<h2 id="tables">Tables</h2>\n<ul>{links}</ul>')
    return ('<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<title>Chapter 5 report</title><style>{CSS}</style></head>\n<body>\n" + "\n".join(body) +
            "\n</body></html>\n")


def draw_one(index, directory):
    SCRIPTS[index].draw(directory)


def draw(directory):
    """All figures and the page."""
    with ProcessPoolExecutor(max_workers=min(len(SCRIPTS), os.cpu_count() or 1)) as pool:
        for done, _ in enumerate(pool.map(draw_one, range(len(SCRIPTS)), [directory] * len(SCRIPTS)), start=1):
            if sys.stderr.isatty():
                print(f"\r\033[Kfigures {done} of {len(SCRIPTS)}", end="", file=sys.stderr, flush=True)
    partial = Path(directory) / "report.html.partial"
    partial.write_text(page(directory), encoding="utf-8")
    partial.replace(Path(directory) / "report.html")
    if sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr)


if __name__ == "__main__":
    style.main(draw)
