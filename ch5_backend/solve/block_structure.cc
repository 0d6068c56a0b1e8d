#include "ch5_backend/solve/block_structure.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace ch5 {
namespace {

constexpr int kNone = -1;

// Fills a BlockStructure step by step, in the order in which Build calls them.
class Builder {
 public:
  BlockStructure Build(Ordering ordering) {
    s_.ordering = std::move(ordering);
    NumberPoses();
    NumberLandmarks();
    SortEdges();
    FindSlots();
    ListTerms();
    FindPatterns();
    ListPairs();
    ListProducts();
    CutChunks();
    return std::move(s_);
  }

 private:
  void NumberPoses() {
    block_of_row_.assign(static_cast<size_t>(s_.Size()), kNone);
    for (const auto& vertex : s_.ordering.poses) {
      block_of_row_[vertex->OrderingId()] = static_cast<int>(s_.poses.size());
      s_.poses.push_back(vertex.get());
      s_.pose_dim.push_back(vertex->LocalDimension());
      s_.pose_offset.push_back(vertex->OrderingId());
    }
  }

  void NumberLandmarks() {
    seen_by_.resize(s_.ordering.landmarks.size());
    for (size_t k = 0; k < seen_by_.size(); ++k) {
      block_of_row_[s_.ordering.landmarks[k]->OrderingId()] = static_cast<int>(k);
    }
    ListPosesOfLandmarks();
    std::vector<int> order(seen_by_.size());
    std::iota(order.begin(), order.end(), 0);
    const auto key = [&](int k) { return std::tie(seen_by_[k], dimension_[k]); };
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
    std::vector<std::vector<int>> sorted;
    for (const int k : order) {
      Vertex* vertex = s_.ordering.landmarks[k].get();
      const int dim = vertex->LocalDimension();
      block_of_row_[vertex->OrderingId()] = static_cast<int>(s_.landmarks.size());
      s_.landmarks.push_back(vertex);
      s_.landmark_dim.push_back(dim);
      s_.landmark_offset.push_back(vertex->OrderingId());
      s_.landmark_block.push_back(s_.num_H_mm_values);
      s_.num_H_mm_values += dim * dim;
      sorted.push_back(std::move(seen_by_[k]));
    }
    seen_by_ = std::move(sorted);
  }

  // The free poses that share an edge with each landmark, by ascending block.
  void ListPosesOfLandmarks() {
    for (const auto& vertex : s_.ordering.landmarks) dimension_.push_back(vertex->LocalDimension());
    for (const auto& edge : s_.ordering.edges) {
      const int landmark = FreeLandmarkOf(*edge);
      landmark_position_.push_back(landmark);
      if (landmark == kNone) continue;
      std::vector<int>& poses = seen_by_[Block(*edge->Vertices()[landmark])];
      for (const auto& vertex : edge->Vertices()) {
        if (!IsFree(*vertex) || vertex->GetRole() != Role::kPose) continue;
        poses.push_back(Block(*vertex));
        ++num_landmark_terms_;
      }
    }
    for (std::vector<int>& poses : seen_by_) {
      std::sort(poses.begin(), poses.end());
      poses.erase(std::unique(poses.begin(), poses.end()), poses.end());
    }
  }

  static bool IsFree(const Vertex& vertex) { return vertex.OrderingId() >= 0; }
  int Block(const Vertex& vertex) const { return block_of_row_[vertex.OrderingId()]; }

