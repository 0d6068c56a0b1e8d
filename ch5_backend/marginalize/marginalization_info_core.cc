#include <stdexcept>

#include "ch5_backend/marginalize/marginalization_info.h"

namespace ch5 {

MarginalizationInfo::~MarginalizationInfo() = default;

void MarginalizationInfo::AddResidualBlockInfo(const ResidualBlockInfo& info) {
  if (!info.edge) throw std::invalid_argument("MarginalizationInfo: the edge is null");
  for (const int position : info.drop_set) {
    if (position < 0 || position >= static_cast<int>(info.edge->Vertices().size())) {
      throw std::invalid_argument("MarginalizationInfo: " + info.edge->TypeInfo() + " has no vertex " +
                                  std::to_string(position));
    }
  }
  for (const auto& vertex : info.edge->Vertices()) {
    if (vertex->Id() >= 0) continue;
    throw std::invalid_argument("MarginalizationInfo: a " + vertex->TypeInfo() + " of " + info.edge->TypeInfo() +
                                " is in no graph, so it has no id to be known by");
  }
  factors_.push_back(info);
}

void MarginalizationInfo::Marginalize() {
  ConstructA();
  Factor(SchurComplement());
}

}  // namespace ch5
