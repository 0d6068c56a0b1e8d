#include "ch5_homework/judge/right/formulas.h"

#include "ch5_backend/dense/dense_solvers.h"

namespace ch5::homework::right {

std::vector<int> SizesOf(const std::vector<std::shared_ptr<Vertex>>& vertices) {
  std::vector<int> sizes;
  for (const auto& vertex : vertices) sizes.push_back(vertex->LocalDimension());
  return sizes;
}

std::vector<Part> PartsOf(const Ordering& ordering, bool numbered) {
  std::vector<Part> parts;
  Eigen::Index begin = 0;
  for (const auto* vertices : {&ordering.poses, &ordering.landmarks}) {
    const char* const role = vertices == &ordering.poses ? "scene.pose" : "scene.landmark";
    for (size_t k = 0; k < vertices->size(); ++k) {
      const Vertex& vertex = *(*vertices)[k];
      parts.push_back({numbered ? Text(role, {{"n", Word(k)}}) : Word(vertex.Name()), begin, vertex.LocalDimension()});
      begin += vertex.LocalDimension();
    }
  }
  return parts;
}

Text ChangedInPlace(const char* it, const char* meant) {
  return {"formula.changed_in_place", {{"this", Word(std::string(it))}, {"that", Word(std::string(meant))}}};
}

Text With(const Text& quantity, const Text& scene, double lambda, Damping damping) {
  return {damping == Damping::kIdentity ? "scene.with_lambda" : "scene.with_lambda_and_D",
          {{"quantity", quantity}, {"scene", scene}, {"l", Word(lambda)}}};
}

MatXX Damped(const MatXX& H, double lambda, Damping damping) {
  MatXX damped = H;
  for (Eigen::Index i = 0; i < H.rows(); ++i) damped(i, i) += lambda * DampingEntry(damping, H(i, i));
  return damped;
}

VecX Solve(const MatXX& A, const VecX& b) {
  VecX x = VecX::Zero(b.size());
  if (b.size() > 0) SolveLdlt(A, b, &x);
  return x;
}

}  // namespace ch5::homework::right
