/// Stage 5 in the worker.

#include "ch5_homework/judge/remote/members.h"
#include "ch5_homework/judge/remote/remote.h"

namespace ch5::homework {
namespace {

class RemoteOkvisTerm : public OkvisTerm {
 public:
  Members Inside() override { return {&H_, &J_, &b0_, &e0_, &dense_size_}; }

  int InsertBlock(int dim, bool is_landmark) override {
    int row;
    Members members = Inside();
    Ask("InsertBlock", Pack(handle_, members, dim, is_landmark), &row, &members);
    return row;
  }
  void SchurComplement(const MatXX& V, const MatXX& W, const VecX& b_b, MatXX* U, VecX* b_a) override {
    Ask("MarginalizationError::SchurComplement", Pack(handle_, Inside(), V, W, b_b, *U, *b_a), U, b_a);
  }
  void UpdateErrorComputation() override {
    Members members = Inside();
    Ask("UpdateErrorComputation", Pack(handle_, members), &members);
  }
  VecX Residual(const VecX& delta_chi) override {
    VecX e;
    Ask("Residual", Pack(handle_, Inside(), delta_chi), &e);
    return e;
  }
  Remainder Marginalize(const EdgeList& edges, const VertexList& drop, const VertexList& keep) override {
    VertexList vertices = drop;
    vertices.insert(vertices.end(), keep.begin(), keep.end());
    std::vector<int> dropped, kept;
    for (const auto& vertex : drop) dropped.push_back(PlaceOf(vertex.get(), vertices));
    for (const auto& vertex : keep) kept.push_back(PlaceOf(vertex.get(), vertices));
    Remainder rest;
    Ask("MarginalizationError", Pack(handle_, Inside(), NumbersOf(vertices, edges), dropped, kept), &rest.H, &rest.b0,
        &rest.J);
    return rest;
  }

 private:
  int handle_ = NewHandle();
  MatXX H_, J_;
  VecX b0_, e0_;
  int dense_size_ = 0;
};

[[maybe_unused]] const bool added = [] {
  Linked()->make_okvis_term = [] { return std::unique_ptr<OkvisTerm>(std::make_unique<RemoteOkvisTerm>()); };
  return true;
}();

}  // namespace
}  // namespace ch5::homework
