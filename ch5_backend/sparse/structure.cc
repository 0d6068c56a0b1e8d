#include "ch5_backend/sparse/structure.h"

#include <algorithm>
#include <numeric>

namespace ch5 {
namespace {

constexpr int kNone = -1;

// Sorts items [begin, end) by key(item) in [0, num_keys), equal ones in their order.
// @return where the items of each key begin, and where the last ones end, counted from `begin`
template <typename Iterator, typename Key>
std::vector<int> SortByKey(Iterator begin, Iterator end, int num_keys, const Key& key) {
  std::vector<int> begins(static_cast<size_t>(num_keys) + 2, 0);
  for (auto item = begin; item != end; ++item) ++begins[key(*item) + 2];
  for (int k = 2; k <= num_keys; ++k) begins[k] += begins[k - 1];
  const std::vector<int> items(begin, end);
  for (const int item : items) begin[begins[key(item) + 1]++] = item;
  begins.pop_back();
  return begins;
}

std::vector<int> Numbers(size_t count) {
  std::vector<int> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0);
  return numbers;
}

// Fills a Structure step by step, in the order in which Build calls them. Edges and vertices are asked no more
// here: all is in the flat numbers of the incidence.
class Builder {
 public:
  Structure Build(Ordering ordering) {
    s_.ordering = std::move(ordering);
    NumberPoses();
    GroupEdges();
    ListPosesOfLandmarks();
    SortLandmarks();
    NumberLandmarks();
    FindSlots();
    ListEdges();
    FindPatterns();
    ListHessianBlocks();
    ListPoseEdgeBlocks();
    CutChunks();
    FindBlockSizes();
    incidence_ = {};
    return std::move(s_);
  }

 private:
  void NumberPoses() {
    for (const auto& vertex : s_.ordering.poses) {
      s_.poses.push_back(vertex.get());
      s_.pose_dim.push_back(vertex->LocalDimension());
      s_.pose_offset.push_back(vertex->OrderingId());
    }
  }

  // By landmark as the ordering numbers them, then those between poses, then the constant ones.
  void GroupEdges() {
    const std::vector<int> landmark_of = LandmarkOfEachEdge(s_.ordering);
    const int num_landmarks = static_cast<int>(s_.ordering.landmarks.size());
    edges_ = Numbers(s_.ordering.edges.size());
    edges_begin_ = SortByKey(edges_.begin(), edges_.end(), num_landmarks + 2, [&](int e) {
      if (landmark_of[e] != kNone) return landmark_of[e];
      return incidence_.begin[e] < incidence_.begin[e + 1] ? num_landmarks : num_landmarks + 1;
    });
    s_.num_landmark_edges = edges_begin_[num_landmarks];
    s_.num_active_edges = edges_begin_[num_landmarks + 1];
  }

  // The free poses that share an edge with each landmark, by ascending block.
  void ListPosesOfLandmarks() {
    std::vector<int> last_seen_by(s_.poses.size(), kNone);
    const int num_poses = static_cast<int>(s_.poses.size());
    for (int l = 0; l < static_cast<int>(s_.ordering.landmarks.size()); ++l) {
      for (int k = edges_begin_[l]; k < edges_begin_[l + 1]; ++k) {
        for (int i = incidence_.begin[edges_[k]]; i < incidence_.begin[edges_[k] + 1]; ++i) {
          const int number = incidence_.entries[i].number;
          if (number >= num_poses || last_seen_by[number] == l) continue;
          last_seen_by[number] = l;
          seen_by_.push_back(number);
        }
      }
      std::sort(seen_by_.begin() + seen_by_begin_.back(), seen_by_.end());
      seen_by_begin_.push_back(static_cast<int>(seen_by_.size()));
    }
  }

  // By these lists as words are sorted in a lexicon, equal ones by dimension: a radix sort from the last place to the
  // first, which each list joins at its own end (Aho, Hopcroft & Ullman 1974, §3.2).
  void SortLandmarks() {
    const auto& landmarks = s_.ordering.landmarks;
    order_ = Numbers(landmarks.size());
    int largest = 0, longest = 0;
    for (const int l : order_) {
      largest = std::max(largest, landmarks[l]->LocalDimension());
      longest = std::max(longest, Length(l));
    }
    SortByKey(order_.begin(), order_.end(), largest + 1, [&](int l) { return landmarks[l]->LocalDimension(); });
    const auto begin = SortByKey(order_.begin(), order_.end(), longest + 1, [&](int l) { return Length(l); });
    for (int place = longest - 1; place >= 0; --place) {
      SortByKey(order_.begin() + begin[place + 1], order_.end(), static_cast<int>(s_.poses.size()),
                [&](int l) { return seen_by_[seen_by_begin_[l] + place]; });
    }
  }
  int Length(int l) const { return seen_by_begin_[l + 1] - seen_by_begin_[l]; }

