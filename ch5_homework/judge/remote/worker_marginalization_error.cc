/// Stage 5.

#include "ch5_homework/judge/remote/members.h"
#include "ch5_homework/judge/remote/worker.h"

namespace ch5::homework {
namespace {

// The term of the judge's handle, with the judge's members.
OkvisTerm* ReadTerm(Reader* in) {
  int handle;
  *in >> handle;
  auto& term = Kept<std::unique_ptr<OkvisTerm>>()[handle];
  if (!term) term = Chosen().make_okvis_term();
  OkvisTerm::Members members = term->Inside();
  *in >> members;
  return term.get();
}

void InsertBlock(Reader* in, Writer* out) {
  OkvisTerm* term = ReadTerm(in);
  int dim;
  bool is_landmark;
  Unpack(in, &dim, &is_landmark);
  const int row = term->InsertBlock(dim, is_landmark);
  *out << row << term->Inside();
}

void SchurComplement(Reader* in, Writer* out) {
  OkvisTerm* term = ReadTerm(in);
  MatXX V, W, U;
  VecX b_b, b_a;
  Unpack(in, &V, &W, &b_b, &U, &b_a);
  term->SchurComplement(V, W, b_b, &U, &b_a);
  *out << U << b_a;
}

void UpdateErrorComputation(Reader* in, Writer* out) {
  OkvisTerm* term = ReadTerm(in);
  term->UpdateErrorComputation();
  *out << term->Inside();
}

void Residual(Reader* in, Writer* out) {
  OkvisTerm* term = ReadTerm(in);
  VecX delta_chi;
  *in >> delta_chi;
  *out << term->Residual(delta_chi);
}

void Marginalize(Reader* in, Writer* out) {
  OkvisTerm* term = ReadTerm(in);
  GraphNumbers numbers;
  std::vector<int> drop, keep;
  Unpack(in, &numbers, &drop, &keep);
  const WireGraph graph(numbers);
  const auto at = [&](const std::vector<int>& places) {
    VertexList vertices;
    for (const int place : places) vertices.push_back(graph.AllVertices().at(static_cast<size_t>(place)));
    return vertices;
  };
  const OkvisTerm::Remainder rest =
      term->Marginalize({graph.AllEdges().begin(), graph.AllEdges().end()}, at(drop), at(keep));
  *out << rest.H << rest.b0 << rest.J;
}

[[maybe_unused]] const bool added = Handle("InsertBlock", &InsertBlock) &&
                                    Handle("MarginalizationError::SchurComplement", &SchurComplement) &&
                                    Handle("UpdateErrorComputation", &UpdateErrorComputation) &&
                                    Handle("Residual", &Residual) && Handle("MarginalizationError", &Marginalize);

}  // namespace
}  // namespace ch5::homework
