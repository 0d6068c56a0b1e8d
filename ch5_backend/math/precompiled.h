#pragma once
/// The precompiled header of this project's own files; no file includes it. Eigen's large functions are compiled once, in
/// precompiled.cc, in place of in each file that factors or multiplies a dynamic matrix: 2 to 7 s a file.

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>

#include "ch5_backend/math/eigen_types.h"

// Their declarations are Eigen 3.4's; and the student's files are compiled without -march=native.
#if EIGEN_VERSION_AT_LEAST(3, 4, 0) && !EIGEN_VERSION_AT_LEAST(3, 4, 90) && !defined(CH5_NATIVE)
#define CH5_COMPILED_ONCE(extern)                                                                                      \
  extern template void tridiagonalization_inplace(MatrixXd&, VectorXd&, VectorXd&, VectorXd&, bool);                   \
  extern template ComputationInfo computeFromTridiagonal_impl(VectorXd&, VectorXd&, Index, bool, MatrixXd&);           \
  extern template Index llt_inplace<double, Lower>::blocked(MatrixXd&);                                                \
  extern template bool ldlt_inplace<Lower>::unblocked(MatrixXd&, Transpositions<Dynamic>&, VectorXd&, SignMatrix&);    \
  extern template void partial_lu_inplace(MatrixXd&, Transpositions<Dynamic>&,                                         \
                                          Transpositions<Dynamic>::StorageIndex&);                                     \
  extern template struct gebp_kernel<double, double, Index, blas_data_mapper<double, Index, ColMajor, Unaligned, 1>,   \
                                     gebp_traits<double, double>::mr, gebp_traits<double, double>::nr, false, false>;  \
  extern template struct general_matrix_matrix_product<Index, double, ColMajor, false, double, ColMajor, false,        \
                                                       ColMajor, 1>;                                                   \
  extern template struct general_matrix_matrix_product<Index, double, RowMajor, false, double, ColMajor, false,        \
                                                       ColMajor, 1>;                                                   \
  extern template struct general_matrix_matrix_product<Index, double, ColMajor, false, double, RowMajor, false,        \
                                                       ColMajor, 1>;                                                   \
  extern template struct general_matrix_vector_product<Index, double, const_blas_data_mapper<double, Index, ColMajor>, \
                                                       ColMajor, false, double,                                        \
                                                       const_blas_data_mapper<double, Index, RowMajor>, false, 0>;     \
  extern template struct general_matrix_vector_product<Index, double, const_blas_data_mapper<double, Index, RowMajor>, \
                                                       RowMajor, false, double,                                        \
                                                       const_blas_data_mapper<double, Index, ColMajor>, false, 0>;     \
  extern template struct gemm_pack_lhs<double, Index, const_blas_data_mapper<double, Index, ColMajor>,                 \
                                       gebp_traits<double, double>::mr, gebp_traits<double, double>::LhsProgress,      \
                                       gebp_traits<double, double>::LhsPacket4Packing, ColMajor>;                      \
  extern template struct gemm_pack_lhs<double, Index, const_blas_data_mapper<double, Index, RowMajor>,                 \
                                       gebp_traits<double, double>::mr, gebp_traits<double, double>::LhsProgress,      \
                                       gebp_traits<double, double>::LhsPacket4Packing, RowMajor>;                      \
  extern template void evaluateProductBlockingSizesHeuristic<double, double, 1, Index>(Index&, Index&, Index&, Index); \
  extern template void evaluateProductBlockingSizesHeuristic<double, double, 4, Index>(Index&, Index&, Index&, Index); \
  extern template struct triangular_solve_matrix<double, Index, OnTheLeft, Lower, false, ColMajor, ColMajor, 1>;       \
  extern template struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, RowMajor, ColMajor, 1>;       \
  extern template struct triangular_solve_matrix<double, Index, OnTheLeft, UnitLower, false, ColMajor, ColMajor, 1>;   \
  extern template struct triangular_solve_matrix<double, Index, OnTheLeft, UnitUpper, false, RowMajor, ColMajor, 1>;   \
  extern template struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, ColMajor, ColMajor, 1>;       \
  extern template struct triangular_solver_selector<const MatrixXd, VectorXd, OnTheLeft, Lower, 0, 1>;                 \
  extern template struct triangular_solver_selector<const MatrixXd, VectorXd, OnTheLeft, UnitLower, 0, 1>;             \
  extern template struct triangular_solver_selector<const Transpose<const MatrixXd>, VectorXd, OnTheLeft, Upper, 0,    \
                                                    1>;                                                                \
  extern template struct triangular_solver_selector<const Transpose<const MatrixXd>, VectorXd, OnTheLeft, UnitUpper,   \
                                                    0, 1>;                                                             \
  extern template struct triangular_solve_vector<double, double, Index, OnTheLeft, Lower, false, ColMajor>;            \
  extern template struct triangular_solve_vector<double, double, Index, OnTheLeft, UnitLower, false, ColMajor>;        \
  extern template struct triangular_solve_vector<double, double, Index, OnTheLeft, Upper, false, RowMajor>;            \
  extern template struct triangular_solve_vector<double, double, Index, OnTheLeft, UnitUpper, false, RowMajor>;        \
  extern template void apply_block_householder_on_the_left(Block<MatrixXd>&, const Block<MatrixXd>&,                   \
                                                           const VectorBlock<const VectorXd>&, bool);                  \
  extern template void apply_block_householder_on_the_left(Block<MatrixXd>&, const Block<MatrixXd>&,                   \
                                                           const Block<VectorXd, Dynamic, 1>&, bool);

namespace Eigen::internal {
CH5_COMPILED_ONCE(extern)
}  // namespace Eigen::internal
#endif
