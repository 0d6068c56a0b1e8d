// Any bytes as a pose graph: it is refused with a FileError, or what is written of it can be read again.
#include "ch5_backend/files/g2o_file.h"
#include "ch5_backend/files/text_reader.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace ch5;
  static const fuzz::MemoryFile file;
  file.Set(fuzz::Text(data, size));
  G2oFile graph;
  try {
    graph = ReadG2o(file.Path(), {false, true});
  } catch (const FileError&) {
    return 0;
  }
  for (const auto& edge : graph.graph.Edges()) {
    edge->ComputeResidual();
    fuzz::Require(edge->Residual().allFinite(), "the residuals of what was read are finite");
  }
  file.Set(FormatG2o(graph));
  const G2oFile again = ReadG2o(file.Path(), {false, true});
  fuzz::Require(again.ids == graph.ids, "a written graph has the same poses");
  fuzz::Require(again.graph.Edges().size() == graph.graph.Edges().size(), "a written graph has the same edges");
  fuzz::Require(again.unknown.size() == graph.unknown.size(), "a written graph keeps what is not understood");
  return 0;
}
