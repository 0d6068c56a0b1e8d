#pragma once
/// Curve fitting, chapter 3's example:  y = exp(a x² + b x + c),  r = prediction − y.

#include <cmath>

#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {

class EdgeCurveFitting : public SizedEdge<1, VertexVector<3>> {
 public:
  EdgeCurveFitting(std::shared_ptr<VertexVector<3>> abc, double x, double y)
      : SizedEdge(std::move(abc)), x_(x), y_(y) {}
  void ComputeResidual() override { r_[0] = Predict() - y_; }
  void ComputeJacobians() override { J<0>() << x_ * x_ * Predict(), x_ * Predict(), Predict(); }
  std::string TypeInfo() const override { return "EdgeCurveFitting"; }

 private:
  double Predict() const {
    const Vec3& abc = GetVertex<0>().GetEstimate();
    return std::exp((abc[0] * x_ + abc[1]) * x_ + abc[2]);
  }
  double x_, y_;
};

}  // namespace ch5
