#pragma once
/// An edge that is given by its formula alone: its Jacobians are found by automatic differentiation (math/dual.h).
///
///   class EdgeRange : public AutoDiffEdge<EdgeRange, 1, VertexPointXYZ, VertexPointXYZ> {
///    public:
///     EdgeRange(…) : AutoDiffEdge(std::move(a), std::move(b)), d_(d) {}
///     template <typename T>  // double, or a dual number
///     Eigen::Matrix<T, 1, 1> Evaluate(const Eigen::Matrix<T, 3, 1>& a, const Eigen::Matrix<T, 3, 1>& b) const {
///       return Eigen::Matrix<T, 1, 1>((b - a).norm() - d_);
///     }
///   };
///
/// Evaluate takes the vertices' parameters, as GetEstimate gives them, and is in public; constants are doubles. The
/// derivative is by the increment: ∂r/∂x · ∂(x ⊞ δ)/∂δ, so for a manifold's vertex there is a function
/// PlusJacobian(vertex), D×T, in its namespace (types/plus_jacobian.h).

#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/math/dual.h"

namespace ch5 {

template <typename Derived, int R, typename... V>
class AutoDiffEdge : public SizedEdge<R, V...> {
 public:
  void ComputeResidual() override { this->r_ = EvaluateAt(std::index_sequence_for<V...>{}); }
  void ComputeJacobians() override { Linearize(); }
  void Linearize() override {
    const auto differentiate = HasAvx512() ? &AutoDiffEdge::DifferentiateAvx512
                               : HasAvx2() ? &AutoDiffEdge::DifferentiateAvx2
                                           : &AutoDiffEdge::Differentiate;
    (this->*differentiate)();  // by its address: GCC's copy of a function forgets that it is flattened
  }

 protected:
  using SizedEdge<R, V...>::SizedEdge;

 private:
  static constexpr int kParameters = (V::kDimension + ...);
  using Number = Dual<kParameters>;

  const Derived& Self() const { return static_cast<const Derived&>(*this); }

  template <size_t... I>
  Eigen::Matrix<double, R, 1> EvaluateAt(std::index_sequence<I...>) const {
    return Self().Evaluate(this->template GetVertex<I>().GetEstimate()...);
  }

  // Number of parameters of the vertices before the I-th.
  static constexpr int Before(size_t i) {
    constexpr int kDimensions[] = {V::kDimension...};
    int sum = 0;
    for (size_t k = 0; k < i; ++k) sum += kDimensions[k];
    return sum;
  }

  template <size_t I>
  auto Unknowns() const {
    const auto& x = this->template GetVertex<I>().GetEstimate();
    Eigen::Matrix<Number, std::decay_t<decltype(x)>::RowsAtCompileTime, 1> unknowns;
    for (int k = 0; k < unknowns.size(); ++k) unknowns[k] = Number::Unknown(x[k], Before(I) + k);
    return unknowns;
  }

  CH5_FLATTEN void Differentiate() { DifferentiateBody(std::index_sequence_for<V...>{}); }
  CH5_WITH_AVX2 CH5_FLATTEN void DifferentiateAvx2() { DifferentiateBody(std::index_sequence_for<V...>{}); }
  // For its 32 registers: half as many numbers go through memory.
  CH5_WITH_AVX512 CH5_FLATTEN void DifferentiateAvx512() { DifferentiateBody(std::index_sequence_for<V...>{}); }

  // Not always_inline, which is left to flatten: GCC 12 orders its early passes by calls, but not by those of always_inline
  // functions; it would then come to Evaluate too late, and leave some of Eigen's assignments calls, without AVX2.
  template <size_t... I>
  void DifferentiateBody(std::index_sequence<I...>) {
    const Eigen::Matrix<Number, R, 1> r = Self().Evaluate(Unknowns<I>()...);
    for (int row = 0; row < R; ++row) this->r_[row] = r[row].value;
    (TakeColumns<I>(r), ...);
  }

  template <size_t I>
  void TakeColumns(const Eigen::Matrix<Number, R, 1>& r) {
    const auto& vertex = this->template GetVertex<I>();
    using Type = std::decay_t<decltype(vertex)>;
    Eigen::Matrix<double, R, Type::kDimension> dr_dx;
    for (int column = 0; column < Type::kDimension; ++column)
      for (int row = 0; row < R; ++row) dr_dx(row, column) = r[row].gradient[Before(I) + column];
    if constexpr (Type::kDimension == Type::kLocalDimension) {
      this->template J<I>() = dr_dx;
    } else {
      this->template J<I>() = dr_dx * PlusJacobian(vertex);  // a VertexPose's: types/plus_jacobian.h
    }
  }
};

}  // namespace ch5
