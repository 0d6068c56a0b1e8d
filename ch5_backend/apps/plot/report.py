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

import captions
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
table { margin-top: 1.2rem; border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .55rem; text-align: right; border-bottom: 1px solid var(--line); white-space: nowrap; }
th { background: var(--pale); font-weight: 600; }
th:first-child, td:first-child { text-align: left; }
nav { columns: 2; }
nav a { display: block; }
code { background: var(--pale); padding: .1em .3em; border-radius: .2em; }
"""


def solves_table(n):
    """The table of the solves."""
    head = ("scene", "frames × points", "unknowns", "edges", "first cost", "last cost", "iterations",
            "time [ms]", "stopped by")
    rows = []
    for i in range(len(n.summary)):
        row = {name: column[i] for name, column in n.summary.columns.items()}
        rows.append((row["scene"], f"{row['frames']:.0f} × {row['points']:.0f}", f"{row['unknowns']:.0f}",
                     f"{row['edges']:.0f}", captions.number(row["initial_cost"]), captions.number(row["final_cost"], 4),
                     f"{row['iterations']:.0f}", captions.number(row["milliseconds"], 2), row["termination"]))
    cells = lambda tag, row: "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in row) + "</tr>"
    return ('<div class="scroll"><table>\n' + cells("th", head) + "\n" + "\n".join(cells("td", row) for row in rows) +
            "\n</table></div>\n"
            "<p>Cost: ½ Σ rᵀWr. The small scene has W = I as in the course, the large one W = 1/σ².</p>")


def page(directory):
    """The whole page as text, pictures embedded."""
    n = captions.Numbers(directory)
    sections = captions.sections(n)
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
