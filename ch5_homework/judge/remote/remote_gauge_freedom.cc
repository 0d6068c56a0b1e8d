/// Stage 4 in the worker.

#include "ch5_homework/judge/remote/remote.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {
namespace {

// The given code makes matrices of the right size; the tests rely on it.
MatXX AskForMatrix(const std::string& function, const Writer& arguments, Eigen::Index rows, Eigen::Index columns) {
  MatXX A;
  Ask(function, arguments, &A);
  if (A.rows() == rows && A.cols() == columns) return A;
  throw WorkerFailure("GARBAGE in the reply to " + function + ": a matrix of " + std::to_string(A.rows()) + "×" +
                      std::to_string(A.cols()));
}

MatXX RemoteNullSpace(const VertexList& vertices, GaugeGroup group) {
  return AskForMatrix("GaugeNullSpace", Pack(NumbersOf(vertices), group), TotalLocalDimension(vertices),
                      NumGaugeDirections(group));
}

MatXX RemoteProjection(const MatXX& U, const MatXX& V) {
  return AskForMatrix("GaugeProjection", Pack(U, V), U.rows(), U.rows());
}

MatXX RemoteMotionJacobian(const VertexList& vertices, double yaw) {
  const int size = TotalLocalDimension(vertices);
  return AskForMatrix("GaugeMotionJacobian", Pack(NumbersOf(vertices), yaw), size, size);
}

MatXX RemoteTransformCovariance(const MatXX& covariance, const MatXX& Q, const MatXX& motion) {
  return AskForMatrix("TransformCovariance", Pack(covariance, Q, motion), covariance.rows(), covariance.cols());
}

[[maybe_unused]] const bool added = [] {
  Linked()->gauge_freedom = {&RemoteNullSpace, &RemoteProjection, &RemoteMotionJacobian, &RemoteTransformCovariance};
  return true;
}();

}  // namespace
}  // namespace ch5::homework
