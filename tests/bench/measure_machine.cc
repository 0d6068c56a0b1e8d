#include "tests/bench/measure_machine.h"

#include <algorithm>
#include <chrono>
#include <vector>

#include "ch5_backend/math/simd.h"

namespace ch5::bench {
namespace {

using Clock = std::chrono::steady_clock;
constexpr int kChains = 12;  // independent sums, so that one need not wait for the other
constexpr int kSteps = 2000000;

volatile double sink;         // results go here, or the compiler would leave the work out
volatile double start = 0.5;  // read for each sum, or the compiler would find them equal and keep one

double Seconds(Clock::time_point since) { return std::chrono::duration<double>(Clock::now() - since).count(); }

template <typename Vector>
CH5_INLINE void MultiplyAddBody() {
  Vector sums[kChains], a = {}, b = {};
  for (Vector& sum : sums) sum = Vector{} + start;
  for (size_t i = 0; i < sizeof(Vector) / sizeof(double); ++i) {
    a[i] = 0.999999;
    b[i] = 1e-6;
  }
  for (int step = 0; step < kSteps; ++step) {
    CH5_UNROLL
    for (Vector& sum : sums) sum = sum * a + b;
  }
  for (const Vector& sum : sums) sink = sum[0];
}

template <typename Vector>
CH5_INLINE void ReadBody(const double* x, size_t size) {
  constexpr size_t kWidth = sizeof(Vector) / sizeof(double);
  typedef double InMemory __attribute__((vector_size(sizeof(Vector)), aligned(8)));
  Vector sums[8] = {};
  for (size_t i = 0; i + 8 * kWidth <= size; i += 8 * kWidth) {
    CH5_UNROLL
    for (size_t k = 0; k < 8; ++k) sums[k] += *reinterpret_cast<const InMemory*>(x + i + k * kWidth);
  }
  for (const Vector& sum : sums) sink = sum[0];
}

typedef double Pair __attribute__((vector_size(16)));
void MultiplyAdd() { MultiplyAddBody<Pair>(); }
CH5_WITH_AVX2 void MultiplyAddAvx2() { MultiplyAddBody<Lanes>(); }
CH5_WITH_AVX512 void MultiplyAddAvx512() { MultiplyAddBody<WideLanes>(); }
CH5_WITH_AVX2 void ReadAvx2(const double* x, size_t size) { ReadBody<Lanes>(x, size); }
void Read(const double* x, size_t size) { ReadBody<Pair>(x, size); }

// The best of several runs: what disturbs them only makes them slower.
template <typename Work>
double BestSeconds(int runs, const Work& work) {
  double best = 1e300;
  for (int run = 0; run < runs; ++run) {
    const Clock::time_point start = Clock::now();
    work();
    best = std::min(best, Seconds(start));
  }
  return best;
}

}  // namespace

double PeakGflops() {
  const int lanes = HasAvx512() ? 8 : HasAvx2() ? 4 : 2;
  const double seconds = BestSeconds(9, [] {
    HasAvx512() ? MultiplyAddAvx512() : HasAvx2() ? MultiplyAddAvx2() : MultiplyAdd();
  });
  return 2e-9 * lanes * kChains * kSteps / seconds;
}

double ReadBandwidth(double megabytes) {
  const std::vector<double> numbers(static_cast<size_t>(megabytes * 1e6 / sizeof(double)), 1.0);
  const int repeat = std::max(1, static_cast<int>(256.0 / megabytes));
  const double seconds = BestSeconds(9, [&] {
    for (int i = 0; i < repeat; ++i) {
      HasAvx2() ? ReadAvx2(numbers.data(), numbers.size()) : Read(numbers.data(), numbers.size());
    }
  });
  return 1e-3 * megabytes * repeat / seconds;
}

}  // namespace ch5::bench
