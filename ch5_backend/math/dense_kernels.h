#pragma once
/// The inner loops of a dense Cholesky factorization, at the speed of the processor at hand (dispatch.h).
///
/// All matrices are column-major, element (i, j) of A at A[i + j·lda]. Rows are read in whole vectors, so kOverread
/// numbers behind the last element must be readable. Neither their values nor those above a diagonal matter to the result;
/// but they should have been set, since products of subnormal numbers, which unset memory may hold, take fifty times as long.

#include "ch5_backend/math/parallel.h"

namespace ch5::kernels {

constexpr int kOverread = 24;

/// Whether the product is added to C's old values.
enum class Accumulate { kYes, kNo };

/// C −= A Bᵀ, or C = −A Bᵀ; A m×k, B n×k, C m×n, k > 0 unless it accumulates. C may lie in A's or B's matrix if it
/// shares no column with them.
void SubtractProductABt(int m, int n, int k, const double* A, int lda, const double* B, int ldb, double* C, int ldc,
                        Accumulate accumulate = Accumulate::kYes);

/// The lower half of C −= A Aᵀ, or of C = −A Aᵀ; A n×k, C n×n. What lies above C's diagonal is overwritten with
/// meaningless values.
/// @param room  how many numbers behind each column of C may be overwritten; with 7, only whole vectors are written
void SubtractProductAAt(int n, int k, const double* A, int lda, double* C, int ldc,
                        Accumulate accumulate = Accumulate::kYes, int room = 0);

/// A = L Lᵀ in place, A k×k; reads and writes the lower half.
/// @param min_pivot  k numbers: the square of each diagonal entry of L must exceed its own
/// @param pool  null: the calling thread alone
/// @return false if one does not (or is not finite); A is then partly overwritten
bool Factor(int k, double* A, int lda, const double* min_pivot, ThreadPool* pool = nullptr);

/// What remains of [A_11 ·; A_21 A_22] once L_11 has been factored: A_21 ← L_21 = A_21 L_11⁻ᵀ and the lower half of
/// A_22 −= L_21 L_21ᵀ, or A_22 = −L_21 L_21ᵀ; L_11 k×k, A_21 r×k.
void Eliminate(int r, int k, const double* L_11, double* A_21, int lda, double* A_22, int lda_22, Accumulate accumulate,
               ThreadPool* pool);

/// X ← X L⁻ᵀ with X m×k and L k×k, lower triangular.
void SolveRows(int m, int k, const double* L, int ldl, double* X, int ldx);

}  // namespace ch5::kernels
