#pragma once
/// The lab: a student's experiments, answered by the course's own code.
///
///   lab.html#panel=solve&weight=100  ──►  Answer("panel=solve&weight=100")  ──►  {"H": …, "trace": …}  ──►  drawn
///
/// The same text is the state of the page, its address, the argument of the program ch5_lab and that of the function that
/// WebAssembly exports: so a page and a terminal can be asked the same, and what the page shows is what C++ has said.
/// Reading order: this file, query.h, scene.h, solve_panel.cc.

#include <string>

#include "ch5_backend/lab/json.h"
#include "ch5_backend/lab/query.h"

namespace ch5::lab {

/// One of the panels below, as `panel` names it, as JSON; or {"error": "what is wrong with the query", …}: its
/// first fault, member by member.
std::string Answer(const std::string& query);

/// What is claimed of x and y of a pose, the truth's distance from them, and the error in that measure, eᵀ Σ⁻¹ e.
/// @param p  estimated, in the frame of the truth
Json ClaimJson(int number, const Vec3& p, const Vec3& truth, const Mat22& covariance);
/// The largest eᵀ Σ⁻¹ e of 95 %.
double ClaimLimit();

/// Each panel reads its settings from the query and adds its answer to `json`, unless the query has a fault.

/// The scene solved: H, S, their spectra, the trace, the costs, the trajectory, and the difference to the sparse solver.
void SolvePanel(Query* query, Json* json);
/// The same solve trial by trial: what the loop computes between two linearizations.
void StepsPanel(Query* query, Json* json);
/// Variables marginalized one after the other, and what each of them fills in.
void MarginalizePanel(Query* query, Json* json);
/// A factor graph whose variables are eliminated one by one, beside AMD's order and the best one.
void EliminatePanel(Query* query, Json* json);
/// A simulated flight through the windows of VINS-Mono and OKVIS, image by image. `until` flies so far only: the page shows
/// a new flight while it grows.
void WindowPanel(Query* query, Json* json);

}  // namespace ch5::lab