  // By landmark, then those between poses, then the constant ones, each kind in the order of the graph.
  void SortEdges() {
    const size_t num_edges = s_.ordering.edges.size(), num_landmarks = s_.landmarks.size();
    std::vector<int> begin(num_landmarks + 3, 0);
    std::vector<size_t> kind(num_edges);
    for (size_t e = 0; e < num_edges; ++e) {
      const auto& vertices = s_.ordering.edges[e]->Vertices();
      const int landmark = landmark_position_[e];
      const bool is_free = landmark != kNone || std::any_of(vertices.begin(), vertices.end(),
                                                            [](const auto& vertex) { return IsFree(*vertex); });
      kind[e] = landmark != kNone ? static_cast<size_t>(Block(*vertices[landmark])) : num_landmarks + (is_free ? 0 : 1);
      ++begin[kind[e] + 1];
    }
    for (size_t k = 1; k < begin.size(); ++k) begin[k] += begin[k - 1];
    s_.landmark_edges.assign(begin.begin(), begin.begin() + static_cast<ptrdiff_t>(num_landmarks) + 1);
    s_.num_landmark_edges = begin[num_landmarks];
    s_.num_active_edges = begin[num_landmarks + 1];
    s_.edges.resize(num_edges);
    for (size_t e = 0; e < num_edges; ++e) {
      EdgeRecord& record = s_.edges[begin[kind[e]]++];
      record = {s_.ordering.edges[e].get(), 0, 0, 0, 0, {landmark_position_[e], kNone, kNone, 0, 0}, 0, 0};
      record.rows = record.edge->ResidualDimension();
      if (landmark_position_[e] != kNone) record.landmark.block = static_cast<int>(kind[e]);
    }
  }

