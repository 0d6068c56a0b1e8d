#include "ch5_backend/solve/step_strategy.h"

#include <cmath>

namespace ch5 {
namespace {

class GaussNewton : public StepStrategy {
 public:
  void Begin(NormalEquations*) override {}
  bool Propose(NormalEquations* system, VecX* delta_x) override { return system->SolveLinearSystem(0.0, delta_x); }
  void Accepted(double) override {}
  bool Rejected() override { return false; }
  StepType Type() const override { return StepType::kGaussNewton; }
  double Parameter() const override { return 0.0; }
};

class LevenbergMarquardt : public StepStrategy {
 public:
  explicit LevenbergMarquardt(double tau) : tau_(tau) {}

  void Begin(NormalEquations* system) override {
    if (lambda_ >= 0.0) return;  // λ is kept from one Hessian to the next
    const bool identity = system->GetDamping() == Damping::kIdentity;
    lambda_ = tau_ * (identity ? system->HessianDiagonal().maxCoeff() : 1.0);
  }
  bool Propose(NormalEquations* system, VecX* delta_x) override { return system->SolveLinearSystem(lambda_, delta_x); }
  void Accepted(double gain_ratio) override {
    const double t = 2.0 * gain_ratio - 1.0;
    lambda_ *= std::max(1.0 / 3.0, std::min(2.0 / 3.0, 1.0 - t * t * t));
    nu_ = 2.0;
  }
  bool Rejected() override {
    lambda_ *= nu_;
    nu_ *= 2.0;
    return std::isfinite(lambda_);
  }
  StepType Type() const override { return StepType::kDamped; }
  double Parameter() const override { return lambda_; }

 private:
  double tau_;
  double lambda_ = -1.0;
  double nu_ = 2.0;
};

class Dogleg : public StepStrategy {
 public:
  explicit Dogleg(double radius) : radius_(radius) {}

  // Two points mark the path: Gauss-Newton's step h_gn, and the minimum along the gradient, which is computed once
  // h_gn reaches beyond the radius.
  void Begin(NormalEquations* system) override {
    has_sd_ = false;
    // A singular H gets just enough damping to be solved: 0, then 1e-12 … 1e3, which are g2o's limits.
    has_gn_ = system->SolveLinearSystem(0.0, &h_gn_);
    for (double lambda = 1e-12; !has_gn_ && lambda < 1e4; lambda *= 10.0) {
      has_gn_ = system->SolveLinearSystem(lambda, &h_gn_);
    }
  }

  bool Propose(NormalEquations* system, VecX* delta_x) override {
    if (!has_gn_) return false;
    if (h_gn_.norm() <= radius_) {
      type_ = StepType::kGaussNewton;
      *delta_x = h_gn_;
    } else if (!FindSteepestDescent(system)) {
      return false;
    } else if (h_sd_.norm() >= radius_) {
      type_ = StepType::kSteepestDescent;
      *delta_x = (radius_ / h_sd_.norm()) * h_sd_;
    } else {
      type_ = StepType::kDogleg;
      // ‖h_sd + β d‖ = Δ with d = h_gn − h_sd:  β = (−c + √(c² + ‖d‖² e)) / ‖d‖², in the form that does not cancel.
      const VecX d = h_gn_ - h_sd_;
      const double c = h_sd_.dot(d), e = radius_ * radius_ - h_sd_.squaredNorm(), d2 = d.squaredNorm();
      const double root = std::sqrt(c * c + d2 * e);
      *delta_x = h_sd_ + (c <= 0.0 ? (root - c) / d2 : e / (c + root)) * d;
    }
    step_norm_ = delta_x->norm();
    return true;
  }

  void Accepted(double gain_ratio) override {
    if (gain_ratio > 0.75) radius_ = std::max(radius_, 3.0 * step_norm_);
    if (gain_ratio < 0.25) radius_ *= 0.5;
  }
  bool Rejected() override {
    // A radius beyond the step's length does not limit it: shrink from the length of the step that was tried.
    radius_ = 0.5 * std::min(radius_, has_gn_ ? step_norm_ : radius_);
    return has_gn_ && radius_ > 1e-300;
  }
  StepType Type() const override { return type_; }
  double Parameter() const override { return radius_; }

 private:
  // h_sd = (bᵀb / bᵀHb) b
  bool FindSteepestDescent(NormalEquations* system) {
    const VecX& b = system->RightHandSide();
    if (!has_sd_) h_sd_ = b * (b.squaredNorm() / b.dot(system->MultiplyHessian(b)));
    has_sd_ = true;
    return h_sd_.allFinite();
  }

  double radius_;
  StepType type_ = StepType::kNone;
  bool has_gn_ = false, has_sd_ = false;
  double step_norm_ = 0.0;
  VecX h_sd_, h_gn_;
};

}  // namespace

std::unique_ptr<StepStrategy> MakeGaussNewton() { return std::make_unique<GaussNewton>(); }
std::unique_ptr<StepStrategy> MakeLevenbergMarquardt(double tau) { return std::make_unique<LevenbergMarquardt>(tau); }
std::unique_ptr<StepStrategy> MakeDogleg(double radius) { return std::make_unique<Dogleg>(radius); }

}  // namespace ch5
