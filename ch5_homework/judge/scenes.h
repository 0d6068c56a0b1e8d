#pragma once
/// Small graphs and systems with fixed seeds on which the homework is checked, and the dense oracle.

#include <memory>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/graph/graph.h"
#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/vertices.h"
#include "ch5_homework/judge/seed.h"

namespace ch5::homework {

/// Entries uniform on [−1, 1).
MatXX RandomMatrix(int rows, int columns, Random* random);
/// Symmetric, positive definite, smallest eigenvalue ≥ 1, far from a multiple of the identity.
MatXX RandomPositiveDefinite(int size, Random* random);

/// An edge whose residual, Jacobians and information are random numbers: H has no structure to hide a mistake in.
template <int R, typename... V>
class RandomEdge : public SizedEdge<R, V...> {
 public:
  RandomEdge(Random* random, std::shared_ptr<V>... vertices) : SizedEdge<R, V...>(std::move(vertices)...) {
    this->r_ = RandomMatrix(R, 1, random);
    this->SetInformation(RandomPositiveDefinite(R, random));
    this->TakeJacobians();
    for (size_t i = 0; i < sizeof...(V); ++i) {
      Eigen::Map<MatXX> J(this->jacobians_[i], R, this->vertices_[i]->LocalDimension());
      J = RandomMatrix(R, static_cast<int>(J.cols()), random);
    }
  }
  void ComputeResidual() override {}
  void ComputeJacobians() override {}
  std::string TypeInfo() const override { return "RandomEdge"; }
};

/// Adds `count` vertices made by `make` to the graph.
template <typename V, typename Maker>
std::vector<std::shared_ptr<V>> AddVertices(Graph* graph, int count, Maker make) {
  std::vector<std::shared_ptr<V>> vertices;
  for (int i = 0; i < count; ++i) {
    vertices.push_back(make());
    graph->AddVertex(vertices.back());
  }
  return vertices;
}

std::vector<std::shared_ptr<VertexPose>> AddPoses(Graph* graph, int count);
std::vector<std::shared_ptr<VertexInverseDepth>> AddInverseDepths(Graph* graph, int count);
std::vector<std::shared_ptr<VertexPointXYZ>> AddPoints(Graph* graph, int count);

template <int R, typename... V>
void AddRandomEdge(Graph* graph, Random* random, std::shared_ptr<V>... vertices) {
  graph->AddEdge(std::make_shared<RandomEdge<R, V...>>(random, std::move(vertices)...));
}

struct System {
  MatXX H;
  VecX b;
};

/// H = JᵀW_ρJ and b = −Jᵀρ'Wr from the stacked J of all edges, at the present state: the oracle of stage 1.1.
System StackedNormalEquations(const Graph& graph, int size);

/// A positive definite H with the ordering's structure (H_mm block diagonal) and b, all entries random.
System RandomSystem(const Ordering& ordering, Random* random);

/// Puts a system into a problem in place of MakeHessian's, so that stage 1.2 does not wait for stage 1.1.
void SetSystem(const System& system, Problem* problem);
/// b_p − H_pm H_mm⁻¹ b_m of the last SolveLinearSystem; Problem::SchurComplement() is its matrix.
const VecX& ReducedRightHandSide(const Problem& problem);

}  // namespace ch5::homework
