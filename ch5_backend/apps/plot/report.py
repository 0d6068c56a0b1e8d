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
