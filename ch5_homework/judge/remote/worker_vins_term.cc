/// Stage 6, MarginalizationInfo's functions.

#include "ch5_homework/judge/remote/members.h"
#include "ch5_homework/judge/remote/window_wire.h"
#include "ch5_homework/judge/remote/worker.h"

namespace ch5::homework {
namespace {

struct KeptTerm {
  std::unique_ptr<WireGraph> graph;
  std::unique_ptr<VinsTerm> term;
};

// The term of the judge's handle, with the judge's members.
KeptTerm& ReadTerm(Reader* in) {
  int handle;
  *in >> handle;
  KeptTerm& kept = Kept<KeptTerm>()[handle];
  if (!kept.term) kept.term = Chosen().make_vins_term();
  VinsTerm::Members members = kept.term->Inside();
  *in >> members;
  return kept;
}

void PreMarginalize(Reader* in, Writer* out) {
  KeptTerm& kept = ReadTerm(in);
  GraphNumbers numbers;
  std::vector<std::vector<int>> drop_sets;
  Unpack(in, &numbers, &drop_sets);
  if (kept.graph) {
    kept.graph->Refresh(numbers);
  } else {
    kept.graph = std::make_unique<WireGraph>(numbers);
    for (size_t k = 0; k < drop_sets.size(); ++k) {
      kept.term->AddResidualBlockInfo({kept.graph->AllEdges().at(k), drop_sets[k]});
    }
  }
  kept.term->PreMarginalize();
  *out << kept.graph->Linearised();
  const auto blocks = kept.term->Blocks();
  *out << blocks.size();
  for (const auto& [id, block] : blocks) {
    *out << id << PlaceOf(block.vertex.get(), kept.graph->AllVertices()) << block.x0 << block.idx;
  }
  *out << kept.term->Inside();
}

void ConstructA(Reader* in, Writer* out) {
  const KeptTerm& kept = ReadTerm(in);
  kept.term->ConstructA();
  *out << kept.term->Inside();
}

void SchurComplement(Reader* in, Writer* out) {
  const KeptTerm& kept = ReadTerm(in);
  const VinsTerm::KeptSystem system = kept.term->SchurComplement();
  *out << system.A << system.b;
}

void Factor(Reader* in, Writer* out) {
  const KeptTerm& kept = ReadTerm(in);
  VinsTerm::KeptSystem system;
  Unpack(in, &system.A, &system.b);
  kept.term->Factor(system);
  *out << kept.term->Inside();
}

void GetParameterBlocks(Reader* in, Writer* out) {
  const KeptTerm& kept = ReadTerm(in);
  std::vector<VertexNumbers> now;
  std::vector<std::pair<int, int>> places;  // of the vertices that take over, by the ids of those that they replace
  Unpack(in, &now, &places);
  const VertexList vertices = kept.graph ? kept.graph->AllVertices() : VertexList{};
  if (now.size() != vertices.size()) throw WireError("GetParameterBlocks before PreMarginalize");
  for (size_t k = 0; k < now.size(); ++k) SetVertex(now[k], vertices[k].get());
  std::map<int, std::shared_ptr<Vertex>> shift;
  for (const auto& [id, place] : places) shift[id] = vertices.at(static_cast<size_t>(place));
  *out << NumbersOf(kept.term->GetParameterBlocks(shift), vertices);
}

[[maybe_unused]] const bool added = Handle("PreMarginalize", &PreMarginalize) && Handle("ConstructA", &ConstructA) &&
                                    Handle("MarginalizationInfo::SchurComplement", &SchurComplement) &&
                                    Handle("Factor", &Factor) && Handle("GetParameterBlocks", &GetParameterBlocks);

}  // namespace
}  // namespace ch5::homework