  void NumberLandmarks() {
    for (const int l : order_) {
      Vertex* vertex = s_.ordering.landmarks[l].get();
      const int dim = vertex->LocalDimension();
      s_.landmarks.push_back(vertex);
      s_.landmark_dim.push_back(dim);
      s_.landmark_offset.push_back(vertex->OrderingId());
      s_.landmark_block.push_back(s_.num_H_ll_values);
      s_.num_H_ll_values += dim * dim;
    }
  }

  void FindSlots() {
    for (std::vector<int>* list : {&s_.slot_pose, &s_.slot_landmark, &s_.slot_block})
      list->reserve(seen_by_.size() + 1);
    s_.landmark_slots.push_back(0);
    for (int l = 0; l < static_cast<int>(order_.size()); ++l) {
      for (int k = seen_by_begin_[order_[l]]; k < seen_by_begin_[order_[l] + 1]; ++k) {
        s_.slot_pose.push_back(seen_by_[k]);
        s_.slot_landmark.push_back(l);
        s_.slot_block.push_back(s_.num_H_pl_values);
        s_.num_H_pl_values += s_.pose_dim[seen_by_[k]] * s_.landmark_dim[l];
      }
      s_.landmark_slots.push_back(static_cast<int>(s_.slot_pose.size()));
    }
    s_.slot_block.push_back(s_.num_H_pl_values);
    s_.pose_slots = Numbers(s_.slot_pose.size());
    s_.pose_slots_begin = SortByKey(s_.pose_slots.begin(), s_.pose_slots.end(), static_cast<int>(s_.poses.size()),
                                    [&](int slot) { return s_.slot_pose[slot]; });
  }

  void ListEdges() {
    s_.edges.reserve(edges_.size());
    s_.edge_poses.reserve(incidence_.entries.size() - static_cast<size_t>(s_.num_landmark_edges));
    std::vector<int> slot_of_pose(s_.poses.size(), kNone);
    for (int l = 0; l < static_cast<int>(order_.size()); ++l) {
      s_.landmark_edges.push_back(static_cast<int>(s_.edges.size()));
      for (int k = s_.landmark_slots[l]; k < s_.landmark_slots[l + 1]; ++k) slot_of_pose[s_.slot_pose[k]] = k;
      for (int k = edges_begin_[order_[l]]; k < edges_begin_[order_[l] + 1]; ++k) {
        ListEdge(edges_[k], s_.landmark_dim[l], slot_of_pose);
      }
    }
    s_.landmark_edges.push_back(s_.num_landmark_edges);
    s_.num_landmark_edge_poses = static_cast<int>(s_.edge_poses.size());
    slot_of_pose.assign(s_.poses.size(), kNone);
    for (size_t k = s_.edges.size(); k < edges_.size(); ++k) ListEdge(edges_[k], 0, slot_of_pose);
    s_.max_rows = incidence_.max_residual_dimension;
  }

  void ListEdge(int e, int landmark_dim, const std::vector<int>& slot_of_pose) {
    const int num_poses = static_cast<int>(s_.poses.size()), begin = static_cast<int>(s_.edge_poses.size());
    EdgeRecord record{s_.ordering.edges[e].get(), begin, begin, kNone, 0, 0, 0};
    for (int k = incidence_.begin[e]; k < incidence_.begin[e + 1]; ++k) {
      const auto [position, number] = incidence_.entries[k];
      if (number < num_poses) {
        s_.edge_poses.push_back({position, number, slot_of_pose[number], 0});
      } else {
        record.landmark_position = position;
      }
    }
    record.poses_end = static_cast<int>(s_.edge_poses.size());
    std::sort(s_.edge_poses.begin() + begin, s_.edge_poses.end(),
              [](const EdgePose& a, const EdgePose& b) { return a.pose < b.pose; });
    for (int t = begin; t < record.poses_end; ++t) {
      s_.edge_poses[t].column = record.width;
      record.width += s_.pose_dim[s_.edge_poses[t].pose];
    }
    record.width += landmark_dim;
    s_.max_width = std::max(s_.max_width, record.width);
    s_.edges.push_back(record);
  }

  // Calls pair(record, a, b) for each two free poses of the edges from `first` on, and each with itself; block of a ≥
  // block of b.
  template <typename Pair>
  void ForEachPair(int first, const Pair& pair) {
    for (int e = first; e < s_.num_active_edges; ++e) {
      EdgeRecord& record = s_.edges[e];
      for (int i = record.poses_begin; i < record.poses_end; ++i) {
        for (int j = record.poses_begin; j <= i; ++j) pair(record, s_.edge_poses[i], s_.edge_poses[j]);
      }
    }
  }

