#pragma once
// What an algorithm does, shown by a system that follows a script.
#include <algorithm>
#include <vector>

#include "ch5_backend/solve/minimizer.h"

namespace ch5::test {

// A system whose H and b are constants and whose costs follow a script: what an algorithm does is then plain.
class ScriptedSystem : public NormalEquations {
 public:
  ScriptedSystem(MatXX H, VecX b, std::vector<double> costs)
      : H_(std::move(H)), b_(std::move(b)), x_(VecX::Zero(b_.size())), costs_(std::move(costs)) {}

  void SetOrdering() override {}
  int Size() const override { return static_cast<int>(b_.size()); }
  double Cost() override { return costs_[std::min(next_++, costs_.size() - 1)]; }
  void MakeHessian() override {
    if (hessians_++ > 0) b_ *= later_b_;
    hessian_at_ = x_;
  }
  bool MakeHessianAndCost(double* cost) override {
    if (!one_pass_) return false;
    MakeHessian();
    *cost = Cost();
    return true;
  }
  bool SolveLinearSystem(double lambda, VecX* delta_x) override {
    if (lambda < solvable_from_) return false;
    solves_with_old_hessian_ += hessians_ > 0 && hessian_at_ != x_;
    *delta_x = (H_ + lambda * MatXX::Identity(Size(), Size())).inverse() * b_;
    return true;
  }
  const VecX& RightHandSide() const override { return b_; }
  VecX HessianDiagonal() const override { return H_.diagonal(); }
  VecX MultiplyHessian(const VecX& v) const override { return H_ * v; }
  void UpdateStates(const VecX& delta_x) override { before_ = x_, x_ += delta_x; }
  void RollbackStates() override { x_ = before_; }
  double StateNorm() const override { return state_norm_; }
  bool SuitsDogleg() const override { return suits_dogleg_; }
  double RefineLandmarks(int) override { return refined_.at(static_cast<size_t>(refinements_++)); }

  double solvable_from_ = 0.0, state_norm_ = 1.0;
  double later_b_ = 1.0;  // the factor on b from one Hessian to the next
  bool one_pass_ = false, suits_dogleg_ = false;
  int hessians_ = 0, solves_with_old_hessian_ = 0, refinements_ = 0;
  std::vector<double> refined_;

 private:
  MatXX H_;
  VecX b_, x_, before_, hessian_at_;
  std::vector<double> costs_;
  size_t next_ = 0;
};

inline ScriptedSystem OneUnknown(double H, double b, std::vector<double> costs) {
  return {MatXX::Constant(1, 1, H), VecX::Constant(1, b), std::move(costs)};
}

/// So that a run follows its script to the end.
inline SolveOptions WithoutStopRules(Algorithm algorithm, int max_iterations) {
  SolveOptions options;
  options.algorithm = algorithm;
  options.max_iterations = max_iterations;
  options.cost_tolerance = options.gradient_tolerance = options.step_tolerance = 0.0;
  return options;
}

}  // namespace ch5::test
