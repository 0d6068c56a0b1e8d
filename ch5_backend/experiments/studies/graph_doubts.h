#pragma once
/// Whether a pose graph's edges mean what the format says: their unit, their direction, and their last numbers.

#include <string>

#include "ch5_backend/experiments/studies/pose_graph_study.h"

namespace ch5 {

/// Edges that do not fit the present poses, but would if their measurement T_z were of another unit (z in mm or cm), from j to
/// i (T_z⁻¹), or had another sign. An edge counts if its rᵀWr is then less than a twentieth, and the misfit is less than a
/// quarter of the distance. Those that the poses fit as they are, and others that fit in no way, as false loops do, say nothing.
/// @return a line for each way, with the number of edges, the first line of the file, and the remedy; empty if there are none
std::string DoubtsOfMeasurements(const G2oFile& file);

/// Edges of zero information: how many, the first line, and the first that alone would connect two parts of the graph.
/// @return a line for each; empty if there are none
std::string DoubtOfZeroInformation(const G2oFile& file);

/// Of a solved graph: that its information matrices W are covariances. Residuals r of a graph with redundant edges have
/// Σ rᵀWr ≈ their degrees of freedom; if that is off by a hundred, and Σ rᵀW⁻¹r is not less but at most 300 times more, W was meant as W⁻¹.
/// Loops that were given up do not count; false ones that were not may look the same (AreSomeLoopsFalse).
/// @return empty if not, or where too few edges are redundant
std::string DoubtOfInformation(const Graph& graph);

}  // namespace ch5
