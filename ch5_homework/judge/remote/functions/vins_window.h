#pragma once
/// vins_window.cc: stage 6.

#include "ch5_homework/judge/remote/remote.h"
#include "ch5_homework/judge/remote/window_numbers.h"
#include "ch5_homework/judge/scenes/factors.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {

// ---- MarginalizationInfo ---------------------------------------------------------------------------------------------

template <>
struct ObjectOf<MarginalizationInfo> {
  static std::unique_ptr<MarginalizationInfo> Make(Scene*) { return Chosen().make_marginalization_info(); }
  static auto Members(MarginalizationInfo& term) { return MembersOf(term); }
};

inline auto Fields(MarginalizationInfo::KeptSystem& kept, Wire) { return std::tie(kept.A, kept.b); }

namespace vins_window {

struct BlockNumbers {
  int id = 0, place = kNull;
  VecX x0;
  int idx = 0;
};
/// What PreMarginalize leaves behind: the blocks, and AgedEdge::Fresh of each edge.
struct Evaluated {
  std::vector<int> fresh;
  std::vector<BlockNumbers> blocks;
};

}  // namespace vins_window

inline auto Fields(vins_window::BlockNumbers& b, Wire) { return std::tie(b.id, b.place, b.x0, b.idx); }
inline auto Fields(vins_window::Evaluated& e, Wire) { return std::tie(e.fresh, e.blocks); }

namespace vins_window {

using Term = RemoteObject<MarginalizationInfo>;

struct PreMarginalize {
  static constexpr char kName[] = "PreMarginalize";
  /// @param factors  the edges that AddResidualBlockInfo has got, and their drop sets
  static Evaluated Run(Term term, Scene& scene, const std::vector<std::pair<int, std::vector<int>>>& factors) {
    const EdgeList edges = scene.Edges();
    (term.object->*(&VinsAccess::factors_)).clear();
    for (const auto& [edge, drop_set] : factors) {
      term.object->AddResidualBlockInfo({At({edge}, edges)[0], drop_set});
    }
    term.object->PreMarginalize();
    Evaluated evaluated;
    for (const auto& edge : edges) {
      const auto* aged = dynamic_cast<const AgedEdge*>(edge.get());
      evaluated.fresh.push_back(aged ? aged->Fresh() : 0);
    }
    for (const auto& [id, block] : BlocksOf(*term.object)) {
      evaluated.blocks.push_back({id, PlaceOf(block.vertex, scene.Vertices()), block.x0, block.idx});
    }
    return evaluated;
  }
};
struct ConstructA {
  static constexpr char kName[] = "ConstructA";
  static void Run(Term term) { term.object->ConstructA(); }
};
struct SchurComplement {
  static constexpr char kName[] = "MarginalizationInfo::SchurComplement";
  static MarginalizationInfo::KeptSystem Run(Term term) { return term.object->SchurComplement(); }
};
struct Factor {
  static constexpr char kName[] = "Factor";
  static void Run(Term term, const MarginalizationInfo::KeptSystem& kept) { term.object->Factor(kept); }
};
struct GetParameterBlocks {
  static constexpr char kName[] = "GetParameterBlocks";
  /// @param shift  the places of the vertices that take over, by the ids of those that they replace
  static PriorNumbers Run(Term term, Scene& scene, const std::vector<std::pair<int, int>>& shift) {
    const VertexList vertices = scene.Vertices();
    std::map<int, std::shared_ptr<Vertex>> taker;
    for (const auto& [id, place] : shift) taker[id] = At({place}, vertices)[0];
    return NumbersOf(term.object->GetParameterBlocks(taker), vertices);
  }
};

// What a student's function names and the scene does not have.
inline std::shared_ptr<Vertex> ForeignVertex() { return std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0)); }

/// A MarginalizationInfo whose five graded functions run in the worker.
class RemoteMarginalizationInfo : public MarginalizationInfo {
 public:
  void PreMarginalize() override {
    Scene& scene = SceneOfFactors();
    const EdgeList edges = scene.Edges();
    std::vector<std::pair<int, std::vector<int>>> factors;
    for (const auto& factor : factors_) factors.emplace_back(PlaceOf(factor.edge, edges), factor.drop_set);
    const auto evaluated = Ask<vins_window::PreMarginalize>(Here(), scene, factors);
    TakeEdges(evaluated.fresh, edges);
    TakeBlocks(evaluated.blocks, scene.Vertices());
  }
  void ConstructA() override { Ask<vins_window::ConstructA>(Here()); }
  KeptSystem SchurComplement() const override { return Ask<vins_window::SchurComplement>(Here()); }
  void Factor(const KeptSystem& kept) override { Ask<vins_window::Factor>(Here(), kept); }
  Prior GetParameterBlocks(const std::map<int, std::shared_ptr<Vertex>>& shift) const override {
    Scene& scene = SceneOfFactors();
    const VertexList vertices = scene.Vertices();
    std::vector<std::pair<int, int>> places;
    for (const auto& [id, vertex] : shift) places.emplace_back(id, PlaceOf(vertex, vertices));
    return MakePrior(Ask<vins_window::GetParameterBlocks>(Here(), scene, places), vertices, ForeignVertex());
  }

