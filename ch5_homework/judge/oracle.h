#pragma once
/// Systems with fixed seeds on which the homework is checked, and the dense oracle: what the judge alone knows of scenes.

#include <functional>

#include "ch5_backend/dense/problem.h"
#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {

struct System {
  MatXX H;
  VecX b;
};

/// H = JᵀW_ρJ and b = −Jᵀρ'Wr from the stacked J of all edges, at the present state: the oracle of stages 1.1, 6 and 7.
/// @param row_of  where a vertex begins in H
System StackedNormalEquations(const EdgeList& edges, int size, const std::function<int(const Vertex&)>& row_of);
System StackedNormalEquations(const Graph& graph, int size);

/// The Jacobian of f at 0, by central differences: exact to about 1e-9.  @param size  of f's argument
MatXX Differences(int size, const std::function<MatXX(const VecX& delta)>& f);

/// A positive definite H with the ordering's structure (H_mm block diagonal) and b, all entries random.
System RandomSystem(const Ordering& ordering, Random* random);

}  // namespace ch5::homework
