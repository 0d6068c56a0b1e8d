#pragma once
/// An edge between vertices whose types are known at compile time: r has `R` rows, J_i is R × V_i::kLocalDimension.

#include <limits>
#include <tuple>
#include <utility>

#include "ch5_backend/graph/edge.h"

namespace ch5 {

/// Column-major R×C; a 1×C matrix must be called row-major in Eigen, the memory is the same.
template <int R, int C>
using JacobianBlock = Eigen::Matrix<double, R, C, (R == 1 && C != 1) ? Eigen::RowMajor : Eigen::ColMajor>;

template <int R, typename... V>
class SizedEdge : public Edge {
 public:
  static constexpr int kResidualDimension = R;
  static constexpr size_t kVertices = sizeof...(V);
  using ResidualVector = Eigen::Matrix<double, R, 1>;
  using InformationMatrix = Eigen::Matrix<double, R, R>;

  /// The `I`-th vertex in its own type.
  template <size_t I>
  const auto& GetVertex() const {
    return static_cast<const std::tuple_element_t<I, std::tuple<V...>>&>(*own_vertices_[I]);
  }

  const ResidualVector& GetResidual() const { return r_; }
  template <size_t I>
  const auto& J() const {
    return std::get<I>(Jacobians());
  }
  const InformationMatrix& W() const { return W_; }

 protected:
  /// Graph::AddEdge reports a null vertex. (The base class needs addresses; data() would be a call to what is not made yet.)
  explicit SizedEdge(std::shared_ptr<V>... vertices)
      : Edge(R, VertexSpan(own_vertices_, kVertices), reinterpret_cast<double*>(&r_), reinterpret_cast<double*>(&W_)),
        own_vertices_{std::move(vertices)...},
        r_(ResidualVector::Zero()),
        W_(InformationMatrix::Identity()) {}

  template <size_t I>
  auto& J() {
    return std::get<I>(Jacobians());
  }
  void TakeJacobians() const override { Jacobians(); }

  /// For an edge that computes its own W, known to be positive definite.
  void SetW(const InformationMatrix& W) {
    W_ = W;
    NoteInformation();
  }

 private:
  std::shared_ptr<Vertex> own_vertices_[kVertices];  // beside the residual: one cache miss less

 protected:
  ResidualVector r_;

 private:
  using JacobianTuple = std::tuple<JacobianBlock<R, V::kLocalDimension>...>;

  // NaN until ComputeJacobians fills them: one that is forgotten would otherwise pass for a minimum.
  JacobianTuple& Jacobians() const {
    if (!J_) {
      J_ = std::make_unique<JacobianTuple>();
      MapJacobians(std::index_sequence_for<V...>{});
    }
    return *J_;
  }
  template <size_t... I>
  void MapJacobians(std::index_sequence<I...>) const {
    (std::get<I>(*J_).setConstant(std::numeric_limits<double>::quiet_NaN()), ...);
    jacobians_ = {std::get<I>(*J_).data()...};
  }

  mutable std::unique_ptr<JacobianTuple> J_;
  InformationMatrix W_;
};

}  // namespace ch5
