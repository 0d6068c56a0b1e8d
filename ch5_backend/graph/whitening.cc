#include "ch5_backend/graph/whitening.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace ch5 {

void FactorPsd(const double* W, int n, double* F) {
  thread_local std::vector<double> rest;
  rest.assign(W, W + n * n);
  std::fill_n(F, n * n, 0.0);
  double largest = 0.0;
  for (int i = 0; i < n; ++i) largest = std::max(largest, W[i * n + i]);
  const double rounding = n * std::numeric_limits<double>::epsilon() * largest;
  for (int k = 0; k < n; ++k) {
    int pivot = 0;
    for (int i = 1; i < n; ++i) {
      if (rest[i * n + i] > rest[pivot * n + pivot]) pivot = i;
    }
    if (!(rest[pivot * n + pivot] > rounding)) return;
    double* row = F + k * n;
    const double root = std::sqrt(rest[pivot * n + pivot]);
    for (int i = 0; i < n; ++i) row[i] = rest[pivot * n + i] / root;
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) rest[j * n + i] -= row[i] * row[j];
    }
    for (int i = 0; i < n; ++i) rest[pivot * n + i] = rest[i * n + pivot] = 0.0;
  }
}

void Whiten(const Edge& edge, double* M, double* r_tilde) {
  const int n = edge.ResidualDimension();
  const auto r = edge.Residual();
  thread_local std::vector<double> memory;
  memory.resize(static_cast<size_t>(n * n));
  double* F = memory.data();
  FactorPsd(edge.Information().data(), n, F);
  double s = 0.0;
  for (int k = 0; k < n; ++k) {
    r_tilde[k] = 0.0;
    for (int c = 0; c < n; ++c) r_tilde[k] += F[k * n + c] * r[c];
    s += r_tilde[k] * r_tilde[k];
  }
  const RobustWeight robust = edge.GetRobustWeight();
  const double root = std::sqrt(robust.weight), shrink = Shrink(robust, s);
  for (int c = 0; c < n; ++c) {
    double g = 0.0;  // of (Fr)ᵀF
    for (int k = 0; k < n && shrink != 1.0; ++k) g += r_tilde[k] * F[k * n + c];
    const double bend = shrink == 1.0 ? 0.0 : (1.0 - shrink) / s * g;
    for (int k = 0; k < n; ++k) M[k * n + c] = root * (F[k * n + c] - bend * r_tilde[k]);
  }
  for (int k = 0; k < n; ++k) r_tilde[k] *= root / shrink;
}

}  // namespace ch5
