#pragma once
/// A residual that is compiled by itself and used from elsewhere, such as the Python module: a formula, written as for
/// AutoDiffEdge, behind a C function.
///
///   struct Curve {  // r = exp(a t² + b t + c) − y
///     template <typename T>
///     static Eigen::Matrix<T, 1, 1> Evaluate(const double* ty, const Eigen::Matrix<T, 3, 1>& abc) {
///       return Eigen::Matrix<T, 1, 1>(exp(abc[0] * ty[0] * ty[0] + abc[1] * ty[0] + abc[2]) - ty[1]);
///     }
///   };
///   CH5_FORMULA(curve, Curve, /*rows=*/1, /*numbers=*/2, /*parameters of each vertex=*/3)
///
///   g++ -O2 -std=c++17 -shared -fPIC $(pkg-config --cflags ch5_backend) curve.cc -o curve.so
///   curve = ch5.Formula("./curve.so", "curve")

#include <utility>

#include "ch5_backend/math/dual.h"

/// What a compiled formula exports: its sizes and the function that evaluates it.
extern "C" struct Ch5Formula {
  int rows, numbers, vertices;
  const int* parameters;  ///< of each vertex
  /// J may be null, else each ∂r/∂x_i is column-major.
  void (*evaluate)(const double* const* x, const double* numbers, double* r, double* const* J);
};

namespace ch5 {

// A formula is linked with nothing, not with the library that has this function (math/eigen_types.h).
[[gnu::weak]] void SameStandardLibrary(const std::vector<std::string>&) {}

template <typename Formula, int kRows, int kNumbers, int... kParameters>
struct CFormula {
  static constexpr int kSizes[] = {kParameters...};
  using Number = Dual<(kParameters + ...)>;

  template <typename T, int I, int N>
  static Eigen::Matrix<T, N, 1> Unknowns(const double* x) {
    Eigen::Matrix<T, N, 1> unknowns;
    int before = 0;
    for (int i = 0; i < I; ++i) before += kSizes[i];
    for (int k = 0; k < N; ++k) {
      if constexpr (std::is_same_v<T, double>)
        unknowns[k] = x[k];
      else
        unknowns[k] = T::Unknown(x[k], before + k);
    }
    return unknowns;
  }
  template <typename T, int... I>
  static Eigen::Matrix<T, kRows, 1> At(const double* const* x, const double* numbers,
                                       std::integer_sequence<int, I...>) {
    return Formula::template Evaluate<T>(numbers, Unknowns<T, I, kParameters>(x[I])...);
  }
  static void Evaluate(const double* const* x, const double* numbers, double* r, double* const* J) {
    constexpr std::make_integer_sequence<int, sizeof...(kParameters)> every{};
    if (!J) return void(Eigen::Map<Eigen::Matrix<double, kRows, 1>>(r) = At<double>(x, numbers, every));
    const Eigen::Matrix<Number, kRows, 1> duals = At<Number>(x, numbers, every);
    for (int row = 0; row < kRows; ++row) {
      r[row] = duals[row].value;
      int column = 0;
      for (size_t i = 0; i < sizeof...(kParameters); ++i)
        for (int k = 0; k < kSizes[i]; ++k) J[i][k * kRows + row] = duals[row].gradient[column++];
    }
  }
  static constexpr Ch5Formula kDescription{kRows, kNumbers, sizeof...(kParameters), kSizes, Evaluate};
};

}  // namespace ch5

#define CH5_FORMULA(name, Formula, rows, numbers, ...)                         \
  extern "C" __attribute__((visibility("default"))) const Ch5Formula* name() { \
    return &ch5::CFormula<Formula, rows, numbers, __VA_ARGS__>::kDescription;  \
  }