  void FindSlots() {
    size_t num_slots = 0;
    for (const auto& poses : seen_by_) num_slots += poses.size();
    for (std::vector<int>* list : {&s_.slot_pose, &s_.slot_landmark, &s_.slot_block}) list->reserve(num_slots + 1);
    s_.landmark_slots.push_back(0);
    for (int l = 0; l < static_cast<int>(s_.landmarks.size()); ++l) {
      for (const int pose : seen_by_[l]) {
        s_.slot_pose.push_back(pose);
        s_.slot_landmark.push_back(l);
        s_.slot_block.push_back(s_.num_H_pm_values);
        s_.num_H_pm_values += s_.pose_dim[pose] * s_.landmark_dim[l];
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

  void ListTerms() {
    s_.terms.reserve(num_landmark_terms_);
    for (int e = 0; e < s_.num_active_edges; ++e) {
      EdgeRecord& record = s_.edges[e];
      const auto& vertices = record.edge->Vertices();
      record.terms_begin = static_cast<int>(s_.terms.size());
      for (int i = 0; i < static_cast<int>(vertices.size()); ++i) {
        if (!IsFree(*vertices[i])) continue;
        const EdgeTerm term{i, Block(*vertices[i]), kNone, vertices[i]->LocalDimension(), 0};
        i == record.landmark.position ? void(record.landmark = term) : s_.terms.push_back(term);
      }
      record.terms_end = static_cast<int>(s_.terms.size());
      std::sort(s_.terms.begin() + record.terms_begin, s_.terms.end(),
                [](const EdgeTerm& a, const EdgeTerm& b) { return a.block < b.block; });
      for (int t = record.terms_begin; t < record.terms_end; ++t) {
        EdgeTerm& term = s_.terms[t];
        term.column = record.width;
        record.width += term.dim;
        if (record.landmark.block != kNone) term.slot = SlotOf(record.landmark.block, term.block);
      }
      record.landmark.column = record.width;
      record.width += record.landmark.dim;
      s_.max_width = std::max(s_.max_width, record.width);
      s_.max_rows = std::max(s_.max_rows, record.rows);
    }
  }

  // Calls pair(record, a, b) for each two free poses of the edges from `first` on, and each with itself; block of a ≥
  // block of b.
  template <typename Pair>
  void ForEachPair(int first, const Pair& pair) {
    for (int e = first; e < s_.num_active_edges; ++e) {
      EdgeRecord& record = s_.edges[e];
      for (int i = record.terms_begin; i < record.terms_end; ++i) {
        for (int j = record.terms_begin; j <= i; ++j) pair(record, s_.terms[i], s_.terms[j]);
      }
    }
  }

  void FindPatterns() {
    const int num_poses = static_cast<int>(s_.poses.size());
    s_.H_pp_pattern.resize(static_cast<size_t>(num_poses));
    for (int j = 0; j < num_poses; ++j) s_.H_pp_pattern[j] = {j};
    ForEachPair(0, [&](const EdgeRecord&, const EdgeTerm& a, const EdgeTerm& b) {
      std::vector<int>& rows = s_.H_pp_pattern[b.block];
      const auto it = std::lower_bound(rows.begin(), rows.end(), a.block);
      if (it == rows.end() || *it != a.block) rows.insert(it, a.block);
    });
  }

  void ListPairs() {
    std::vector<int> column_begin{0};
    for (const auto& rows : s_.H_pp_pattern) {
      column_begin.push_back(column_begin.back() + static_cast<int>(rows.size()));
      for (const int i : rows) num_H_pp_values_ += Stride(s_.pose_dim[i]) * s_.pose_dim[rows.front()];
    }
    num_H_pp_blocks_ = column_begin.back();
    size_t num_pairs = 0;
    ForEachPair(0, [&](const EdgeRecord&, const EdgeTerm&, const EdgeTerm&) { ++num_pairs; });
    s_.pairs.reserve(num_pairs);
    ForEachPair(0, [&](EdgeRecord& record, const EdgeTerm& a, const EdgeTerm& b) {
      const std::vector<int>& rows = s_.H_pp_pattern[b.block];
      const auto row = std::lower_bound(rows.begin(), rows.end(), a.block) - rows.begin();
      if (&a == &b && a.column == 0) record.pairs = static_cast<int>(s_.pairs.size());
      s_.pairs.push_back(column_begin[b.block] + static_cast<int>(row));
    });
  }

  void ListProducts() {
    const int first = s_.num_landmark_edges;
    for (int e = first; e < s_.num_active_edges; ++e) {
      s_.edges[e].products = s_.num_product_values;
      s_.num_product_values += (s_.edges[e].width + 1) * (s_.edges[e].width + 1);
    }
    const auto block = [&](const EdgeRecord& record, const EdgeTerm& a, const EdgeTerm& b) {
      const auto i = &a - &s_.terms[record.terms_begin], j = &b - &s_.terms[record.terms_begin];
      return s_.pairs[record.pairs + i * (i + 1) / 2 + j];
    };
    s_.products_begin.assign(static_cast<size_t>(num_H_pp_blocks_) + 1, 0);
    ForEachPair(first, [&](const EdgeRecord& record, const EdgeTerm& a, const EdgeTerm& b) {
      ++s_.products_begin[block(record, a, b) + 1];
    });
    for (size_t k = 1; k < s_.products_begin.size(); ++k) s_.products_begin[k] += s_.products_begin[k - 1];
    std::vector<int> next(s_.products_begin.begin(), s_.products_begin.end() - 1);
    s_.products.resize(static_cast<size_t>(s_.products_begin.back()));
    ForEachPair(first, [&](const EdgeRecord& record, const EdgeTerm& a, const EdgeTerm& b) {
      const int stride = record.width + 1, column = record.products + b.column * stride;
      s_.products[next[block(record, a, b)]++] = {column + a.column, stride, &a == &b ? column + record.width : kNone};
    });
  }

  // As many as make the work of a chunk clearly more than that of clearing and adding its sums; the number of threads
  // has no say, so that it does not change the sums.
  void CutChunks() {
    constexpr int kMost = 16, kEdges = 64;
    const int edges = s_.num_landmark_edges;
    if (edges == 0) return;
    const int chunks = std::clamp(static_cast<int>(4.0 * edges / std::max(1, num_H_pp_values_)), 1,
                                  std::clamp(edges / kEdges, 1, kMost));
    s_.chunk_begin.push_back(0);
    for (int l = 0; l < static_cast<int>(s_.landmarks.size()); ++l) {
      const auto done = static_cast<double>(s_.landmark_edges[l]), share = static_cast<double>(edges) / chunks;
      if (done >= share * static_cast<double>(s_.chunk_begin.size())) s_.chunk_begin.push_back(l);
    }
    s_.chunk_begin.push_back(static_cast<int>(s_.landmarks.size()));
  }

  BlockStructure s_;
  std::vector<int> block_of_row_;
  std::vector<int> landmark_position_;     // in each edge
  std::vector<std::vector<int>> seen_by_;  // the poses of each landmark
  std::vector<int> dimension_;             // of each landmark, in the ordering's order
  int num_H_pp_values_ = 0, num_H_pp_blocks_ = 0;
  size_t num_landmark_terms_ = 0;
};

}  // namespace

BlockStructure BuildBlockStructure(Ordering ordering) { return Builder().Build(std::move(ordering)); }

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
