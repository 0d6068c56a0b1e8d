// Three ways from edges to a prior.  Demmel et al., ICCV 2021; rootba (arXiv 2103.01843)
#include <Eigen/SVD>
#include <chrono>
#include <functional>

#include "ch5_backend/experiments/studies/consistency_flight.h"
#include "ch5_backend/experiments/studies/systems/system_studies.h"
#include "ch5_backend/experiments/studies/window/wrapped_policy.h"
#include "ch5_backend/experiments/studies/window_graph.h"
#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/marginalize/qr_elimination.h"
#include "ch5_backend/math/median.h"

namespace ch5 {
namespace {

constexpr int kRepeats = 51;    // of which the median time counts
constexpr size_t kFrames = 11;  // VINS-Mono's

struct BackEnd {
  const char* name;
  Prior (*marginalize)(const DropSet&);
};
const BackEnd kBackEnds[] = {
    {"schur", [](const DropSet& drop) { return Marginalize(drop.edges, drop.vertices); }},
    {"eigen okvis",
     [](const DropSet& drop) { return Marginalize(drop.edges, drop.vertices, EigenvalueCutoff::Okvis()); }},
    {"eigen vins",
     [](const DropSet& drop) { return Marginalize(drop.edges, drop.vertices, EigenvalueCutoff::Vins()); }},
    {"qr", [](const DropSet& drop) { return MarginalizeQr<double>(drop.edges, drop.vertices); }},
    {"qr float", [](const DropSet& drop) { return MarginalizeQr<float>(drop.edges, drop.vertices); }}};

// The largest relative error of an information nᵀHn over all directions n in which the exact prior has any:
// ‖Aᵀ A − I‖ for A = J V S⁻¹, J_exact = U S Vᵀ. Square, and products entry by entry: all else of Eigen's for long double
// costs 6 s of compilation.
double WorstRelativeError(const Prior& prior, const Prior& exact) {
  using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  const VecX p_inverse = exact.J.colwise().norm().transpose().cwiseMax(1e-300).cwiseInverse();
  Matrix J_exact = Matrix::Zero(exact.J.cols(), exact.J.cols());
  J_exact.topRows(exact.J.rows()) = (exact.J * p_inverse.asDiagonal()).cast<long double>();
  using Svd = Eigen::JacobiSVD<Matrix, Eigen::NoQRPreconditioner>;
  const Svd svd(J_exact, Eigen::ComputeFullV);
  const auto& S = svd.singularValues();
  const Eigen::Index rank = (S.array() > 1e-15L * S[0]).count();
  const Matrix V = svd.matrixV().leftCols(rank) * S.head(rank).cwiseInverse().asDiagonal();
  const Matrix A = Matrix((prior.J * p_inverse.asDiagonal()).cast<long double>()).lazyProduct(V);
  const Matrix error = A.transpose().lazyProduct(A) - Matrix::Identity(rank, rank);
  return static_cast<double>(Svd(error).singularValues()[0]);
}

double MedianMicroseconds(const BackEnd& back_end, const DropSet& drop) {
  std::vector<double> times;
  for (int k = 0; k < kRepeats; ++k) {
    const auto start = std::chrono::steady_clock::now();
    back_end.marginalize(drop);
    times.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count());
  }
  return Median(times);
}

// The prior of the first slide, with J of the old prior made `weakness` times as small.
DropSet DropSetOf(const Window& window, double weakness) {
  DropSet drop = DropSetOfMarginOld(window);
  Prior weak = window.prior->GetPrior();
  weak.J *= weakness;
  weak.r0 *= weakness;
  std::replace(drop.edges.begin(), drop.edges.end(), std::static_pointer_cast<Edge>(window.prior),
               std::static_pointer_cast<Edge>(std::make_shared<EdgePrior>(weak)));
  return drop;
}

void Compare(const Window& window, double weakness, CsvTable* table) {
  const DropSet drop = DropSetOf(window, weakness);
  const Prior exact = MarginalizeQr<long double>(drop.edges, drop.vertices);
  for (const BackEnd& back_end : kBackEnds) {
    const Prior prior = back_end.marginalize(drop);
    table->Row("simulated", drop.vertices.size() - 2, prior.J.cols(), weakness, back_end.name, prior.J.rows(),
               WorstRelativeError(prior, exact), MedianMicroseconds(back_end, drop));
  }
}

}  // namespace

CsvTable BackEndsTable(int /*trial*/, const std::filesystem::path& data) {
  CsvTable table("window,landmarks,columns,weakness,back_end,rows,worst_error,microseconds");
  for (const char* name : {"vio_S", "vio_M", "vio_L"}) {
    const WindowDump dump = ReadWindowDump(data / "windows" / (std::string(name) + ".txt"));
    const WindowGraph window = BuildWindowGraph(dump);
    const DropSet drop = OldestFrameOf(dump, window);
    for (const BackEnd& back_end : kBackEnds) {
      const Prior prior = back_end.marginalize(drop);
      table.Row(name, drop.vertices.size() - 2, prior.J.cols(), 1.0, back_end.name, prior.J.rows(), std::nan(""),
                MedianMicroseconds(back_end, drop));
    }
  }
  ConsistencyOptions study;
  study.seconds = 6.0;
  study.max_tracks = 60;
  const Recording recording = ConsistencyFlight(study, 0);
  const DrawnStart start = DrawStart(recording.truth.front(), 0);
  const ConsistencyCase c{"vins", "twice", "exact", "none"};
  bool is_first = true;
  const auto watch = [&](Window* window, const std::function<void()>& slide) {
    if (is_first && window->frames.size() == kFrames) {
      is_first = false;
      for (double weakness : {1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7}) Compare(*window, weakness, &table);
    }
    slide();
  };
  Estimator estimator(ConsistencyEstimator(c, recording.calibration),
                      std::make_unique<WrappedPolicy>(MakeVinsPolicy(), watch));
  estimator.StartFrom(start.state, start.J);
  FeedRecording(recording, &estimator, [](const Estimator&, const ImageResult&) {});
  return table;
}

}  // namespace ch5
