#include "ch5_backend/experiments/studies/graph_doubts.h"

#include <algorithm>
#include <array>
#include <map>
#include <sstream>

#include <Eigen/LU>

#include "ch5_backend/types/pose_graph/as_transform.h"

namespace ch5 {
namespace {

struct OtherMeaning {
  const char* words;
  const char* remedy;
  Transform (*read)(const Transform& T_z);
};

template <int kTimes, int kBy>
Transform Scaled(const Transform& T_z) {
  return {T_z.q, T_z.p * (static_cast<double>(kTimes) / kBy)};
}

constexpr size_t kUnits = 4;  // so many of them are of units, the first two of a measurement's
constexpr std::array<OtherMeaning, 7> kMeanings = {{
    {"positions 1000 times what the poses say",
     "are they in millimeters? divide x, y and z by 1000, and multiply W's rows and columns of them by 1000",
     Scaled<1, 1000>},
    {"positions 100 times what the poses say",
     "are they in centimeters? divide x, y and z by 100, and multiply W's rows and columns of them by 100",
     Scaled<1, 100>},
    {"positions a 1000th of what the poses say", "are the poses in millimeters? divide their x, y and z by 1000",
     Scaled<1000, 1>},
    {"positions a 100th of what the poses say", "are the poses in centimeters? divide their x, y and z by 100",
     Scaled<100, 1>},
    {"a measurement that leads from the second pose to the first", "exchange their two ids",
     [](const Transform& T_z) { return Inverse(T_z); }},
    {"a position of the opposite sign", "negate x, y and z", Scaled<-1, 1>},
    {"a rotation of the opposite sign", "negate the angle, or qx, qy and qz",
     [](const Transform& T_z) {
       return Transform{T_z.q.conjugate(), T_z.p};
     }},
}};

// How far the poses are from a measurement.
struct Misfit {
  double chi2;   // rᵀWr of edge_between.h
  double share;  // of the distance that lies between the poses, or of a radian
};

Misfit MisfitOf(Edge* edge) {
  edge->ComputeResidual();
  const VecX r = edge->Residual();
  const bool is_planar = r.size() == 3;
  const double distance = (PoseOf(*edge->Vertices()[0])->p - PoseOf(*edge->Vertices()[1])->p).norm();
  const double off = r.head(is_planar ? 2 : 3).norm(), turn = is_planar ? std::abs(r[2]) : 2.0 * r.tail<3>().norm();
  return {edge->Chi2(), std::max(off / std::max(distance, 1e-9), turn)};
}

// Which meanings of its measurement would fit an edge that does not.
using Fits = std::array<bool, kMeanings.size()>;
constexpr double kNearby = 0.25;
Fits FitsOf(const Edge& edge, const Misfit& as_is) {
  constexpr double kGain = 20.0;
  const Transform measured = *MeasurementOf(edge);
  Fits fits;
  for (size_t k = 0; k < kMeanings.size(); ++k) {
    const auto& ends = edge.Vertices();
    const Misfit other = MisfitOf(MakeBetween(ends[0], ends[1], kMeanings[k].read(measured), edge.Information()).get());
    fits[k] = other.share < std::min(kNearby, 0.25 * as_is.share) && other.chi2 * kGain < as_is.chi2;
  }
  return fits;
}

}  // namespace

std::string DoubtsOfMeasurements(const G2oFile& file) {
  constexpr double kFar = 30.0;               // times its dimension, no edge that fits
  std::vector<std::pair<int, Fits>> misfits;  // by their lines
  std::map<int, Edge*> edges;
  for (const auto& edge : file.graph.Edges()) {
    if (dynamic_cast<const EdgeSE3Between*>(edge.get()) || dynamic_cast<const EdgeSE2Between*>(edge.get()))
      edges[edge->Id()] = edge.get();
  }
  size_t all = 0;
  for (const G2oFile::Line& line : file.lines) {
    const auto found = line.kind == G2oFile::Kind::kEdge ? edges.find(line.index) : edges.end();
    if (found == edges.end()) continue;
    ++all;
    const Edge& edge = *found->second;
    const Misfit as_is = MisfitOf(found->second);
    if (as_is.chi2 >= kFar * edge.ResidualDimension() && as_is.share >= kNearby)
      misfits.push_back({line.number, FitsOf(edge, as_is)});
  }
  // On a straight way the inverse and the opposite sign are alike: what explains most edges goes first, then what explains most
  // of the others.
  std::ostringstream text;
  while (true) {
    std::array<size_t, kMeanings.size()> counts = {};
    for (const auto& [line, fits] : misfits)
      for (size_t k = 0; k < fits.size(); ++k) counts[k] += fits[k];
    const size_t k = std::max_element(counts.begin(), counts.end()) - counts.begin();
    // Among edges that drift spoils, a few are by chance nearer to another direction or sign; a measurement 100 times too long is
    // no chance. That poses lie 100 times too far apart is one where a place is seen again: of their unit most edges tell.
    const size_t fewest = k < kUnits / 2 ? 1 : k < kUnits ? all / 2 : std::max<size_t>(3, all / 200);
    if (counts[k] < fewest) return text.str();
    const auto explained = [&](const auto& misfit) { return misfit.second[k]; };
    text << counts[k] << " of " << all << " edges, the first in line "
         << std::find_if(misfits.begin(), misfits.end(), explained)->first << ", have " << kMeanings[k].words << ": "
         << kMeanings[k].remedy << "\n";
    misfits.erase(std::remove_if(misfits.begin(), misfits.end(), explained), misfits.end());
  }
}

std::string DoubtOfZeroInformation(const G2oFile& file) {
  std::map<int, const Edge*> edges;
  for (const auto& edge : file.graph.Edges())
    if (edge->Information().isZero(0.0)) edges[edge->Id()] = edge.get();
  if (edges.empty()) return "";
  const std::vector<int> part = PartsOf(file.graph);
  std::ostringstream text;
  for (const G2oFile::Line& line : file.lines) {
    const auto found = line.kind == G2oFile::Kind::kEdge ? edges.find(line.index) : edges.end();
    if (found == edges.end()) continue;
    const auto& ends = found->second->Vertices();
    if (text.tellp() == 0) {
      text << "edges whose information is zero, so that they hold nothing: " << edges.size() << ", the first in line "
           << line.number << "\n";
    }
    const bool is_prior = static_cast<size_t>(ends[0]->Id()) >= file.ids.size();
    if (is_prior || part[ends[0]->Id()] == part[ends[1]->Id()]) continue;
    text << "line " << line.number << ": the information is zero, and no other edge connects its two ends: the graph "
         << "falls into parts there\n";
    break;
  }
  return text.str();
}

std::string DoubtOfInformation(const Graph& graph) {
  constexpr double kOff = 100.0, kMost = 300.0, kFewest = 20.0;
  double chi2 = 0.0, chi2_of_inverse = 0.0, degrees = 0.0;
  for (const auto& vertex : graph.Vertices()) degrees -= vertex->IsFixed() ? 0.0 : vertex->LocalDimension();
  for (const auto& edge : graph.Edges()) {
    if (edge->Level() != 0) continue;  // a loop that was given up
    edge->ComputeResidual();
    const VecX r = edge->Residual();
    const MatXX W = edge->Information();
    const Eigen::FullPivLU<MatXX> lu(W);
    if (!lu.isInvertible()) return "";
    chi2 += edge->Chi2();
    chi2_of_inverse += r.dot(lu.solve(r));
    degrees += static_cast<double>(r.size());
  }
  // These poses do not minimize Σ rᵀW⁻¹r, so it is not less than its degrees of freedom, and may be a good deal more.
  if (degrees < kFewest || (chi2 < kOff * degrees && chi2 * kOff > degrees)) return "";
  if (chi2_of_inverse < 0.5 * degrees || chi2_of_inverse > kMost * degrees) return "";
  std::ostringstream text;
  text.precision(3);
  text << "the residuals have rᵀWr of " << chi2 / degrees
       << " for each degree of freedom, where 1 is expected, and rᵀW⁻¹r of " << chi2_of_inverse / degrees
       << ": are the last numbers of the edges covariances? the format has their inverse, information\n";
  return text.str();
}

}  // namespace ch5