  void FindPatterns() {
    const int num_poses = static_cast<int>(s_.poses.size());
    s_.H_pp_pattern.resize(static_cast<size_t>(num_poses));
    for (int j = 0; j < num_poses; ++j) s_.H_pp_pattern[j] = {j};
    ForEachPair(0, [&](const EdgeRecord&, const EdgePose& a, const EdgePose& b) {
      ++num_edge_blocks_;
      if (a.pose == b.pose) return;
      std::vector<int>& rows = s_.H_pp_pattern[b.pose];
      const auto it = std::lower_bound(rows.begin(), rows.end(), a.pose);
      if (it == rows.end() || *it != a.pose) rows.insert(it, a.pose);
    });
  }

  void ListHessianBlocks() {
    std::vector<int> column_begin{0};
    for (const auto& rows : s_.H_pp_pattern) {
      column_begin.push_back(column_begin.back() + static_cast<int>(rows.size()));
      for (const int i : rows) num_H_pp_values_ += Stride(s_.pose_dim[i]) * s_.pose_dim[rows.front()];
    }
    num_H_pp_blocks_ = column_begin.back();
    s_.edge_blocks.reserve(num_edge_blocks_);
    ForEachPair(0, [&](EdgeRecord& record, const EdgePose& a, const EdgePose& b) {
      if (a.column == 0) record.blocks_begin = static_cast<int>(s_.edge_blocks.size());
      const std::vector<int>& rows = s_.H_pp_pattern[b.pose];
      const auto row = a.pose == b.pose ? 0 : std::lower_bound(rows.begin(), rows.end(), a.pose) - rows.begin();
      s_.edge_blocks.push_back(column_begin[b.pose] + static_cast<int>(row));
    });
  }

  void ListPoseEdgeBlocks() {
    const int first = s_.num_landmark_edges;
    for (int e = first; e < s_.num_active_edges; ++e) {
      s_.edges[e].normal_equations = s_.num_normal_equation_values;
      s_.num_normal_equation_values += (s_.edges[e].width + 1) * (s_.edges[e].width + 1);
    }
    const auto block = [&](const EdgeRecord& record, const EdgePose& a, const EdgePose& b) {
      const auto i = &a - &s_.edge_poses[record.poses_begin], j = &b - &s_.edge_poses[record.poses_begin];
      return s_.edge_blocks[record.blocks_begin + i * (i + 1) / 2 + j];
    };
    s_.pose_edge_blocks_begin.assign(static_cast<size_t>(num_H_pp_blocks_) + 1, 0);
    ForEachPair(first, [&](const EdgeRecord& record, const EdgePose& a, const EdgePose& b) {
      ++s_.pose_edge_blocks_begin[block(record, a, b) + 1];
    });
    for (size_t k = 1; k < s_.pose_edge_blocks_begin.size(); ++k)
      s_.pose_edge_blocks_begin[k] += s_.pose_edge_blocks_begin[k - 1];
    std::vector<int> next(s_.pose_edge_blocks_begin.begin(), s_.pose_edge_blocks_begin.end() - 1);
    s_.pose_edge_blocks.resize(static_cast<size_t>(s_.pose_edge_blocks_begin.back()));
    ForEachPair(first, [&](const EdgeRecord& record, const EdgePose& a, const EdgePose& b) {
      const int stride = record.width + 1, column = record.normal_equations + b.column * stride;
      s_.pose_edge_blocks[next[block(record, a, b)]++] = {column + a.column, stride,
                                                          &a == &b ? column + record.width : kNone};
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

  // Speeds and biases have no part in a landmark's edges, so their sizes do not count.
  void FindBlockSizes() {
    const auto common = [](const std::vector<int>& items, const std::vector<int>& dim) {
      int found = 0;
      for (const int item : items) {
        if (found != 0 && found != dim[item]) return Eigen::Dynamic;
        found = dim[item];
      }
      return found;
    };
    s_.sizes = {common(s_.slot_pose, s_.pose_dim), common(Numbers(s_.landmarks.size()), s_.landmark_dim), false};
  }

  Structure s_;
  Incidence& incidence_ = s_.ordering.incidence;
  std::vector<int> edges_, edges_begin_;  // edges of landmark l, as the ordering numbers them: from edges_begin_[l] on
  std::vector<int> seen_by_, seen_by_begin_{0};  // poses of landmark l, likewise
  std::vector<int> order_;                       // these landmarks in the order of the structure
  int num_H_pp_values_ = 0, num_H_pp_blocks_ = 0;
  size_t num_edge_blocks_ = 0;
};

}  // namespace

Structure BuildStructure(Ordering ordering) { return Builder().Build(std::move(ordering)); }

}  // namespace ch5
