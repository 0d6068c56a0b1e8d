#include "ch5_backend/solve/block_structure.h"

#include <algorithm>

namespace ch5 {
namespace {

constexpr int kNone = -1;

// Fills a BlockStructure step by step, in the order in which Build calls them.
class Builder {
 public:
  BlockStructure Build(const Graph& graph, const Selection& selection) {
    s_.ordering = MakeOrdering(graph, selection);
    NumberVertices();
    SortEdges();
    FindSlots();
    LayOutLinearParts();
    FindPatterns();
    ListProducts();
    return std::move(s_);
  }

 private:
  void NumberVertices() {
    block_of_row_.assign(static_cast<size_t>(s_.Size()), kNone);
    for (const auto& vertex : s_.ordering.poses) {
      block_of_row_[vertex->OrderingId()] = static_cast<int>(s_.poses.size());
      s_.poses.push_back(vertex.get());
      s_.pose_dim.push_back(vertex->LocalDimension());
      s_.pose_offset.push_back(vertex->OrderingId());
    }
    for (const auto& vertex : s_.ordering.landmarks) {
      block_of_row_[vertex->OrderingId()] = static_cast<int>(s_.landmarks.size());
      s_.landmarks.push_back(vertex.get());
      s_.landmark_dim.push_back(vertex->LocalDimension());
      s_.landmark_offset.push_back(vertex->OrderingId());
      s_.landmark_block.push_back(s_.num_H_mm_values);
      s_.num_H_mm_values += vertex->LocalDimension() * vertex->LocalDimension();
    }
  }

  static bool IsFree(const Vertex& vertex) { return vertex.OrderingId() >= 0; }
  int Block(const Vertex& vertex) const { return block_of_row_[vertex.OrderingId()]; }

  void SortEdges() {
    const size_t num_landmarks = s_.landmarks.size();
    std::vector<std::vector<EdgeRecord>> groups(num_landmarks + 2);  // landmarks, then poses only, then constant
    for (const auto& edge : s_.ordering.edges) {
      EdgeRecord record{edge.get(), edge->ResidualDimension(), 0, 0, 0, {kNone, kNone, kNone, 0}};
      record.landmark.position = FreeLandmarkOf(*edge);
      const bool is_free = std::any_of(edge->Vertices().begin(), edge->Vertices().end(),
                                       [](const auto& vertex) { return IsFree(*vertex); });
      if (record.landmark.position != kNone) record.landmark.block = Block(*edge->Vertices()[record.landmark.position]);
      const size_t group = record.landmark.position != kNone ? static_cast<size_t>(record.landmark.block)
                                                             : num_landmarks + (is_free ? 0 : 1);
      groups[group].push_back(record);
    }
    s_.edges.reserve(s_.ordering.edges.size());
    for (size_t group = 0; group < groups.size(); ++group) {
      if (group <= num_landmarks) s_.landmark_edges.push_back(static_cast<int>(s_.edges.size()));
      s_.edges.insert(s_.edges.end(), groups[group].begin(), groups[group].end());
    }
    s_.num_landmark_edges = s_.landmark_edges.back();
    s_.num_active_edges = static_cast<int>(s_.edges.size() - groups.back().size());
  }

  void FindSlots() {
    s_.landmark_slots.push_back(0);
    std::vector<int> poses;
    for (int l = 0; l < static_cast<int>(s_.landmarks.size()); ++l) {
      poses.clear();
      for (int e = s_.landmark_edges[l]; e < s_.landmark_edges[l + 1]; ++e) {
        for (const auto& vertex : s_.edges[e].edge->Vertices()) {
          if (IsFree(*vertex) && vertex->GetRole() == Role::kPose) poses.push_back(Block(*vertex));
        }
      }
      std::sort(poses.begin(), poses.end());
      poses.erase(std::unique(poses.begin(), poses.end()), poses.end());
      for (const int pose : poses) {
        s_.slot_pose.push_back(pose);
        s_.slot_landmark.push_back(l);
        s_.slot_block.push_back(s_.num_H_pm_values);
        s_.num_H_pm_values += Stride(s_.pose_dim[pose]) * s_.landmark_dim[l];
      }
      s_.landmark_slots.push_back(static_cast<int>(s_.slot_pose.size()));
    }
    s_.slot_block.push_back(s_.num_H_pm_values);

    s_.pose_slots_begin.assign(s_.poses.size() + 1, 0);
    for (const int pose : s_.slot_pose) ++s_.pose_slots_begin[pose + 1];
    for (size_t i = 0; i < s_.poses.size(); ++i) s_.pose_slots_begin[i + 1] += s_.pose_slots_begin[i];
    std::vector<int> next(s_.pose_slots_begin.begin(), s_.pose_slots_begin.end() - 1);
    s_.pose_slots.resize(s_.slot_pose.size());
    for (int slot = 0; slot < static_cast<int>(s_.slot_pose.size()); ++slot) {
      s_.pose_slots[next[s_.slot_pose[slot]]++] = slot;
    }
  }

