#pragma once
/// The grader's precompiled header of a student's file: the headers that the homework includes and, instantiated and
/// compiled beforehand, what such files typically say of matrices. A file then compiles in a second in place of five.
///
/// Nothing here is an answer: each matrix is combined with each.

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <set>

#include "ch5_backend/consistency/gauge_freedom.h"
#include "ch5_backend/dense/block_diagonal.h"
#include "ch5_backend/dense/blocks/plain_block_solver.h"
#include "ch5_backend/dense/problem.h"
#include "ch5_backend/homework_missing.h"
#include "ch5_backend/marginalize/marginalization_error.h"
#include "ch5_backend/marginalize/marginalization_info.h"
#include "ch5_backend/marginalize/square_root.h"
#include "ch5_backend/math/psd.h"
#include "ch5_backend/open_tasks/open_tasks.h"
#include "ch5_backend/simulate/mono_ba.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_backend/types/vertices.h"
#include "ch5_backend/window/landmarks.h"
#include "ch5_backend/window/vins_window.h"

namespace ch5::homework {

using MatMap = Eigen::Map<const MatXX>;
using VecMap = Eigen::Map<const VecX>;

// An expression on the right of each assignment; `whole` and `part` are a matrix and a block, or a vector and a segment.
template <typename Expression, typename Whole, typename Part>
void Assign(const Expression& expression, Whole& whole, Part part) {
  const Whole copy = expression;
  whole = expression;
  whole -= expression;
  part += expression;
  part -= expression;
  part.noalias() += expression;
}

template <typename Left>
void Multiply(const Left& left, MatXX& M, VecX& v) {
  const MatXX& C = M;
  const VecX& c = v;
  const auto B = M.block(0, 0, 1, 1);
  const auto s = v.segment(0, 1);
  Assign(left * C, M, B);
  Assign(left * C.transpose(), M, B);
  Assign(left * C.block(0, 0, 1, 1), M, B);
  Assign(left * MatMap(C.data(), 1, 1), M, B);
  Assign(left * c, v, s);
  Assign(left * c.segment(0, 1), v, s);
  Assign(left * VecMap(c.data(), 1), v, s);
}

// a ± b and multiples, of matrices or of vectors.
template <typename A, typename Whole, typename Part, typename Product>
void Combine(const A& a, const Product& product, Whole& whole, Part part) {
  const Whole& b = whole;
  Assign(a, whole, part);
  Assign(-a, whole, part);
  Assign(2.0 * a, whole, part);
  Assign(a + b, whole, part);
  Assign(a - b, whole, part);
  Assign(a - product, whole, part);
}

template <int Rows>
void OfRows(MatXX& M, VecX& v) {
  using Fixed = Eigen::Matrix<double, Rows, Rows>;
  using Wide = Eigen::Matrix<double, Rows, Eigen::Dynamic>;
  Fixed F = Fixed::Identity();
  Wide W(Rows, 2);
  v.segment<Rows>(0) = F * v.segment<Rows>(0);
  v.segment<Rows>(0) += v.segment<Rows>(0);
  M.block<Rows, Rows>(0, 0).setIdentity();
  M.block<Rows, Rows>(0, 0) = F;
  M.block<Rows, Rows>(0, 0) += F;
  M.block(0, 0, Rows, Rows) = F;
  M.block(0, 0, Rows, Rows).setIdentity();
  M.middleCols<Rows>(0).setIdentity();
  W = F * W;
  W.setZero();
  M.block(0, 0, Rows, 2) = W;
  M.block(0, 0, Rows, 2) = F * W;
  M.block(0, 0, Rows, 2) = F.transpose() * W;
  M.block(0, 0, Rows, 2) = -F * W;
  const MatXX weighted = 2.0 * Fixed::Identity();
}

inline void PairsAndSums(MatXX& M, VecX& v) {
  const MatXX& C = M;
  const VecX& c = v;
  const auto B = M.block(0, 0, 1, 1);
  const auto s = v.segment(0, 1);
  const MatMap J(C.data(), 1, 1);
  Multiply(C, M, v);
  Multiply(C.transpose(), M, v);
  Multiply(J.transpose(), M, v);
  Combine(C, C * C, M, B);
  Combine(C.block(0, 0, 1, 1), C * C, M, B);
  Combine(c, C * c, v, s);
  Combine(c.segment(0, 1), C * c, v, s);
}

inline void LongProducts(MatXX& M, VecX& v) {
  const MatXX& C = M;
  const VecX& c = v;
  const auto B = M.block(0, 0, 1, 1);
  const auto s = v.segment(0, 1);
  const MatMap J(C.data(), 1, 1);
  Assign(C * C * C, M, B);
  Assign(C * C * C.transpose(), M, B);
  Assign(C.transpose() * C * C, M, B);
  Assign(C * C * c, v, s);
  Assign(C * (C * c), v, s);
  Assign(C * (c - C * c), v, s);
  Assign(J.transpose() * C * J, M, B);
  Assign(J.transpose() * C * c, v, s);
  Assign(2.0 * J.transpose() * c, v, s);
  Assign(2.0 * (C * c), v, s);
  Assign(2.0 * (J * VecMap(c.data(), 1)), v, s);
  Assign(C - C * C * C, M, B);
  Assign(c - C * C * c, v, s);
  Assign(c.segment(0, 1) - C * C * c.segment(0, 1), v, s);
  Assign(C.block(0, 0, 1, 1) - C * C * C, M, B);
}

inline void Diagonals(MatXX& M, VecX& v) {
  const MatXX& C = M;
  const VecX& c = v;
  const auto B = M.block(0, 0, 1, 1);
  const auto s = v.segment(0, 1);
  Assign(C * c.asDiagonal() * C.transpose(), M, B);
  Assign(c.asDiagonal() * C.transpose(), M, B);
  Assign(c.asDiagonal() * C.transpose() * c, v, s);
  Assign(c.cwiseSqrt().asDiagonal() * C.transpose(), M, B);
  Assign(c.cwiseSqrt().asDiagonal() * C.transpose() * c, v, s);
  Assign(c.cwiseSqrt(), v, s);
  Assign(c.cwiseInverse(), v, s);
  Assign(VecMap(c.data(), 1), v, s);
  const VecX kept = (c.array() > 1e-8).select(c.array(), 0.0),
             inverted = (c.array() > 1e-8).select(c.array().inverse(), 0.0);
}

inline void Rest(MatXX& M, VecX& v) {
  const VecX& c = v;
  OfRows<3>(M, v);
  OfRows<6>(M, v);
  M.setZero();
  M.setZero(1, 1);
  M.setIdentity();
  M = MatXX::Zero(1, 1);
  M = MatXX::Identity(1, 1);
  v.setZero();
  v.setZero(1);
  v = VecX::Zero(1);
  const bool finite = M.allFinite() && v.allFinite();
  const double sums = finite ? v.dot(c) + v.norm() + M.norm() : 0.0;
  M(0, 0) = sums;
}

}  // namespace ch5::homework
