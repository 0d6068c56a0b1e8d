#pragma once
/// Residuals for MarginalizationInfo (stage 6) whose numbers are random, so that A has no structure to hide a mistake in.

#include <algorithm>

#include "ch5_backend/graph/loss.h"
#include "ch5_backend/marginalize/marginalization_info.h"
#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {

/// An edge whose numbers are those of an older state until it is linearized.
class AgedEdge {
 public:
  enum : int { kResidual = 1, kJacobians = 2 };
  virtual ~AgedEdge() = default;
  /// Which of them are those of the present state.
  virtual int Fresh() const = 0;
  bool IsFresh() const { return Fresh() == (kResidual | kJacobians); }
};
class AgedRandomEdge : public RandomEdge, public AgedEdge {
 public:
  AgedRandomEdge(int rows, Random* random, VertexList vertices);
  void ComputeJacobians() override;
  int Fresh() const override;

 private:
  std::vector<MatXX> right_J_;
};

/// Three poses, a speed-bias, three depths and a fixed extrinsic; dropped are the middle pose, the speed-bias and the
/// last depth, so that dropped and kept ids alternate and no id is a position.
class FactorGraph : public Scene {
 public:
  enum Kind { kRobust, kNoLoss, kOneEdge };

  explicit FactorGraph(Kind kind = kRobust);
  Graph& GetGraph() override { return graph_; }
  EdgeList Edges() override;

  VertexList free;  ///< in order of id
  std::shared_ptr<Vertex> fixed;
  std::vector<ResidualBlockInfo> factors;

 protected:
  VertexList dropped_;

 private:
  RandomEdge& AddFactor(int rows, Random* random, std::vector<int> drop_set, std::shared_ptr<const LossFunction> loss,
                        VertexList vertices);

  Graph graph_;
};

}  // namespace ch5::homework
