#pragma once
/// Products of a dense matrix and a vector, and solves with a triangle, for matrices of a window's size: Eigen compiled for
/// any processor takes two to three times as long. Matrices are as in dense_kernels.h, but nothing is read behind them.

namespace ch5::kernels {

/// y −= A x, A m×n.
void SubtractProductAx(int m, int n, const double* A, int lda, const double* x, double* y);
/// y −= Aᵀ x, A m×n.
void SubtractProductAtx(int m, int n, const double* A, int lda, const double* x, double* y);

/// C ← C B, C m×3, B 3×3.
void MultiplyThreeColumns(int m, const double* B, double* C, int ldc);
/// C ← Bᵀ C, C 3×n, B 3×3. The number below each column is read, and written as it was.
void MultiplyThreeRows(int n, const double* B, double* C, int ldc);

/// x ← L⁻¹ x, L k×k, lower triangular.
void SolveLower(int k, const double* L, int ldl, double* x);
/// x ← L⁻ᵀ x.
void SolveLowerTranspose(int k, const double* L, int ldl, double* x);

}  // namespace ch5::kernels
