// The window dumps: 8 iterations of the sparse solver, and the marginalization of the oldest frame in three ways.

#include <benchmark/benchmark.h>

#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/marginalize/qr_elimination.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/inertial/preintegration.h"
#include "tests/window/oldest.h"

namespace ch5 {
namespace {

WindowDump Read(const std::string& name) {
  return ReadWindowDump(std::string(CH5_DATA_DIR) + "/windows/" + name + ".txt");
}

void SolveEightIterations(benchmark::State& state, const std::string& name) {
  const WindowDump dump = Read(name);
  Summary summary;
  for (auto _ : state) {
    state.PauseTiming();
    WindowGraph window = BuildWindowGraph(dump);
    state.ResumeTiming();
    SparseOptimizer optimizer(&window.graph);
    SolveOptions options;
    options.algorithm = Algorithm::kDogleg;
    options.max_iterations = 8;
    summary = optimizer.Solve(options);
  }
  state.counters["cost"] = summary.final_cost;
  state.counters["iterations"] = summary.iterations;
}

void MarginalizeByFunction(benchmark::State& state, const std::string& name) {
  const WindowDump dump = Read(name);
  const WindowGraph window = BuildWindowGraph(dump);
  const Oldest oldest(dump, window);
  for (auto _ : state) benchmark::DoNotOptimize(Marginalize(oldest.edges, oldest.drop));
  state.counters["landmarks"] = static_cast<double>(oldest.drop.size() - 2);
}

void MarginalizeLikeVins(benchmark::State& state, const std::string& name) {
  const WindowDump dump = Read(name);
  const WindowGraph window = BuildWindowGraph(dump);
  const Oldest oldest(dump, window);
  for (auto _ : state) benchmark::DoNotOptimize(oldest.MarginalizeLikeVins());
}

void MarginalizeByQr(benchmark::State& state, const std::string& name) {
  const WindowDump dump = Read(name);
  const WindowGraph window = BuildWindowGraph(dump);
  const Oldest oldest(dump, window);
  for (auto _ : state) benchmark::DoNotOptimize(MarginalizeQr<double>(oldest.edges, oldest.drop));
}

void Preintegrate(benchmark::State& state, const std::string& name) {
  const WindowDump dump = Read(name);
  for (auto _ : state) {
    for (const auto& piece : dump.imu) {
      Preintegration imu(piece.samples[0], piece.b_a, piece.b_g, dump.noise);
      for (size_t k = 1; k < piece.samples.size(); ++k) imu.Add(piece.samples[k]);
      benchmark::DoNotOptimize(imu.Covariance());
    }
  }
}

}  // namespace
}  // namespace ch5

int main(int argc, char** argv) {
  for (const char* name : {"vio_S", "vio_M", "vio_L", "vio_Md", "real_euroc_sub2"}) {
    const auto add = [&](const char* what, void (*run)(benchmark::State&, const std::string&)) {
      benchmark::RegisterBenchmark((std::string(name) + "/" + what).c_str(), run, std::string(name))
          ->Unit(benchmark::kMillisecond);
    };
    add("solve", ch5::SolveEightIterations);
    add("marginalize", ch5::MarginalizeByFunction);
    add("marginalize_vins", ch5::MarginalizeLikeVins);
    add("marginalize_qr", ch5::MarginalizeByQr);
    add("preintegrate", ch5::Preintegrate);
  }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