  int SlotOf(int landmark, int pose) const {
    const auto begin = s_.slot_pose.begin() + s_.landmark_slots[landmark];
    const auto end = s_.slot_pose.begin() + s_.landmark_slots[landmark + 1];
    return static_cast<int>(std::lower_bound(begin, end, pose) - s_.slot_pose.begin());
  }

  void LayOutLinearParts() {
    int& size = s_.num_linear_values;
    for (int e = 0; e < s_.num_active_edges; ++e) {
      EdgeRecord& record = s_.edges[e];
      record.residual = size;
      size += Stride(record.rows);
      const auto& vertices = record.edge->Vertices();
      record.terms_begin = static_cast<int>(s_.terms.size());
      for (size_t i = 0; i < vertices.size(); ++i) {
        if (!IsFree(*vertices[i])) continue;
        const EdgeTerm term{static_cast<int>(i), Block(*vertices[i]), kNone, size};
        size += record.rows * Stride(vertices[i]->LocalDimension());
        if (term.position == record.landmark.position) {
          record.landmark = term;
        } else {
          s_.terms.push_back(term);
          if (record.landmark.block != kNone) s_.terms.back().slot = SlotOf(record.landmark.block, term.block);
        }
      }
      record.terms_end = static_cast<int>(s_.terms.size());
    }
  }

  // Calls pair(record, a, b) for each two free poses of each edge, and each with itself; block of a ≥ block of b.
  template <typename Pair>
  void ForEachPair(const Pair& pair) const {
    for (int e = 0; e < s_.num_active_edges; ++e) {
      const EdgeRecord& record = s_.edges[e];
      for (int i = record.terms_begin; i < record.terms_end; ++i) {
        for (int j = record.terms_begin; j <= i; ++j) {
          const EdgeTerm &a = s_.terms[i], &b = s_.terms[j];
          a.block >= b.block ? pair(record, a, b) : pair(record, b, a);
        }
      }
    }
  }

  void FindPatterns() {
    const int num_poses = static_cast<int>(s_.poses.size());
    s_.H_pp_pattern.resize(static_cast<size_t>(num_poses));
    for (int j = 0; j < num_poses; ++j) s_.H_pp_pattern[j] = {j};
    ForEachPair([&](const EdgeRecord&, const EdgeTerm& a, const EdgeTerm& b) {
      std::vector<int>& rows = s_.H_pp_pattern[b.block];
      const auto it = std::lower_bound(rows.begin(), rows.end(), a.block);
      if (it == rows.end() || *it != a.block) rows.insert(it, a.block);
    });
  }

  void ListProducts() {
    std::vector<int> column_begin{0};
    for (const auto& rows : s_.H_pp_pattern)
      column_begin.push_back(column_begin.back() + static_cast<int>(rows.size()));
    const auto block = [&](const EdgeTerm& a, const EdgeTerm& b) {
      const std::vector<int>& rows = s_.H_pp_pattern[b.block];
      return column_begin[b.block] + (std::lower_bound(rows.begin(), rows.end(), a.block) - rows.begin());
    };
    s_.products_begin.assign(static_cast<size_t>(column_begin.back()) + 1, 0);
    ForEachPair([&](const EdgeRecord&, const EdgeTerm& a, const EdgeTerm& b) { ++s_.products_begin[block(a, b) + 1]; });
    for (size_t k = 1; k < s_.products_begin.size(); ++k) s_.products_begin[k] += s_.products_begin[k - 1];
    std::vector<int> next(s_.products_begin.begin(), s_.products_begin.end() - 1);
    s_.products.resize(static_cast<size_t>(s_.products_begin.back()));
    ForEachPair([&](const EdgeRecord& record, const EdgeTerm& a, const EdgeTerm& b) {
      s_.products[next[block(a, b)]++] = {record.rows, a.jacobian, b.jacobian, record.residual};
    });
  }

  BlockStructure s_;
  std::vector<int> block_of_row_;
};

}  // namespace

BlockStructure BuildBlockStructure(const Graph& graph, const Selection& selection) {
  return Builder().Build(graph, selection);
}

std::vector<std::vector<int>> SchurPattern(const BlockStructure& s) {
  std::vector<std::vector<int>> pattern = s.H_pp_pattern;
  std::vector<int> seen_by(s.poses.size(), kNone);
  for (int j = 0; j < static_cast<int>(s.poses.size()); ++j) {
    std::vector<int>& rows = pattern[j];
    for (const int i : rows) seen_by[i] = j;
    for (int k = s.pose_slots_begin[j]; k < s.pose_slots_begin[j + 1]; ++k) {
      const int slot = s.pose_slots[k];
      for (int other = slot + 1; other < s.landmark_slots[s.slot_landmark[slot] + 1]; ++other) {
        const int i = s.slot_pose[other];
        if (seen_by[i] == j) continue;
        seen_by[i] = j;
        rows.push_back(i);
      }
    }
    std::sort(rows.begin(), rows.end());
  }
  return pattern;
}

}  // namespace ch5
