#include "ch5_backend/sparse/incremental_smoother.h"

#include <algorithm>
#include <string>
#include <utility>

#include "ch5_backend/graph/ordering.h"
#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/sparse/steps/edge_normal_equations.h"

namespace ch5 {

IncrementalSmoother::IncrementalSmoother(Graph* graph, const IncrementalOptions& options)
    : graph_(graph), options_(options) {
  CheckNotNegative("IncrementalOptions::relinearize_threshold", options.relinearize_threshold);
  CheckNotNegative("IncrementalOptions::wildfire_threshold", options.wildfire_threshold);
}

// ---- Which edges -----------------------------------------------------------------------------------------------

UpdateSummary IncrementalSmoother::Update() { return Update(NewEdges()); }

UpdateSummary IncrementalSmoother::Update(const std::vector<std::shared_ptr<Edge>>& edges) {
  RebuildIfNeeded();
  for (const auto& edge : edges) {
    if (!edge || !graph_->Contains(*edge)) throw GraphError("IncrementalSmoother: an edge is not in the graph");
    if (known_.count(edge.get()) > 0) throw GraphError("IncrementalSmoother: " + edge->Name() + " is given twice");
    Take(edge);
  }
  return Step();
}

// They are mostly the graph's last.
std::vector<std::shared_ptr<Edge>> IncrementalSmoother::NewEdges() {
  RebuildIfNeeded();
  std::vector<std::shared_ptr<Edge>> edges;
  const auto& all = graph_->Edges();
  for (auto edge = all.rbegin(); edge != all.rend() && known_.size() + edges.size() < all.size(); ++edge) {
    if (known_.count(edge->get()) == 0) edges.push_back(*edge);
  }
  std::reverse(edges.begin(), edges.end());
  return edges;
}

void IncrementalSmoother::RebuildIfNeeded() {
  if (!std::exchange(restarts_, false) && graph_->NumRemovedEdges() == removed_) return;
  std::vector<Factor> factors;
  factors.swap(factors_);
  tree_ = BayesTree();
  variables_.clear();
  number_of_.clear();
  known_.clear();
  candidates_.clear();
  stale_.clear();
  removed_ = graph_->NumRemovedEdges();
  for (const Factor& factor : factors) {
    if (graph_->Contains(*factor.edge)) Take(factor.edge);
  }
}

void IncrementalSmoother::Take(const std::shared_ptr<Edge>& edge) {
  std::vector<int> numbers, dims;
  int width = 0;
  for (const auto& vertex : edge->Vertices()) {
    numbers.push_back(vertex->IsFixed() || edge->Level() != 0 ? -1 : NumberOf(vertex));
    dims.push_back(vertex->LocalDimension());
    width += dims.back();
  }
  known_.insert(edge.get());
  const int factor = tree_.AddFactor(std::move(numbers), dims);
  factors_.push_back({edge, width, true});
  if (!tree_.VariablesOf(factor).empty()) stale_.push_back(factor);
}

int IncrementalSmoother::NumberOf(const std::shared_ptr<Vertex>& vertex) {
  const auto [found, is_new] = number_of_.try_emplace(vertex.get(), tree_.NumVariables());
  if (is_new) {
    tree_.AddVariable(vertex->LocalDimension());
    variables_.push_back({vertex, vertex->Parameters()});
  }
  return found->second;
}

// ---- One step --------------------------------------------------------------------------------------------------

UpdateSummary IncrementalSmoother::Step() {
  UpdateSummary summary;
  summary.relinearized = Relinearize();
  summary.linearized = static_cast<int>(stale_.size());
  Linearize();
  const int undetermined = tree_.Update();
  if (undetermined >= 0) {
    const std::string name = variables_[undetermined].vertex->Name();
    GiveUp();
    throw SingularGraphError("IncrementalSmoother: the graph's edges do not determine " + name +
                             "; is a gauge free, with no vertex fixed and no prior?");
  }
  const std::vector<int>& changed = tree_.Solve(options_.wildfire_threshold);
  for (const int variable : changed) WriteEstimate(variable);
  candidates_.insert(candidates_.end(), changed.begin(), changed.end());
  summary.variables = tree_.NumVariables();
  summary.eliminated = tree_.NumEliminated();
  summary.solved = static_cast<int>(changed.size());
  return summary;
}

// θ ← θ ⊞ δ where δ is large.  Kaess (2012), fluid relinearization
int IncrementalSmoother::Relinearize() {
  int moved = 0;
  for (const int variable : candidates_) {
    if (!(tree_.Delta(variable).lpNorm<Eigen::Infinity>() > options_.relinearize_threshold)) continue;
    variables_[variable].theta = variables_[variable].vertex->Parameters();  // the estimate
    tree_.ClearDelta(variable);
    ++moved;
    for (const int factor : tree_.FactorsOf(variable)) {
      if (!std::exchange(factors_[factor].is_stale, true)) stale_.push_back(factor);
    }
  }
  candidates_.clear();
  return moved;
}

// The stale factors, at θ of their variables; their vertices get their estimates back in Update, since all are solved again.
void IncrementalSmoother::Linearize() {
  for (const int f : stale_) {
    for (const int variable : tree_.VariablesOf(f)) {
      variables_[variable].vertex->Parameters() = variables_[variable].theta;
    }
  }
  try {
    for (const int f : stale_) {
      const int width = factors_[f].width;
      double* C = tree_.ChangeFactor(f);
      LinearizeAndMultiplyOut(factors_[f].edge.get(), width, C);
      if (!Eigen::Map<const MatXX>(C, width + 1, width + 1).diagonal().allFinite()) {  // of J or r
        throw SingularGraphError("IncrementalSmoother: " + WhatIsNotFinite({factors_[f].edge}));
      }
      factors_[f].is_stale = false;
    }
  } catch (...) {
    GiveUp();
    throw;
  }
  stale_.clear();
}

void IncrementalSmoother::WriteEstimate(int variable) {
  Vertex& vertex = *variables_[variable].vertex;
  vertex.Parameters() = variables_[variable].theta;
  vertex.Plus(tree_.Delta(variable).data());
}

// The states as they were before this Update, whose δ is still there.
void IncrementalSmoother::GiveUp() {
  for (size_t k = 0; k < variables_.size(); ++k) WriteEstimate(static_cast<int>(k));
  restarts_ = true;
}

MatXX IncrementalSmoother::Covariance(const Vertex& vertex) const {
  const auto found = number_of_.find(&vertex);
  if (restarts_ || found == number_of_.end() || !tree_.HasClique(found->second)) {
    throw GraphError("IncrementalSmoother: " + vertex.Name() + (vertex.IsFixed() ? " is fixed" : " takes no part"));
  }
  return tree_.Covariance(found->second);
}

}  // namespace ch5