 private:
  Term Here() const { return {handle_, nullptr, const_cast<RemoteMarginalizationInfo*>(this)}; }
  Scene& SceneOfFactors() const { return Scene::Of(factors_.at(0).edge.get()); }

  static void TakeEdges(const std::vector<int>& fresh, const EdgeList& edges) {
    if (fresh.size() != edges.size()) throw WireError("not one answer for each edge");
    for (size_t k = 0; k < edges.size(); ++k) {
      if (fresh[k] & AgedEdge::kResidual) edges[k]->ComputeResidual();
      if (fresh[k] & AgedEdge::kJacobians) edges[k]->ComputeJacobians();
    }
  }
  // No more of them than there are vertices: the tests rely on it.
  void TakeBlocks(const std::vector<BlockNumbers>& numbers, const VertexList& vertices) {
    blocks_.clear();
    if (numbers.size() > vertices.size()) throw WireError("more blocks than vertices");
    for (const BlockNumbers& one : numbers) blocks_[one.id] = {At({one.place}, vertices)[0], one.x0, one.idx};
  }

  int handle_ = NewHandle();
};

// ---- the window ------------------------------------------------------------------------------------------------------

using Places = std::pair<std::vector<int>, std::vector<int>>;  // of the edges and of the vertices that are dropped

inline Places PlacesOf(const DropSet& drop, WindowScene& scene) {
  return {homework::PlacesOf(drop.edges, scene.Edges()), homework::PlacesOf(drop.vertices, scene.Vertices())};
}

struct MarginOld {
  static constexpr char kName[] = "DropSetOfMarginOld";
  static Places Run(WindowScene& scene) { return PlacesOf(Chosen().vins_window.margin_old(scene.window), scene); }
};
struct MarginSecondNew {
  static constexpr char kName[] = "DropSetOfMarginSecondNew";
  static Places Run(WindowScene& scene) {
    return PlacesOf(Chosen().vins_window.margin_second_new(scene.window), scene);
  }
};
struct Slide {
  static constexpr char kName[] = "SlideWindow";
  /// @param prior  the window's, if it has another one than its graph: none or one
  static WindowNumbers Run(WindowScene& scene, const std::vector<PriorNumbers>& prior, MarginalizationFlag flag) {
    const VertexList known = scene.Vertices();
    for (const PriorNumbers& one : prior) {
      scene.window.prior = std::make_shared<EdgePrior>(MakePrior(one, known, nullptr));
    }
    Chosen().vins_window.slide(flag, &scene.window);
    return NumbersOf(scene.window, known);
  }
};
struct Detect {
  static constexpr char kName[] = "DetectFailure";
  static Failure Run(WindowScene& scene, const Vec3& last_p) {
    return Chosen().vins_window.detect_failure(scene.window, last_p);
  }
};

inline WindowScene& SceneOf(const Window& window) { return dynamic_cast<WindowScene&>(Scene::Of(&window.graph)); }

template <typename F>
DropSet AskForDropSet(const Window& window) {
  WindowScene& scene = SceneOf(window);
  const auto [edges, vertices] = Ask<F>(scene);
  const EdgeList all_edges = scene.Edges();
  const VertexList all_vertices = scene.Vertices();
  const auto at = [](int place, const auto& list, const auto& foreign) {
    if (place == kNull) return decltype(foreign)(nullptr);
    return static_cast<size_t>(place) < list.size() ? list[static_cast<size_t>(place)] : foreign;
  };
  const std::shared_ptr<Edge> foreign_edge = std::make_shared<ForeignEdge>("Edge");
  const std::shared_ptr<Vertex> foreign_vertex = ForeignVertex();
  DropSet drop;
  for (const int place : edges) drop.edges.push_back(at(place, all_edges, foreign_edge));
  for (const int place : vertices) drop.vertices.push_back(at(place, all_vertices, foreign_vertex));
  return drop;
}

inline void RemoteSlide(MarginalizationFlag flag, Window* window) {
  WindowScene& scene = SceneOf(*window);
  const VertexList known = scene.Vertices();
  std::vector<PriorNumbers> prior;
  if (window->prior && PlaceOf<Edge>(window->prior, scene.Edges()) == kUnknown) {
    prior.push_back(NumbersOf(window->prior->GetPrior(), known));
  }
  const WindowNumbers after = Ask<Slide>(scene, prior, flag);
  try {
    SetInto(after, known, window);
  } catch (const std::invalid_argument& error) {
    throw WireError(error.what());
  }
}

inline void Remote(Submission* s) {
  s->make_marginalization_info = &Make<MarginalizationInfo, RemoteMarginalizationInfo>;
  s->vins_window = {&AskForDropSet<MarginOld>, &AskForDropSet<MarginSecondNew>, &RemoteSlide,
                    [](const Window& window, const Vec3& last_p) { return Ask<Detect>(SceneOf(window), last_p); }};
}
inline void Serve() {
  HandleAll<PreMarginalize, ConstructA, SchurComplement, Factor, GetParameterBlocks>();
  HandleAll<MarginOld, MarginSecondNew, Slide, Detect>();
}

}  // namespace vins_window
}  // namespace ch5::homework
