#pragma once
/// What homework usually makes of matrices and containers, written once with any operands: Clang keeps in its precompiled header
/// what these lines instantiate, and in the header's object what they compile to, so that a submission pays for what is its own
/// alone. Nothing here is called, and no line follows a formula of the homework; which are worth it, -ftime-trace tells.

#include "ch5_homework/judge/remote/precompiled.h"

namespace ch5::usual {

/// Each way to take a value over: to a new matrix, to an old one, to a part of it.
template <typename To, typename Part, typename Value>
void Assign(To* to, Part part, const Value& value) {
  const To made = value;
  *to = value;
  *to += value;
  *to -= value;
  part = made;
  part = value;
  part += value;
  part -= value;
}

template <typename Value>
void AssignMatrix(MatXX* A, const Value& value) {
  Assign(A, A->block(0, 0, 1, 1), value);
  A->noalias() += value;
  A->noalias() -= value;
  A->block(0, 0, 1, 1).noalias() += value;
}

template <typename Value>
void AssignVector(VecX* x, const Value& value) {
  Assign(x, x->segment(0, 1), value);
  x->noalias() -= value;
  x->head(1) = value;
  x->tail(1) = value;
}

inline void Matrices(MatXX A, const MatXX& B, VecX x, const VecX& y, int n) {
  A.setZero();
  A.setZero(n, n);
  A.setIdentity();
  A(0, 0) = B(0, 0);
  A = MatXX::Zero(n, n);
  A = MatXX::Identity(n, n);
  const MatXX zero = MatXX::Zero(n, n), one = MatXX::Identity(n, n);
  AssignMatrix(&A, B);
  AssignMatrix(&A, B.transpose());
  AssignMatrix(&A, B.block(0, 0, n, n));
  A = A.block(0, 0, n, n);
  const MatXX part = A.block(0, 0, n, n);
  AssignMatrix(&A, A * B);
  AssignMatrix(&A, A * B * A);
  AssignMatrix(&A, B * B.transpose());
  AssignMatrix(&A, B.transpose() * B);
  A = A * B * B.transpose();
  A -= A * B * B.transpose();
  A = A - B * B;
  A = B.block(0, 0, n, n) - A * B;
  A = A.block(0, 0, n, n) - A * B;
  A = B.block(0, 0, n, n) - A * B * A;
  const MatXX C = A * B * B.transpose();
  A = x.asDiagonal() * B;
  A = x.asDiagonal() * B.transpose();
  A = B * x.asDiagonal();
  A = B * x.asDiagonal() * B.transpose();
  A = (x.asDiagonal() * B * y.asDiagonal()).transpose();
  A = x.asDiagonal() * B.transpose() * y.asDiagonal();
  A = x.cwiseSqrt().asDiagonal() * B.transpose();
  const MatXX D = B * x.asDiagonal() * B.transpose(), E = x.asDiagonal() * B.transpose() * y.asDiagonal();
}

inline void Vectors(const MatXX& A, const MatXX& B, VecX x, const VecX& y, int n, double s) {
  x.setZero();
  x.setZero(n);
  x.resize(n);
  x = VecX::Zero(n);
  const VecX nothing = VecX::Zero(n), negative = -y;
  AssignVector(&x, y);
  AssignVector(&x, y.segment(0, n));
  x = x.segment(0, n);
  x = -y;
  AssignVector(&x, A * y);
  AssignVector(&x, B.transpose() * y);
  AssignVector(&x, s * y);
  x = y - A * y;
  x = y + A * y;
  x = x.head(n) - A * x.tail(n);
  x = y.segment(0, n) - A * y.segment(0, n);
  x = y.head(n) - A * B * y.head(n);
  x = A * (B.transpose() * y);
  x = A * (x - B * y);
  x -= A * (B.transpose() * y);
  x.noalias() -= A * (B.transpose() * y);
  x = -A * y;
  x = x.cwiseSqrt().asDiagonal() * B.transpose() * y;
  const VecX inverse = x.cwiseInverse(), root = x.cwiseSqrt();
  x = (y.array() > s).select(y, 0.0);
  x = (y.array() > s).select(y.array().inverse(), 0.0);
  const VecX larger = (y.array() > s).select(y, 0.0), divided = (y.array() > s).select(y.array().inverse(), 0.0);
  const bool finite = x.allFinite() && A.allFinite() && A.norm() > x.norm() && x.maxCoeff() > x.minCoeff();
  x(0) = A(0, 0) + y(0) + finite;
}

inline void Edges(const Edge& edge, MatXX A, VecX x, double s) {
  Assign(&x, x.segment(0, 1), edge.Jacobian(0).transpose() * x);
  Assign(&x, x.segment(0, 1), s * edge.Jacobian(0).transpose() * x);
  Assign(&x, x.segment(0, 1), s * A.transpose() * x);
  A = edge.Jacobian(0);
  const MatXX J = edge.Jacobian(0), JtA = edge.Jacobian(0).transpose() * A;
  Assign(&A, A.block(0, 0, 1, 1), edge.Jacobian(0).transpose() * A * edge.Jacobian(1));
  Assign(&A, A.block(0, 0, 1, 1), J.transpose() * A * edge.Jacobian(1));
  Assign(&A, A.block(0, 0, 1, 1), A * edge.Jacobian(1));
  const VecX Ar = edge.Information() * edge.Residual(), sAr = s * (edge.Information() * edge.Residual());
  x = A * edge.Residual();
}

inline void Containers(std::vector<std::shared_ptr<Edge>> edges, std::vector<std::shared_ptr<Vertex>> vertices,
                       std::map<int, std::shared_ptr<Vertex>> by_id, std::set<int> ids, std::vector<int> numbers,
                       std::vector<VecX> vectors) {
  for (const auto& edge : edges) edges.push_back(edge);
  for (const auto& vertex : vertices) vertices = {vertex, vertices[0]};
  for (const auto& [id, vertex] : by_id) by_id.insert({id, vertex});
  for (const int id : ids) ids.insert(id);
  for (const int number : numbers) numbers.push_back(number);
  for (const VecX& one : vectors) vectors.push_back(one);
  edges = {edges[0]};
  edges.clear();
  vertices.clear();
  vertices.push_back(by_id.find(0) == by_id.end() ? by_id.at(0) : by_id[0]);
  if (std::find(vertices.begin(), vertices.end(), vertices.back()) != vertices.end()) numbers.clear();
  if (std::find(numbers.begin(), numbers.end(), 0) != numbers.end() && ids.count(0) > 0) ids.clear();
}

inline void OfSpace(MatXX A, VecX x, Vec3 p, Mat33 R, Eigen::Quaterniond q, double s, int n) {
  Eigen::Matrix<double, 3, Eigen::Dynamic> axes = p;
  Assign(&axes, A.block(0, 0, 3, n), R * axes);
  Assign(&axes, A.block(0, 0, 3, n), R.transpose() * axes);
  Assign(&axes, A.block(0, 0, 3, n), -R * axes);
  A.rightCols(n) = -R * axes;
  A.topRightCorner(3, n) = A.bottomRightCorner(3, n) = R * axes;
  A.topLeftCorner<3, 3>().setIdentity();
  A.block<3, 3>(n, n) = R;
  A.block<3, 3>(n, n).setIdentity();
  A.col(n) = x;
  A.col(n) = axes.col(n).cross(p);
  x.head<3>() = x.segment<3>(n) = p;
  p = q * p + s * R * p - R.transpose() * (p - s * p);
  p += s * p;
  p = -p.normalized() + q.conjugate() * (p - p);
  q = (q * q).normalized();
  R = R.transpose() * R * R - s * Mat33::Identity();
  R = q.toRotationMatrix() + s * R * R - R;
  const Mat33 product = R * R.transpose(), scaled = s * R, negative = -R;
  const Vec3 turned = R * p, back = R.transpose() * (p - p), sum = p + q * p - s * p;
  s = p.norm() + p.dot(p) + p.squaredNorm() + std::abs(p.z());
}

/// Of fixed sizes, whose products are unrolled.
template <int kRows, int kColumns>
void OfFixedSize(Mat33 R, Vec3 p, double s) {
  Eigen::Matrix<double, kRows, kRows> A = Eigen::Matrix<double, kRows, kRows>::Identity(), B = A;
  Eigen::Matrix<double, kRows, kColumns> C = Eigen::Matrix<double, kRows, kColumns>::Zero();
  Eigen::Matrix<double, kColumns, 1> x;
  x << Vec3::Constant(s), p;
  const auto assign = [&](auto part) {
    part = R;
    part = -R;
    part = s * R;
    part = R * R;
    part = -R * R;
    part = s * R * R;
    part = -s * R * R;
    part = R * R * s;
    part.setIdentity();
  };
  assign(A.template block<3, 3>(0, 0));
  assign(C.template block<3, 3>(0, 0));
  A = A * B * A.transpose();
  A += B * A * B.transpose();
  A += C * x.asDiagonal() * C.transpose();
  A = A + B;
}

inline void OfCameras(Mat33 R, Vec3 p, double s) {
  Mat23 A, B;
  A << s, s, s, s, s, s;
  B = A * R;
  A = A * R.transpose();
  B = A * R * R + s * A - B;
  const Mat23 C = A * R, D = A * R.transpose();
  Mat26 both;
  both << -A, A * R;
  Eigen::Matrix<double, 1, 6> row;
  row << p.transpose(), -p.transpose() * R * R;
}

inline void Fixed(const Mat33& R, const Vec3& p, double s) { OfFixedSize<9, 6>(R, p, s); }

}  // namespace ch5::usual
