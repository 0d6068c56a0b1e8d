/// gauge_prior.cc, stage 3: the edges that the function adds, as numbers.

#include <algorithm>

#include "ch5_backend/simulate/mono_ba.h"
#include "ch5_homework/judge/checks/check.h"
#include "ch5_homework/judge/scenes/bundle.h"

namespace ch5::homework {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

bool HasLoss(const Edge& edge) {
  const LossFunction* loss = edge.GetLossFunction();
  return loss != nullptr && dynamic_cast<const TrivialLoss*>(loss) == nullptr;
}

void Append(const VecX& column, MatXX* A) {
  A->conservativeResize(column.size(), A->cols() + 1);
  A->rightCols<1>() = column;
}

// [frame or −1, whether it has a loss, level, r] of each prior, vec(W) of each measurement; NaN where a size does not fit.
void AddEdges(const Submission& student, const Values& given, Answer* answer) {
  const auto scene = MakeScene<StartScene>(given);
  MonoBa& ba = scene->ba;
  student.add_mono_ba_edges(scene->scene, given.Number("pixel_information"), given.Number("prior_weight"), &ba);
  MatXX poses(7, 0), priors(9, 0), measurements(4, 0);
  VecX fixed(ba.poses.size());
  for (size_t i = 0; i < ba.poses.size(); ++i) {
    Append(ba.poses[i]->Parameters(), &poses);
    fixed[static_cast<Eigen::Index>(i)] = ba.poses[i]->IsFixed();
  }
  for (const auto& edge : ba.graph.Edges()) {
    const MatXX W = edge->Information();
    if (edge->TypeInfo() == "EdgeSE3Prior") {
      edge->ComputeResidual();
      const auto frame = std::find(ba.poses.begin(), ba.poses.end(), edge->Vertices()[0]);
      VecX numbers = VecX::Constant(9, kNaN);
      numbers[0] = frame == ba.poses.end() ? -1.0 : static_cast<double>(frame - ba.poses.begin());
      numbers[1] = HasLoss(*edge);
      numbers[2] = edge->Level();
      if (edge->Residual().size() == 6) numbers.tail<6>() = edge->Residual();
      answer->Put(Numbered("W", priors.cols()), W);
      Append(numbers, &priors);
    }
    if (edge->TypeInfo() == "EdgeReprojection") {
      Append(W.size() == 4 ? VecX(Eigen::Map<const VecX>(W.data(), 4)) : VecX::Constant(4, kNaN), &measurements);
    }
  }
  answer->Put({{"poses", poses}, {"fixed", fixed}, {"priors", priors}, {"measurements", measurements}});
}

[[maybe_unused]] const bool added =
    (Linked()->add_mono_ba_edges = &AddMonoBaEdges, AddChecks({{"AddMonoBaEdges", &AddEdges}}));

}  // namespace
}  // namespace ch5::homework
