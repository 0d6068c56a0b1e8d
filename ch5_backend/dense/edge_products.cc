#include "ch5_backend/dense/edge_products.h"

namespace ch5 {
namespace {

// C (a×b) = scale Aᵀ B;  A is rows×a, B rows×b, all column-major.
void TransposeProductOfAny(double scale, const double* A, const double* B, int rows, int a, int b, double* C) {
  for (int j = 0; j < b; ++j) {
    for (int i = 0; i < a; ++i) {
      double sum = 0.0;
      for (int k = 0; k < rows; ++k) sum += A[i * rows + k] * B[j * rows + k];
      C[j * a + i] = scale * sum;
    }
  }
}

// The same for two rows, an image's, and a number of columns that is known: with A's rows apart, the loop over i is
// one for vector registers.
template <int Columns>
void TransposeProductOfTwoRows(double scale, const double* __restrict A, const double* __restrict B, int b,
                               double* __restrict C) {
  double row_0[Columns], row_1[Columns];
  for (int i = 0; i < Columns; ++i) {
    row_0[i] = scale * A[2 * i];
    row_1[i] = scale * A[2 * i + 1];
  }
  for (int j = 0; j < b; ++j, B += 2, C += Columns) {
    for (int i = 0; i < Columns; ++i) C[i] = row_0[i] * B[0] + row_1[i] * B[1];
  }
}

void TransposeProduct(double scale, const double* A, const double* B, int rows, int a, int b, double* C) {
  if (rows == 2 && a == 6) return TransposeProductOfTwoRows<6>(scale, A, B, b, C);  // a pose
  if (rows == 2 && a == 1) return TransposeProductOfTwoRows<1>(scale, A, B, b, C);  // an inverse depth
  if (rows == 2 && a == 3) return TransposeProductOfTwoRows<3>(scale, A, B, b, C);  // a point
  if (rows == 2 && a == 9) return TransposeProductOfTwoRows<9>(scale, A, B, b, C);  // a camera of a BAL problem
  TransposeProductOfAny(scale, A, B, rows, a, b, C);
}

}  // namespace

void EdgeProducts::Compute(const Edge& edge) {
  const auto& vertices = edge.Vertices();
  const int rows = edge.ResidualDimension();
  num_vertices_ = vertices.size();
  if (blocks_.size() < num_vertices_ * num_vertices_) blocks_.resize(num_vertices_ * num_vertices_);
  if (gradients_.size() < num_vertices_) gradients_.resize(num_vertices_);

  // W_ρ = w I without a loss and with W = w I, the most frequent case; else W_ρ in full.
  const bool is_scalar = !edge.GetLossFunction() && edge.IsotropicInformation() >= 0.0;
  const double scale = is_scalar ? edge.IsotropicInformation() : 1.0;
  if (!is_scalar) {
    double drho;
    edge.RobustInfo(&drho, &W_rho_);
    Wr_ = drho * (edge.Information() * edge.Residual());
  }
  const double* Wr = is_scalar ? edge.Residual().data() : Wr_.data();

  for (size_t j = 0; j < num_vertices_; ++j) {
    const int dim_j = vertices[j]->LocalDimension();
    if (vertices[j]->OrderingId() < 0) continue;
    const double* J_j = edge.Jacobian(j).data();
    gradients_[j].resize(dim_j);
    TransposeProduct(scale, J_j, Wr, rows, dim_j, 1, gradients_[j].data());
    const double* WJ_j = J_j;
    if (!is_scalar) {
      WJ_.noalias() = W_rho_ * edge.Jacobian(j);
      WJ_j = WJ_.data();
    }
    for (size_t i = 0; i <= j; ++i) {
      const int dim_i = vertices[i]->LocalDimension();
      if (vertices[i]->OrderingId() < 0) continue;
      MatXX& block = blocks_[i * num_vertices_ + j];
      block.resize(dim_i, dim_j);
      TransposeProduct(scale, edge.Jacobian(i).data(), WJ_j, rows, dim_i, dim_j, block.data());
    }
  }
}

}  // namespace ch5
