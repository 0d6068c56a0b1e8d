#include <set>
#include <stdexcept>

#include "ch5_backend/marginalize/marginalization_info.h"

namespace ch5 {

void MarginalizationInfo::AddResidualBlockInfo(const ResidualBlockInfo& info) {
  for (const int position : info.drop_set) {
    if (position < 0 || position >= static_cast<int>(info.edge->Vertices().size())) {
      throw std::invalid_argument("MarginalizationInfo: " + info.edge->TypeInfo() + " has no vertex " +
                                  std::to_string(position));
    }
  }
  factors_.push_back(info);
}

void MarginalizationInfo::PreMarginalize() {
  blocks_.clear();
  keep_.clear();
  std::set<int> dropped;
  for (const auto& [edge, drop_set] : factors_) {
    edge->Linearize();
    for (const int position : drop_set) dropped.insert(edge->Vertices()[static_cast<size_t>(position)]->Id());
    for (const auto& vertex : edge->Vertices()) {
      if (!vertex->IsFixed()) blocks_.insert({vertex->Id(), {vertex, vertex->Parameters(), 0}});
    }
  }
  m_ = n_ = 0;
  for (auto& [id, block] : blocks_) {
    if (dropped.count(id) == 0) continue;
    block.idx = m_;
    m_ += block.vertex->LocalDimension();
  }
  for (auto& [id, block] : blocks_) {
    if (dropped.count(id) > 0) continue;
    block.idx = m_ + n_;
    n_ += block.vertex->LocalDimension();
    keep_.push_back(id);
  }
}

Prior MarginalizationInfo::GetParameterBlocks(const std::map<int, std::shared_ptr<Vertex>>& shift) const {
  Prior prior;
  for (const int id : keep_) {
    const auto moved = shift.find(id);
    const Block& block = blocks_.at(id);
    prior.vertices.push_back(moved == shift.end() ? block.vertex : moved->second);
    prior.x0.push_back(block.x0);
  }
  prior.J = linearized_jacobians_;
  prior.r0 = linearized_residuals_;
  return prior;
}

}  // namespace ch5
