#include "ch5_backend/marginalize/edge_prior.h"

#include <algorithm>
#include <stdexcept>

#include "ch5_backend/linear/aligned_vector.h"
#include "ch5_backend/math/dense_kernels.h"
#include "ch5_backend/math/vector_kernels.h"

namespace ch5 {
namespace {

// How many leading rows and columns are those of the identity; in a pose's block only the rotation's differ.
Eigen::Index LeadingIdentity(const Eigen::Map<MatXX>& B) {
  Eigen::Index k = 0;
  while (k < B.rows() && B(k, k) == 1.0 && B.row(k).squaredNorm() == 1.0 && B.col(k).squaredNorm() == 1.0) ++k;
  return k;
}

// −JᵀJ, its lower half. By the kernels, as each image makes a new prior and Eigen takes many times as long without AVX.
ArrayMatrix MinusGram(const MatXX& J) {
  const int rows = static_cast<int>(J.rows()), n = static_cast<int>(J.cols());
  ArrayVector Jt(J.size() + kernels::kOverread);
  Jt.setZero();
  Eigen::Map<MatXX>(Jt.data(), n, rows) = J.transpose();
  ArrayMatrix minus_JtJ(n, n);
  minus_JtJ.setZero();
  kernels::SubtractProductAAt(n, rows, Jt.data(), n, minus_JtJ.data(), n);
  return minus_JtJ;
}

}  // namespace

EdgePrior::EdgePrior(Prior prior)
    : Edge(static_cast<int>(prior.r0.size()), VertexSpan(prior.vertices.data(), prior.vertices.size()), nullptr,
           nullptr),
      prior_(std::move(prior)),  // which moves the list, not its vertices
      r_(prior_.r0.size()),
      minus_delta_(prior_.J.cols()),
      W_(prior_.r0.size(), prior_.r0.size()) {
  jacobians_.assign(prior_.vertices.size(), nullptr);
  const auto rows = prior_.r0.size();
  Eigen::Index columns = 0;
  if (prior_.x0.size() != prior_.vertices.size()) throw std::invalid_argument("EdgePrior: one x0 per vertex is needed");
  for (size_t i = 0; i < prior_.vertices.size(); ++i) {
    if (!prior_.vertices[i] || prior_.x0[i].size() != prior_.vertices[i]->Dimension()) {
      throw std::invalid_argument("EdgePrior: x0 " + std::to_string(i) + " does not fit its vertex");
    }
    columns += prior_.vertices[i]->LocalDimension();
  }
  if (prior_.J.rows() != rows || prior_.J.cols() != columns) {
    throw std::invalid_argument("EdgePrior: J must be " + std::to_string(rows) + "x" + std::to_string(columns) +
                                ", got " + std::to_string(prior_.J.rows()) + "x" + std::to_string(prior_.J.cols()));
  }
  SetResidual(prior_.r0);
  W_.setIdentity();
  SetMemory(r_.data(), W_.data());
}

void EdgePrior::TakeJacobians() const {
  J_ = prior_.J;
  double* column = J_.data();
  for (size_t i = 0; i < prior_.vertices.size(); ++i) {
    jacobians_[i] = column;
    column += prior_.J.rows() * prior_.vertices[i]->LocalDimension();
  }
}

// r = r₀ + J (x ⊟ x₀).  Leutenegger (2015), §4.3
void EdgePrior::ComputeResidual() {
  ArrayVector delta(prior_.J.cols());
  Eigen::Index row = 0;
  for (size_t i = 0; i < prior_.vertices.size(); ++i) {
    prior_.vertices[i]->MinusInto(prior_.x0[i], delta.data() + row, nullptr);
    row += prior_.vertices[i]->LocalDimension();
  }
  // A solver asks for the Hessian where it has just asked for the cost.
  if (minus_delta_ == -delta) return;
  minus_delta_ = -delta;
  r_ = prior_.r0;
  const int rows = static_cast<int>(prior_.J.rows()), n = static_cast<int>(prior_.J.cols());
  kernels::SubtractProductAx(rows, n, prior_.J.data(), rows, minus_delta_.data(), r_.data());
}

void EdgePrior::ComputeJacobians() {
  if (J_.size() != prior_.J.size()) TakeJacobians();
  if (keep_jacobian_) {
    J_ = prior_.J;
    return;
  }
  Eigen::Index column = 0;
  for (size_t i = 0; i < prior_.vertices.size(); ++i) {
    const Vertex& vertex = *prior_.vertices[i];
    const auto J_i = prior_.J.middleCols(column, vertex.LocalDimension());
    J_.middleCols(column, vertex.LocalDimension()).noalias() = J_i * vertex.MinusJacobian(prior_.x0[i]);
    column += vertex.LocalDimension();
  }
}

bool EdgePrior::NegativeProductsInto(double* products) {
  if (GetLossFunction() || IsotropicInformation() != 1.0) return false;
  ComputeResidual();
  const Eigen::Index n = prior_.J.cols();
  if (!minus_JtJ_) minus_JtJ_.emplace(MinusGram(prior_.J));
  Eigen::Map<MatXX> C(products, n + 1, n + 1);
  Eigen::Index column = 0;
  for (const auto& vertex : prior_.vertices) {  // the lower half, and all of the blocks on the diagonal
    const Eigen::Index begin = column, end = begin + vertex->LocalDimension();
    for (; column < end; ++column) {
      for (Eigen::Index row = begin; row < column; ++row) C(row, column) = (*minus_JtJ_)(column, row);
      std::copy_n(&(*minus_JtJ_)(column, column), n - column, &C(column, column));
    }
  }
  ArrayVector b(n);  // −Jᵀr
  b.setZero();
  const int rows = static_cast<int>(prior_.J.rows());
  kernels::SubtractProductAtx(rows, static_cast<int>(n), prior_.J.data(), rows, r_.data(), b.data());
  C.row(n).head(n) = b.transpose();
  C(n, n) = -r_.squaredNorm();
  if (keep_jacobian_) return true;
  Eigen::Index begin = 0;
  for (size_t i = 0; i < prior_.vertices.size(); ++i) {
    const Eigen::Index dim = prior_.vertices[i]->LocalDimension();
    ArrayMatrix B(dim, dim);
    prior_.vertices[i]->MinusInto(prior_.x0[i], nullptr, B.data());
    const Eigen::Index same = LeadingIdentity(B), rest = B.rows() - same, first = begin + same;
    const int rows_below = static_cast<int>(n + 1 - begin), columns_before = static_cast<int>(begin + B.rows());
    if (rest == 3) {
      const Mat33 B_rest = B.bottomRightCorner<3, 3>();
      kernels::MultiplyThreeColumns(rows_below, B_rest.data(), &C(begin, first), static_cast<int>(n + 1));
      kernels::MultiplyThreeRows(columns_before, B_rest.data(), &C(first, 0), static_cast<int>(n + 1));
    } else if (rest > 0) {
      const MatXX B_rest = B.bottomRightCorner(rest, rest);
      C.block(begin, first, rows_below, rest) *= B_rest;
      C.block(first, 0, rest, columns_before).applyOnTheLeft(B_rest.transpose());
    }
    begin += B.rows();
  }
  return true;
}

}  // namespace ch5
