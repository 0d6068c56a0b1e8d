/// Stage 6 in the worker, MarginalizationInfo's functions.

#include "ch5_homework/judge/remote/members.h"
#include "ch5_homework/judge/remote/remote.h"
#include "ch5_homework/judge/remote/window_wire.h"

namespace ch5::homework {
namespace {

class RemoteVinsTerm : public VinsTerm {
 public:
  Members Inside() override { return {&A_, &J_, &b_, &r0_, &m_, &n_, &keep_}; }
  std::map<int, Block> Blocks() const override { return blocks_; }

  void AddResidualBlockInfo(const ResidualBlockInfo& info) override {
    edges_.push_back(info.edge);
    drop_sets_.push_back(info.drop_set);
    for (const auto& vertex : info.edge->Vertices()) {
      if (PlaceOf(vertex.get(), vertices_) == kUnknown) vertices_.push_back(vertex);
    }
  }
  void PreMarginalize() override {
    const GraphNumbers numbers = NumbersOf(vertices_, edges_);
    Reader reply = Call("PreMarginalize", Pack(handle_, Inside(), numbers, drop_sets_));
    try {
      std::vector<int> linearised;
      reply >> linearised;
      ShowAsLinearised(numbers, linearised, edges_);
      ReadBlocks(&reply);
      Members members = Inside();
      reply >> members;
      reply.End();
    } catch (const WireError& error) {
      throw WorkerFailure(std::string("GARBAGE in the reply to PreMarginalize: ") + error.what());
    }
  }
  void ConstructA() override {
    Members members = Inside();
    Ask("ConstructA", Pack(handle_, members), &members);
  }
  KeptSystem SchurComplement() const override {
    KeptSystem kept;
    Ask("MarginalizationInfo::SchurComplement", Pack(handle_, InsideNow()), &kept.A, &kept.b);
    return kept;
  }
  void Factor(const KeptSystem& kept) override {
    Members members = Inside();
    Ask("Factor", Pack(handle_, members, kept.A, kept.b), &members);
  }
  Prior GetParameterBlocks(const std::map<int, std::shared_ptr<Vertex>>& shift) const override {
    std::vector<std::pair<int, int>> places;
    for (const auto& [id, vertex] : shift) places.emplace_back(id, PlaceOf(vertex.get(), vertices_));
    PriorNumbers numbers;
    Ask("GetParameterBlocks", Pack(handle_, InsideNow(), NumbersOf(vertices_), places), &numbers);
    try {
      const auto foreign = std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0));
      return MakePrior(numbers, vertices_, foreign);
    } catch (const WireError& error) {
      throw WorkerFailure(std::string("GARBAGE in the reply to GetParameterBlocks: ") + error.what());
    }
  }

 private:
  Members InsideNow() const { return const_cast<RemoteVinsTerm*>(this)->Inside(); }

  // No more of them than there are vertices: the tests rely on it.
  void ReadBlocks(Reader* reply) {
    blocks_.clear();
    size_t count;
    *reply >> count;
    if (count > vertices_.size()) throw WireError("more blocks than vertices");
    for (; count > 0; --count) {
      int id, place;
      Block block;
      Unpack(reply, &id, &place, &block.x0, &block.idx);
      if (place < 0 || place >= static_cast<int>(vertices_.size())) throw WireError("a block of no vertex");
      block.vertex = vertices_[static_cast<size_t>(place)];
      blocks_[id] = block;
    }
  }

  int handle_ = NewHandle();
  MatXX A_, J_;
  VecX b_, r0_;
  int m_ = 0, n_ = 0;
  std::vector<int> keep_;
  std::map<int, Block> blocks_;
  VertexList vertices_;
  EdgeList edges_;
  std::vector<std::vector<int>> drop_sets_;
};

[[maybe_unused]] const bool added = [] {
  Linked()->make_vins_term = [] { return std::unique_ptr<VinsTerm>(std::make_unique<RemoteVinsTerm>()); };
  return true;
}();

}  // namespace
}  // namespace ch5::homework
