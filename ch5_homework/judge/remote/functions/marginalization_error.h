#pragma once
/// marginalization_error.cc: stage 5.

#include "ch5_homework/judge/remote/remote.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {

template <>
struct ObjectOf<OkvisTerm> {
  static std::unique_ptr<OkvisTerm> Make(Scene*) { return Chosen().make_okvis_term(); }
  static auto Members(OkvisTerm& term) {
    const OkvisTerm::Members m = term.Inside();
    return std::tie(*m.H, *m.J, *m.b0, *m.e0, *m.dense_size);
  }
};

inline auto Fields(OkvisTerm::Remainder& rest, Wire) { return std::tie(rest.H, rest.b0, rest.J); }

namespace marginalization_error {

using Term = Twin<OkvisTerm>;

struct InsertBlock {
  static constexpr char kName[] = "InsertBlock";
  static int Run(Term term, int dim, bool is_landmark) { return term.object->InsertBlock(dim, is_landmark); }
};
struct SchurComplement {
  static constexpr char kName[] = "MarginalizationError::SchurComplement";
  static void Run(Term term, const MatXX& V, const MatXX& W, const VecX& b_b, MatXX* U, VecX* b_a) {
    term.object->SchurComplement(V, W, b_b, U, b_a);
  }
};
struct UpdateErrorComputation {
  static constexpr char kName[] = "UpdateErrorComputation";
  static void Run(Term term) { term.object->UpdateErrorComputation(); }
};
struct Residual {
  static constexpr char kName[] = "Residual";
  static VecX Run(Term term, const VecX& delta_chi) { return term.object->Residual(delta_chi); }
};
/// All of it, on the edges of a scene.
struct Marginalize {
  static constexpr char kName[] = "MarginalizationError";
  static OkvisTerm::Remainder Run(Term term, Scene& scene, const std::vector<int>& edges, const std::vector<int>& drop,
                                  const std::vector<int>& keep) {
    return term.object->Marginalize(At(edges, scene.Edges()), At(drop, scene.Vertices()), At(keep, scene.Vertices()));
  }
};

class RemoteTerm : public OkvisTerm {
 public:
  Members Inside() override { return {&H_, &J_, &b0_, &e0_, &dense_size_}; }
  int InsertBlock(int dim, bool is_landmark) override {
    return Ask<marginalization_error::InsertBlock>(twin_, dim, is_landmark);
  }
  void SchurComplement(const MatXX& V, const MatXX& W, const VecX& b_b, MatXX* U, VecX* b_a) override {
    Ask<marginalization_error::SchurComplement>(twin_, V, W, b_b, U, b_a);
  }
  void UpdateErrorComputation() override { Ask<marginalization_error::UpdateErrorComputation>(twin_); }
  VecX Residual(const VecX& delta_chi) override { return Ask<marginalization_error::Residual>(twin_, delta_chi); }
  Remainder Marginalize(const EdgeList& edges, const VertexList& drop, const VertexList& keep) override {
    Scene& scene = Scene::Of(edges.at(0).get());
    const VertexList vertices = scene.Vertices();
    return Ask<marginalization_error::Marginalize>(twin_, scene, PlacesOf(edges, scene.Edges()),
                                                   PlacesOf(drop, vertices), PlacesOf(keep, vertices));
  }

 private:
  Term twin_{NewHandle(), nullptr, this};
  MatXX H_, J_;
  VecX b0_, e0_;
  int dense_size_ = 0;
};

inline void Remote(Submission* s) {
  s->make_okvis_term = [] { return std::unique_ptr<OkvisTerm>(new RemoteTerm); };
}
inline void Serve() { HandleAll<InsertBlock, SchurComplement, UpdateErrorComputation, Residual, Marginalize>(); }

}  // namespace marginalization_error
}  // namespace ch5::homework
