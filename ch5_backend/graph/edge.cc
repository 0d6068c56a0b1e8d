#include "ch5_backend/graph/edge.h"

#include <cmath>
#include <stdexcept>

#include "ch5_backend/math/psd.h"

namespace ch5 {
namespace {

// The vertex where it was, also after an exception.
struct PutBack {
  Vertex* vertex;
  VecX x0;
  ~PutBack() { vertex->Parameters() = x0; }
};

}  // namespace

void Edge::SetInformation(const MatXX& information) {
  if (information.rows() != residual_dimension_ || information.cols() != residual_dimension_) {
    throw std::invalid_argument(TypeInfo() + ": the information matrix must be " + std::to_string(residual_dimension_) +
                                "x" + std::to_string(residual_dimension_) + ", got " +
                                std::to_string(information.rows()) + "x" + std::to_string(information.cols()));
  }
  const std::string fault = WhyNotPositiveSemiDefinite(information);
  if (!fault.empty()) throw std::invalid_argument(TypeInfo() + ": the information matrix " + fault);
  Eigen::Map<MatXX>(information_, residual_dimension_, residual_dimension_) = information;
  NoteInformation();
}

void Edge::SetIsotropicInformation(double w) {
  if (!(w >= 0.0) || !std::isfinite(w)) {
    throw std::invalid_argument(TypeInfo() + ": the information must be a finite w >= 0, got " + std::to_string(w));
  }
  for (int i = 0; i < residual_dimension_ * residual_dimension_; ++i) {
    information_[i] = i % (residual_dimension_ + 1) == 0 ? w : 0.0;
  }
  isotropic_information_ = w;
}

void Edge::NoteInformation() {
  const auto W = Information();
  const double w = W.size() > 0 ? W(0, 0) : 1.0;
  isotropic_information_ = W == w * MatXX::Identity(W.rows(), W.cols()) ? w : -1.0;
}

void Edge::SetLevel(int level) {
  if (level < 0)
    throw std::invalid_argument(TypeInfo() + ": the level must not be negative, got " + std::to_string(level));
  level_ = level;
}

double Edge::Chi2() const {
  if (isotropic_information_ >= 0.0) return isotropic_information_ * Residual().squaredNorm();
  // A product of dynamic views would allocate, and this is called for every residual.
  double s = 0.0;
  for (int j = 0; j < residual_dimension_; ++j) s += Information().col(j).dot(Residual()) * residual_[j];
  return s;
}

double Edge::Cost() const {
  const double s = Chi2();
  return 0.5 * (loss_ ? loss_->Evaluate(s)[0] : s);
}

RobustWeight Edge::GetRobustWeight() const {
  if (!loss_) return {1.0, 0.0};
  const double s = Chi2();
  return CorrectLoss(loss_->Evaluate(s), s, loss_->Correction());
}

void Edge::RobustInfo(double* drho, MatXX* robust_information) const {
  const RobustWeight robust = GetRobustWeight();
  *drho = robust.weight;
  *robust_information = robust.weight * Information();
  if (robust.rank_one != 0.0) {
    const VecX Wr = Information() * Residual();
    robust_information->noalias() += robust.rank_one * Wr * Wr.transpose();
  }
}

void Edge::TakeJacobians() const {
  throw std::logic_error(TypeInfo() +
                         ": an edge whose sizes are known at run time only needs a TakeJacobians of its own");
}

void Edge::ComputeJacobiansNumerically() {
  constexpr double kStep = 1e-6;
  numeric_jacobians_ = true;
  if (!HasJacobians()) TakeJacobians();
  for (size_t i = 0; i < vertices_.size(); ++i) {
    Vertex& vertex = *vertices_[i];
    const PutBack put_back{&vertex, vertex.Parameters()};
    VecX delta = VecX::Zero(vertex.LocalDimension());
    const auto residual_at = [&](int k, double step) -> VecX {
      delta[k] = step;
      vertex.Plus(delta.data());
      ComputeResidual();
      vertex.Parameters() = put_back.x0;
      delta[k] = 0.0;
      return Residual();
    };
    Eigen::Map<MatXX> J(jacobians_[i], residual_dimension_, vertex.LocalDimension());
    for (int k = 0; k < vertex.LocalDimension(); ++k) {
      J.col(k) = (residual_at(k, kStep) - residual_at(k, -kStep)) / (2.0 * kStep);
    }
  }
  ComputeResidual();
}

}  // namespace ch5
