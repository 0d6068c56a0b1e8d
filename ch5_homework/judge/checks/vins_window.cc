/// vins_window.cc, stage 6: MarginalizationInfo's functions in their order, each on numbers of its own; what leaves a window;
/// and the window after each slide. Edges and vertices are named by their places in the scene.

#include <algorithm>
#include <map>
#include <memory>
#include <tuple>

#include "ch5_backend/marginalize/marginalization_info.h"
#include "ch5_backend/window/vins_window.h"
#include "ch5_homework/judge/checks/check.h"
#include "ch5_homework/judge/scenes/factors.h"
#include "ch5_homework/judge/scenes/windows.h"

namespace ch5::homework {
namespace {

// Protected members.
struct Access : ch5::MarginalizationInfo {
  using MarginalizationInfo::A_;
  using MarginalizationInfo::b_;
  using MarginalizationInfo::blocks_;
  using MarginalizationInfo::factors_;
  using MarginalizationInfo::keep_;
  using MarginalizationInfo::linearized_jacobians_;
  using MarginalizationInfo::linearized_residuals_;
  using MarginalizationInfo::m_;
  using MarginalizationInfo::n_;
};
// A, J, b, r₀, m, n and the kept ids.
auto MembersOf(ch5::MarginalizationInfo& term) {
  return std::tie(term.*(&Access::A_), term.*(&Access::linearized_jacobians_), term.*(&Access::b_),
                  term.*(&Access::linearized_residuals_), term.*(&Access::m_), term.*(&Access::n_),
                  term.*(&Access::keep_));
}
auto& BlocksOf(ch5::MarginalizationInfo& term) { return term.*(&Access::blocks_); }

constexpr double kNull = -1.0, kForeign = -2.0;  // in place of a place

template <typename T>
VecX PlacesOf(const std::vector<std::shared_ptr<T>>& items, const std::vector<std::shared_ptr<T>>& list) {
  VecX places(items.size());
  std::transform(items.begin(), items.end(), places.data(), [&](const auto& item) {
    const auto found = std::find(list.begin(), list.end(), item);
    return item == nullptr ? kNull : found == list.end() ? kForeign : static_cast<double>(found - list.begin());
  });
  return places;
}

// ---- MarginalizationInfo ---------------------------------------------------------------------------------------------

std::unique_ptr<MarginalizationInfo> Evaluated(const Submission& student, const FactorGraph& scene) {
  auto term = student.make_marginalization_info();
  for (const auto& factor : scene.factors) term->AddResidualBlockInfo(factor);
  term->PreMarginalize();
  return term;
}

// [id, place of the vertex, first row] of each block.
void PreMarginalize(const Submission& student, const Values& given, Answer* answer) {
  const auto scene = MakeScene<FactorGraph>(given);
  const auto term = Evaluated(student, *scene);
  for (int again = 1; again < given.Int("times"); ++again) term->PreMarginalize();
  const auto& blocks = BlocksOf(*term);
  MatXX rows(3, blocks.size());
  size_t k = 0;
  for (const auto& [id, block] : blocks) {
    rows.col(static_cast<Eigen::Index>(k)) << id, PlacesOf<Vertex>({block.vertex}, scene->Vertices()), block.idx;
    answer->Put(Numbered("x0", k++), block.x0);
  }
  VecX fresh(scene->factors.size());
  std::transform(scene->factors.begin(), scene->factors.end(), fresh.data(),
                 [](const auto& factor) { return dynamic_cast<const AgedEdge&>(*factor.edge).IsFresh(); });
  const std::vector<int>& keep = std::get<6>(MembersOf(*term));
  answer->Put({{"blocks", rows},
               {"fresh", fresh},
               {"keep", Eigen::Map<const Eigen::VectorXi>(keep.data(), static_cast<int>(keep.size())).cast<double>()},
               {"m", term->m()},
               {"n", term->n()}});
}

void ConstructA(const Submission& student, const Values& given, Answer* answer) {
  const auto scene = MakeScene<FactorGraph>(given);
  const auto term = Evaluated(student, *scene);
  term->ConstructA();
  answer->Put({{"A", term->A()}, {"b", term->b()}});
}

void Eliminate(const Submission& student, const Values& given, Answer* answer) {
  const auto term = student.make_marginalization_info();
  const auto [A, J, b, r0, m, n, keep] = MembersOf(*term);
  A = given["A"];
  b = given.Vector("b");
  m = given.Int("m");
  n = static_cast<int>(A.rows()) - m;
  const MarginalizationInfo::KeptSystem kept = term->SchurComplement();
  answer->Put({{"A", kept.A}, {"b", kept.b}});
}

void Factor(const Submission& student, const Values& given, Answer* answer) {
  const auto term = student.make_marginalization_info();
  const auto [A, J, b, r0, m, n, keep] = MembersOf(*term);
  n = static_cast<int>(given["A"].rows());
  term->Factor({given["A"], given.Vector("b")});
  answer->Put({{"J", J}, {"r0", r0}});
}

// After the states have moved on; the vertices at some places take over from those at others.
void GetParameterBlocks(const Submission& student, const Values& given, Answer* answer) {
  const auto scene = MakeScene<FactorGraph>(given);
  const VertexList vertices = scene->Vertices();
  std::map<int, std::shared_ptr<Vertex>> shift;
  const VecX from = given.Vector("from"), to = given.Vector("to");
  const auto at = [&](double place) { return vertices.at(static_cast<size_t>(place)); };
  for (Eigen::Index k = 0; k < from.size(); ++k) shift[at(from[k])->Id()] = at(to[k]);
  const auto term = Evaluated(student, *scene);
  for (const auto& vertex : scene->free) vertex->Plus(given.Vector("later").data());
  const Prior prior = term->GetParameterBlocks(shift);
  answer->Put("vertices", PlacesOf(prior.vertices, vertices));
  for (size_t k = 0; k < prior.x0.size(); ++k) answer->Put(Numbered("x0", k), prior.x0[k]);
}

void Marginalize(const Submission& student, const Values& given, Answer* answer) {
  const auto scene = MakeScene<FactorGraph>(given);
  const auto term = Evaluated(student, *scene);
  term->Marginalize();
  const Prior prior = term->GetParameterBlocks({});
  answer->Put({{"J", prior.J}, {"r0", prior.r0}});
}

// ---- windows ---------------------------------------------------------------------------------------------------------

DropSet DropSetOf(const Submission& student, MarginalizationFlag flag, const Window& window) {
  const bool old = flag == MarginalizationFlag::kOld;
  return old ? student.vins_window.margin_old(window) : student.vins_window.margin_second_new(window);
}

MarginalizationFlag FlagOf(double number) { return static_cast<MarginalizationFlag>(static_cast<int>(number)); }

void Put(const DropSet& drop, WindowScene* scene, const std::string& number, Answer* answer) {
  answer->Put(
      {{"edges", PlacesOf(drop.edges, scene->Edges())}, {"vertices", PlacesOf(drop.vertices, scene->Vertices())}},
      number);
}

void Drop(const Submission& student, const Values& given, Answer* answer) {
  const auto scene = MakeScene<WindowScene>(given);
  Put(DropSetOf(student, FlagOf(given.Number("flag")), scene->window), scene.get(), "", answer);
}

// [id, whether there is an interval, its seconds, α] of each frame; [track, frame] of what is seen; [track, 1/depth].
void Put(const Window& window, const std::string& number, Answer* answer) {
  MatXX frames(6, window.frames.size()), seen(2, 0), depths(2, 0);
  for (size_t k = 0; k < window.frames.size(); ++k) {
    const Frame& frame = window.frames[k];
    const double seconds = frame.imu ? frame.imu->SumDt() : 0.0;
    const Vec3 alpha = frame.imu ? frame.imu->Alpha() : Vec3::Zero();
    frames.col(static_cast<Eigen::Index>(k)) << frame.id, frame.imu != nullptr, seconds, alpha;
  }
  const auto append = [](double track, double x, MatXX* A) {
    A->conservativeResize(2, A->cols() + 1);
    A->rightCols<1>() << track, x;
  };
  for (const auto& [track, landmark] : window.landmarks) {
    for (const auto& one : landmark.seen) append(track, one.frame, &seen);
    if (landmark.inverse_depth) append(track, landmark.inverse_depth->InverseDepth(), &depths);
  }
  answer->Put({{"frames", frames}, {"seen", seen}, {"depths", depths}}, number);
}

void Slide(const Submission& student, const Values& given, Answer* answer) {
  const auto scene = MakeScene<WindowScene>(given);
  student.vins_window.slide(FlagOf(given.Number("flag")), &scene->window);
  Put(scene->window, "", answer);
}

void Detect(const Submission& student, const Values& given, Answer* answer) {
  const auto scene = MakeScene<WindowScene>(given);
  answer->Put("failure", student.vins_window.detect_failure(scene->window, given.Sized("last_p", 3, 1)));
}

Prior PriorOf(const Submission& student, const DropSet& drop) {
  const auto term = student.make_marginalization_info();
  for (const auto& edge : drop.edges) {
    ResidualBlockInfo info{edge, {}};
    for (size_t i = 0; i < edge->Vertices().size(); ++i) {
      const bool goes =
          std::find(drop.vertices.begin(), drop.vertices.end(), edge->Vertices()[i]) != drop.vertices.end();
      if (goes) info.drop_set.push_back(static_cast<int>(i));
    }
    term->AddResidualBlockInfo(info);
  }
  term->PreMarginalize();
  term->Marginalize();
  return term->GetParameterBlocks({});
}

// All of stage 6 together, slide after slide: what leaves, the prior that takes its place, the window after it.
void SlideAgainAndAgain(const Submission& student, const Values& given, Answer* answer) {
  const auto scene = MakeScene<WindowScene>(given);
  Window& window = scene->window;
  const VecX flags = given.Vector("flags");
  for (Eigen::Index k = 0; k < flags.size(); ++k) {
    const std::string number = Numbered("", k);
    scene->Step();
    const DropSet drop = DropSetOf(student, FlagOf(flags[k]), window);
    Put(drop, scene.get(), number, answer);
    if (!drop.edges.empty()) {
      const Prior prior = PriorOf(student, drop);
      answer->Put({{"prior", PlacesOf(prior.vertices, scene->Vertices())}, {"J", prior.J}, {"r0", prior.r0}}, number);
      window.prior = std::make_shared<EdgePrior>(prior);
    }
    student.vins_window.slide(FlagOf(flags[k]), &window);
    Put(window, number, answer);
  }
}

[[maybe_unused]] const bool added =
    (Linked()->make_marginalization_info = &Make<ch5::MarginalizationInfo, MarginalizationInfo>,
     Linked()->vins_window = {&DropSetOfMarginOld, &DropSetOfMarginSecondNew, &SlideWindow, &DetectFailure},
     AddChecks({{"PreMarginalize", &PreMarginalize},
                {"ConstructA", &ConstructA},
                {"MarginalizationInfo::SchurComplement", &Eliminate},
                {"Factor", &Factor},
                {"GetParameterBlocks", &GetParameterBlocks},
                {"Marginalize", &Marginalize},
                {"DropSet", &Drop},
                {"SlideWindow", &Slide},
                {"DetectFailure", &Detect},
                {"SlideRepeatedly", &SlideAgainAndAgain}}));

}  // namespace
}  // namespace ch5::homework
