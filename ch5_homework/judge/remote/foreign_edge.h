#pragma once
/// What a student's function has named and the scene does not have.

#include "ch5_backend/graph/edge.h"

namespace ch5::homework {

class ForeignEdge : public Edge {
 public:
  explicit ForeignEdge(std::string type) : Edge(0, {}, nullptr, nullptr), type_(std::move(type)) {}
  void ComputeResidual() override {}
  void ComputeJacobians() override {}
  std::string TypeInfo() const override { return type_; }

 private:
  std::string type_;
};

}  // namespace ch5::homework
