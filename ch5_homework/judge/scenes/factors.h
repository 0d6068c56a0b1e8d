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
template <int R, typename... V>
class AgedRandomEdge : public RandomEdge<R, V...>, public AgedEdge {
 public:
  AgedRandomEdge(Random* random, std::shared_ptr<V>... vertices) : RandomEdge<R, V...>(random, std::move(vertices)...) {
    this->r_ = RandomMatrix(R, 1, random);
    for (size_t i = 0; i < sizeof...(V); ++i) {
      right_J_.push_back(this->Jacobian(i));
      old_J_.push_back(RandomMatrix(R, this->vertices_[i]->LocalDimension(), random));
      SetJ(i, old_J_[i]);
    }
  }
  void ComputeJacobians() override {
    for (size_t i = 0; i < sizeof...(V); ++i) SetJ(i, right_J_[i]);
  }
  /// From now on the residual is zero; the Jacobians are not.
  void Fit() { this->right_r_.setZero(); }
  int Fresh() const override {
    int fresh = (this->r_ == this->right_r_ ? kResidual : 0) | kJacobians;
    for (size_t i = 0; i < sizeof...(V); ++i) {
      if (this->Jacobian(i) != right_J_[i]) fresh &= ~kJacobians;
    }
    return fresh;
  }

 private:
  void SetJ(size_t i, const MatXX& J) {
    Eigen::Map<MatXX>(this->jacobians_[i], R, this->vertices_[i]->LocalDimension()) = J;
  }
  std::vector<MatXX> right_J_, old_J_;
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
  template <int R, typename... V>
  void AddFactor(Random* random, std::vector<int> drop_set, std::shared_ptr<const LossFunction> loss,
                 std::shared_ptr<V>... vertices);

  Graph graph_;
};

}  // namespace ch5::homework
