#!/usr/bin/python3
"""Draws every figure of the chapter and writes one self-contained page, DIR/report.html.

usage: report.py [DIR]        DIR is out/ unless given; ch5_chapter --out DIR must have filled DIR/csv

Tables, DIR/csv (one row of names, then numbers; metres, radians; costs are ½ Σ rᵀWr):
  mono_ba_summary.csv    one row a scene ("course" 3×20, "large" 10×300): sizes, costs, iterations, RMSE, termination
  mono_ba_trace.csv      scene,iteration,cost,lambda,gain_ratio,step_norm,gradient_max,trials,seconds
  mono_ba_frames.csv     scene,state,frame,x_m…qw       state: truth, initial, final (aligned by a similarity)
  mono_ba_points.csv     scene,state,point,x_m,y_m,z_m
  mono_ba_iterations.csv scene,iteration,point,x_m,y_m,z_m   aligned by a similarity
  hessian.csv            scene,matrix,row,column,value  matrix: H (poses, then landmarks; gauge free), S (Schur)
  hessian_vertices.csv   scene,vertex,type,number,first_row,rows   whose rows they are
  hessian_edges.csv      scene,edge,type,vertex         one row a vertex of an edge
  hessian_blocks.csv     scene,matrix,row_vertex,column_vertex,by,number   what added to a block: edge or landmark
  spectrum.csv           gauge,index,eigenvalue         of H, 3×20 scene, W = 1/σ²
  marginalize_chain.csv  stage,row,column,value         stage: before, moved, after; the slides' 3×3
  marginalize_scene.csv  stage,row,column,value         non-zeros of a 5×12 scene's H as it loses variables
  marginalize_fill.csv   stage,size,non_zeros,density,null_dimension
  prior_sweep.csv        variant,weight,…               variant: course, perturbed, minimal; tight stop rules
  prior_trace.csv        variant,weight,iteration,cost,lambda
  prior_trials.csv       variant,weight,… means over many scenes, usual stop rules
  prior_damping.csv      damping,weight,… the course's variant, identity against diagonal damping
  odometry_policies.csv  policy,ate_m,scale_error,yaw_error_deg,… one row a window policy, simulated recording
  odometry_path.csv      policy,t_s,x_m,y_m,z_m,error_m  laid upon the truth, itself a "policy"
  odometry_windows.csv   policy,t_s,milliseconds,status,landmarks,iterations,initial_cost,final_cost
  odometry_matrices.csv  policy,picture,t_s,stage,size,pose_rows,row,column,value  stage: window (H), prior (JᵀJ)
  odometry_spectrum.csv  policy,t_s,index,eigenvalue,scaled   of the prior, and of it with a unit diagonal
  odometry_gauge.csv     policy,t_s,direction,information,relative   the auditor's: what the prior knows of the gauge
  slide_vertices.csv     policy,vertex,number,row,rows,fate   what a slide of one window marginalises; of the slides
  slide_observations.csv  policy,landmark,frame,host,fate     prior, again (there, and used again), lost, stays
  slide_matrices.csv     policy,stage,size,pose_rows,row,column,value   stage: window (H), before, after (priors)
  slide_priors.csv       policy,stage,columns,rank,null_dimension,largest_gauge_information
  slide_frames.csv       policy,image,frame,keyframe,speed,in_prior,prior_columns   the policy's window image by image
  consistency.csv        policy,mode,t_s,runs,nees_pose,… means over simulated runs, with the 95 % bands
  consistency_summary.csv  one row a policy and mode of first estimates

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
  odometry_path, _timing, _spectrum, _gauge, _film_POLICY   see odometry.py
  consistency                      NEES of pose and yaw, and the yaw that is claimed, by mode of first estimates
"""

import html
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import blocks
import captions
import convergence
import hessian
import marginalize
import nees
import odometry
import page
import prior
import scene
import sliders
import style

# The longest first, so that two processes finish together.
SCRIPTS = (odometry, nees, prior, scene, hessian, convergence, marginalize)
EXPLORERS = {"Bundle adjustment": sliders.iterations, "Odometry": sliders.windows, "The prior's weight": sliders.weights,
             "The Hessian": lambda directory: blocks.explorer(directory, "course")}

BESIDE = {"lab.html": "The lab: move the weight and the noise yourself", "api/index.html": "The API and its formulas"}


def solves_table(n):
    """The table of the solves, a column a scene."""
    scenes = [n.solve(name) for name in n.summary["scene"]]
    rows = (("frames × points", lambda row: f"{row['frames']:.0f} × {row['points']:.0f}"),
            ("unknowns", lambda row: f"{row['unknowns']:.0f}"), ("edges", lambda row: f"{row['edges']:.0f}"),
            ("first cost", lambda row: style.number(row["initial_cost"])),
            ("last cost", lambda row: style.number(row["final_cost"], 4)),
            ("iterations", lambda row: f"{row['iterations']:.0f}"),
            ("time [ms]", lambda row: style.number(row["milliseconds"], 2)),
            ("stopped by", lambda row: row["termination"]))
    return (page.table(("scene", *(row["scene"] for row in scenes)),
                       [(title, *map(cell, scenes)) for title, cell in rows], "words") +
            "<p>Cost: ½ Σ rᵀWr. The small scene has W = I as in the course, the large one W = 1/σ².</p>")


def contents(titles, directory):
    """Links to the sections, and to the pages beside this one that have been made."""
    links = "".join(f'<a href="#{anchor(title)}">{html.escape(title)}</a>' for title in (*titles, "Tables"))
    beside = {place: words for place, words in BESIDE.items() if (Path(directory) / place).exists()}
    links += "".join(f'<a href="{place}">{words}</a>' for place, words in beside.items())
    return f'<nav aria-label="Contents">{links}</nav>'


def anchor(title):
    return title.lower().replace("'", "").replace(" ", "-")


def body_of(directory):
    """The page's pieces."""
    n = captions.Numbers(directory)
    sections = {**captions.sections(n), "Odometry": odometry.captions(directory),
                "Consistency": nees.captions(directory)}
    body = ["<h1>Chapter 5: a hand-written back end at work</h1>",
            "<p>Simulated scenes, solved by the code of this repository; every number below is read from the tables "
            "beside this page.</p>", contents(sections, directory), solves_table(n)]
    for title, figures in sections.items():
        body.append(f'<section aria-labelledby="{anchor(title)}"><h2 id="{anchor(title)}">{html.escape(title)}</h2>')
        if title in EXPLORERS:
            body.append(EXPLORERS[title](directory))
        body += [page.figure(directory, name, caption) for name, caption in figures.items()]
        body.append("</section>")
    return [*body, page.links_to_tables(directory)]


def draw_one(index, directory):
    SCRIPTS[index].draw(directory)


def draw(directory):
    """All figures and the page."""
    with ProcessPoolExecutor(max_workers=min(len(SCRIPTS), os.cpu_count() or 1)) as pool:
        for done, _ in enumerate(pool.map(draw_one, range(len(SCRIPTS)), [directory] * len(SCRIPTS)), start=1):
            if sys.stderr.isatty():
                print(f"\r\033[Kfigures {done} of {len(SCRIPTS)}", end="", file=sys.stderr, flush=True)
    page.write(Path(directory) / "report.html", "Chapter 5 report", body_of(directory))
    if sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr)


if __name__ == "__main__":
    style.main(draw)
