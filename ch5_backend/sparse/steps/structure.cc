#include "ch5_backend/sparse/steps/structure.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <typeinfo>

namespace ch5 {
namespace {

constexpr int kNone = -1;

Array<int> Numbers(size_t count) {
  Array<int> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0);
  return numbers;
}

// From here on only the dimensions of edges and vertices are used, and the flat arrays of the incidence. A list for each
// landmark is in the ordering's order.

// The edges of each landmark; two more lists hold those between poses, and the constant ones.
Lists GroupEdges(const Ordering& ordering) {
  const Array<int> landmark_of = LandmarkOfEachEdge(ordering);
  const int num_edges = static_cast<int>(ordering.edges.size()), n = static_cast<int>(ordering.landmarks.size());
  return ListByKey(num_edges, n + 2, [&](int e) {
    if (landmark_of[e] != kNone) return landmark_of[e];
    return ordering.incidence.begin[e] < ordering.incidence.begin[e + 1] ? n : n + 1;
  });
}

// The free poses that share an edge with each landmark, by ascending number.
Lists ListPosesOfLandmarks(const Ordering& ordering, const Lists& edges) {
  const Incidence& incidence = ordering.incidence;
  const int num_poses = static_cast<int>(ordering.poses.size());
  Array<int> last_seen_by(ordering.poses.size(), kNone);
  Lists poses(ordering.landmarks.size(), incidence.entries.size());
  for (int l = 0; l < static_cast<int>(ordering.landmarks.size()); ++l) {
    for (int k = edges.begin[l]; k < edges.begin[l + 1]; ++k) {
      for (int i = incidence.begin[edges.items[k]]; i < incidence.begin[edges.items[k] + 1]; ++i) {
        const int number = incidence.entries[i].number;
        if (number >= num_poses || last_seen_by[number] == l) continue;
        last_seen_by[number] = l;
        poses.items.push_back(number);
      }
    }
    std::sort(poses.items.begin() + poses.begin.back(), poses.items.end());
    poses.End();
  }
  return poses;
}

// The landmarks by these lists as words are sorted in a lexicon, equal ones by dimension: a radix sort from the last place
// to the first, which each list joins at its own end (Aho, Hopcroft & Ullman 1974, §3.2).
Array<int> SortLandmarks(const Ordering& ordering, const Lists& seen_by) {
  const auto& landmarks = ordering.landmarks;
  Array<int> order = Numbers(landmarks.size());
  int largest = 0, longest = 0;
  for (const int l : order) {
    largest = std::max(largest, landmarks[l]->LocalDimension());
    longest = std::max(longest, seen_by[l].size());
  }
  KeySort sort;
  sort(order.begin(), order.end(), largest + 1, [&](int l) { return landmarks[l]->LocalDimension(); });
  const auto begin = KeySort()(order.begin(), order.end(), longest + 1, [&](int l) { return seen_by[l].size(); });
  for (int place = longest - 1; place >= 0; --place) {
    sort(order.begin() + begin[place + 1], order.end(), static_cast<int>(ordering.poses.size()),
         [&](int l) { return seen_by.items[seen_by.begin[l] + place]; });
  }
  return order;
}

// With the landmarks in this order.
Numbering NumberVertices(Ordering ordering, const Array<int>& order) {
  Numbering n;
  for (auto* list : {&n.pose_dim, &n.pose_offset}) list->reserve(ordering.poses.size());
  for (auto* list : {&n.landmark_dim, &n.landmark_offset, &n.landmark_block}) list->reserve(order.size());
  n.poses.reserve(ordering.poses.size());
  n.landmarks.reserve(order.size());
  for (const auto& vertex : ordering.poses) {
    n.poses.push_back(vertex.get());
    n.pose_dim.push_back(vertex->LocalDimension());
    n.pose_offset.push_back(vertex->OrderingId());
  }
  for (const int l : order) {
    Vertex* vertex = ordering.landmarks[l].get();
    const int dim = vertex->LocalDimension();
    n.landmarks.push_back(vertex);
    n.landmark_dim.push_back(dim);
    n.landmark_offset.push_back(vertex->OrderingId());
    n.landmark_block.push_back(n.num_H_ll_values);
    n.num_H_ll_values += dim * dim;
  }
  n.ordering = std::move(ordering);
  return n;
}

// Speeds and biases have no part in a landmark's edges, so their sizes do not count.
BlockSizes CommonSizes(const Numbering& vertices, const Array<int>& slot_pose) {
  const auto common = [](const Array<int>& items, const Array<int>& dim) {
    int found = 0;
    for (const int item : items) {
      if (found != 0 && found != dim[item]) return Eigen::Dynamic;
      found = dim[item];
    }
    return found;
  };
  return {common(slot_pose, vertices.pose_dim), common(Numbers(vertices.landmarks.size()), vertices.landmark_dim)};
}

// A slot for each landmark in its new order, and pose that sees it.
Slots FindSlots(const Array<int>& order, const Lists& seen_by, const Numbering& vertices) {
  Slots s;
  for (Array<int>* list : {&s.slot_pose, &s.slot_landmark}) list->reserve(seen_by.items.size());
  s.landmark_slots.reserve(order.size() + 1);
  s.landmark_slots.push_back(0);
  for (int l = 0; l < vertices.NumLandmarks(); ++l) {
    for (const int pose : seen_by[order[l]]) {
      s.slot_pose.push_back(pose);
      s.slot_landmark.push_back(l);
    }
    s.landmark_slots.push_back(static_cast<int>(s.slot_pose.size()));
  }
  s.pose_slots =
      ListByKey(static_cast<int>(s.slot_pose.size()), vertices.NumPoses(), [&](int slot) { return s.slot_pose[slot]; });
  s.sizes = CommonSizes(vertices, s.slot_pose);
  s.num_H_pl_values = s.SlotSize() * static_cast<int>(s.slot_pose.size());
  if (s.sizes.AreFixed()) return s;
  for (size_t slot = 0; slot < s.slot_pose.size(); ++slot) {
    s.slot_block.push_back(s.num_H_pl_values);
    s.num_H_pl_values += vertices.pose_dim[s.slot_pose[slot]] * vertices.landmark_dim[s.slot_landmark[slot]];
  }
  s.slot_block.push_back(s.num_H_pl_values);
  return s;
}

// Each number is written where it stays: a copy of what has just been written piece by piece would have to wait for it.
void ListEdge(int e, int landmark, const Array<int>& slot_of_pose, const Numbering& vertices, EdgeRecords* s) {
  const Incidence& incidence = vertices.ordering.incidence;
  const int num_poses = vertices.NumPoses();
  EdgeRecord& record = s->edges.emplace_back();
  record.edge = vertices.ordering.edges[e].get();
  record.poses_begin = static_cast<int>(s->edge_poses.size());
  record.landmark_position = kNone;
  record.landmark = landmark;
  for (int k = incidence.begin[e]; k < incidence.begin[e + 1]; ++k) {
    const auto& entry = incidence.entries[k];
    if (entry.number >= num_poses) {
      record.landmark_position = entry.position;
      continue;
    }
    EdgePose& pose = s->edge_poses.emplace_back();
    pose.position = entry.position;
    pose.pose = entry.number;
    pose.slot = slot_of_pose[entry.number];
  }
  record.poses_end = static_cast<int>(s->edge_poses.size());
  const auto begin = s->edge_poses.begin() + record.poses_begin, end = s->edge_poses.end();
  if (landmark == kNone) {  // the columns of all its vertices, the fixed ones too
    auto pose = begin;
    const auto& ends = record.edge->Vertices();
    for (int i = 0; i < static_cast<int>(ends.size()); ++i) {
      if (pose != end && pose->position == i) (pose++)->column = record.width;
      record.width += ends[i]->LocalDimension();
    }
  }
  const auto by_number = [](const EdgePose& a, const EdgePose& b) { return a.pose < b.pose; };
  if (!std::is_sorted(begin, end, by_number)) std::sort(begin, end, by_number);
  if (landmark != kNone) {
    for (auto pose = begin; pose != end; ++pose) {
      pose->column = record.width;
      record.width += vertices.pose_dim[pose->pose];
    }
    record.width += vertices.landmark_dim[landmark];
  }
  s->max_width = std::max(s->max_width, record.width);
}

EdgeRecords ListEdges(const Array<int>& order, const Lists& edges, const Numbering& vertices, const Slots& slots) {
  EdgeRecords s;
  const int num_landmarks = vertices.NumLandmarks();
  s.num_landmark_edges = edges.begin[num_landmarks];
  s.num_active_edges = edges.begin[num_landmarks + 1];
  s.max_rows = vertices.ordering.incidence.max_residual_dimension;
  s.edges.reserve(edges.items.size());
  s.edge_poses.reserve(vertices.ordering.incidence.entries.size() - static_cast<size_t>(s.num_landmark_edges));
  Array<int> slot_of_pose(vertices.poses.size(), kNone);
  s.landmark_edges.reserve(order.size() + 1);
  for (int l = 0; l < num_landmarks; ++l) {
    s.landmark_edges.push_back(static_cast<int>(s.edges.size()));
    for (int k = slots.landmark_slots[l]; k < slots.landmark_slots[l + 1]; ++k) slot_of_pose[slots.slot_pose[k]] = k;
    for (const int e : edges[order[l]]) ListEdge(e, l, slot_of_pose, vertices, &s);
  }
  s.landmark_edges.push_back(s.num_landmark_edges);
  s.num_landmark_edge_poses = static_cast<int>(s.edge_poses.size());
  slot_of_pose.assign(vertices.poses.size(), kNone);
  for (size_t k = s.edges.size(); k < edges.items.size(); ++k)
    ListEdge(edges.items[k], kNone, slot_of_pose, vertices, &s);
  return s;
}

// Calls pair(record, i, j) for each two free poses of an edge, and each with itself: the edge's i-th and j-th, i ≥ j.
template <typename Pair>
void ForEachPair(const EdgeRecord& record, const Pair& pair) {
  for (int i = 0; i < record.poses_end - record.poses_begin; ++i) {
    for (int j = 0; j <= i; ++j) pair(record, i, j);
  }
}

// Numbers the types of the landmarks' edges.
void NumberEdgeTypes(EdgeRecords* s) {
  constexpr int kPrefetchDistance = 16;
  Array<const std::type_info*> types;
  for (int e = 0; e < s->num_landmark_edges; ++e) {
    if (e + kPrefetchDistance < s->num_landmark_edges) __builtin_prefetch(s->edges[e + kPrefetchDistance].edge);
    const Edge& edge = *s->edges[e].edge;
    const auto is_it = [&](const std::type_info* type) { return *type == typeid(edge); };
    const auto it = std::find_if(types.begin(), types.end(), is_it);
    s->edges[e].type = static_cast<int16_t>(it - types.begin());
    if (it == types.end()) types.push_back(&typeid(edge));
  }
  s->num_edge_types = static_cast<int>(types.size());
}

// Whether two edges have the same free poses, at the same positions of their vertices.
bool HaveSamePoses(const EdgeRecords& s, const EdgeRecord& a, const EdgeRecord& b) {
  const auto begin = s.edge_poses.begin();
  return a.landmark_position == b.landmark_position &&
         std::equal(begin + a.poses_begin, begin + a.poses_end, begin + b.poses_begin, begin + b.poses_end,
                    [](const EdgePose& p, const EdgePose& q) { return p.pose == q.pose && p.position == q.position; });
}

// The landmarks' edges by their free poses, then by type, where a landmark is a number; equal ones in their order.
void SortBatchEdges(int num_poses, EdgeRecords* s) {
  s->batch_edges = Numbers(static_cast<size_t>(s->num_landmark_edges));
  const auto pose = [&](int e, int i) {
    const EdgeRecord& record = s->edges[e];
    return record.poses_begin + i < record.poses_end ? s->edge_poses[record.poses_begin + i].pose : num_poses;
  };
  KeySort sort;
  if (s->num_edge_types > 1) {
    sort(s->batch_edges.begin(), s->batch_edges.end(), s->num_edge_types, [&](int e) { return s->edges[e].type; });
  }
  int most = 0;
  for (int e = 0; e < s->num_landmark_edges; ++e)
    most = std::max(most, s->edges[e].poses_end - s->edges[e].poses_begin);
  const int poses = num_poses + 1;
  if (most == 2 && poses <= s->num_landmark_edges / poses) {  // few enough to sort by both at once
    const auto pair = [&](int e) { return pose(e, 0) * poses + pose(e, 1); };
    sort(s->batch_edges.begin(), s->batch_edges.end(), poses * poses, pair);
    return;
  }
  for (int i = most - 1; i >= 0; --i) {
    sort(s->batch_edges.begin(), s->batch_edges.end(), poses, [&](int e) { return pose(e, i); });
  }
}

// Where, in the order of the batch and then of the edges between poses, those with the same poses begin; and the end.
Array<int> FindEdgesOfSamePoses(const EdgeRecords& s) {
  Array<int> begins;
  begins.reserve(static_cast<size_t>(s.num_active_edges) + 1);
  for (int k = 0; k < s.num_active_edges; ++k) {
    if (k == 0 || !HaveSamePoses(s, s.edges[s.BatchEdge(k)], s.edges[s.BatchEdge(k - 1)])) begins.push_back(k);
  }
  begins.push_back(s.num_active_edges);
  return begins;
}

// The rows i ≥ j of each column j: the diagonal, and each two free poses of an edge. Of the edges [begins[k], begins[k + 1]) one
// speaks for all.
Lists HessianPattern(int num_poses, const Array<int>& begins, const EdgeRecords& s) {
  const auto pose = [&](const EdgeRecord& record, int i) { return s.edge_poses[record.poses_begin + i].pose; };
  const Lists columns = MakeLists(num_poses, [&](const auto& add) {  // of each row
    for (int j = 0; j < num_poses; ++j) add(j, j);
    for (size_t set = 0; set + 1 < begins.size(); ++set) {
      ForEachPair(s.edges[s.BatchEdge(begins[set])], [&](const EdgeRecord& record, int i, int j) {
        if (i != j) add(pose(record, i), pose(record, j));
      });
    }
  });
  const Lists rows = MakeLists(num_poses, [&](const auto& add) {  // of each column, in ascending order
    for (int i = 0; i < num_poses; ++i) {
      for (const int j : columns[i]) add(j, i);
    }
  });
  Lists pattern(static_cast<size_t>(num_poses), rows.items.size());
  for (int j = 0; j < num_poses; ++j) {
    std::unique_copy(rows[j].begin(), rows[j].end(), std::back_inserter(pattern.items));
    pattern.End();
  }
  return pattern;
}

// H_pp's pattern, and which of its blocks each edge changes. Edges with the same poses share their entries.
PoseBlocks ListHessianBlocks(int num_poses, bool in_runs, EdgeRecords* s) {
  PoseBlocks blocks;
  const Array<int> begins = FindEdgesOfSamePoses(*s);
  blocks.H_pp_pattern = HessianPattern(num_poses, begins, *s);
  const auto pose = [s](const EdgeRecord& record, int i) { return s->edge_poses[record.poses_begin + i].pose; };
  // An edge of one pose changes one block, which all such edges share; but runs are told apart by where theirs begin.
  Array<int> of_one_pose(static_cast<size_t>(num_poses), kNone);
  blocks.edge_blocks.reserve(blocks.H_pp_pattern.items.size() + 2 * begins.size());
  for (size_t set = 0; set + 1 < begins.size(); ++set) {
    const EdgeRecord& first = s->edges[s->BatchEdge(begins[set])];
    const bool shares = first.poses_end == first.poses_begin + 1 && !in_runs;
    int own = kNone;
    int& blocks_begin = shares ? of_one_pose[pose(first, 0)] : own;
    const bool is_new = blocks_begin == kNone;
    if (is_new) blocks_begin = static_cast<int>(blocks.edge_blocks.size());
    for (int k = begins[set]; k < begins[set + 1]; ++k) s->edges[s->BatchEdge(k)].blocks_begin = blocks_begin;
    if (!is_new) continue;
    ForEachPair(first, [&](const EdgeRecord& record, int i, int j) {
      const Lists::View rows = blocks.H_pp_pattern[pose(record, j)];
      const int* row = i == j ? rows.first : std::lower_bound(rows.first, rows.last, pose(record, i));
      blocks.edge_blocks.push_back(static_cast<int>(row - blocks.H_pp_pattern.items.data()));
    });
  }
  return blocks;
}

void CutPoseBatches(EdgeRecords* s, PoseBlocks* blocks) {
  constexpr int kMost = 1 << 16;  // numbers of a batch, unless one edge has more
  int size = kMost;
  for (int e = s->num_landmark_edges; e < s->num_active_edges; ++e) {
    const int numbers = (s->edges[e].width + 1) * (s->edges[e].width + 1);
    if (size + numbers > kMost) {
      blocks->pose_batches.push_back(e);
      size = 0;
    }
    s->edges[e].normal_equations = size;
    size += numbers;
    blocks->num_normal_equation_values = std::max(blocks->num_normal_equation_values, size);
  }
  blocks->pose_batches.push_back(s->num_active_edges);
}

// As many chunks as make the work of one clearly more than that of clearing and adding its sums; the number of threads
// has no say, so that it does not change the sums.
Array<int> CutChunks(const Numbering& vertices, const EdgeRecords& records, const PoseBlocks& blocks) {
  constexpr int kMost = 16, kEdges = 64;
  const int edges = records.num_landmark_edges;
  if (edges == 0) return {};
  int num_H_pp_values = 0;
  for (int j = 0; j < vertices.NumPoses(); ++j) {
    for (const int i : blocks.H_pp_pattern[j]) num_H_pp_values += Stride(vertices.pose_dim[i]) * vertices.pose_dim[j];
  }
  const int chunks =
      std::clamp(static_cast<int>(4.0 * edges / std::max(1, num_H_pp_values)), 1, std::clamp(edges / kEdges, 1, kMost));
  Array<int> begins{0};
  for (int l = 0; l < vertices.NumLandmarks(); ++l) {
    const auto done = static_cast<double>(records.landmark_edges[l]), share = static_cast<double>(edges) / chunks;
    if (done >= share * static_cast<double>(begins.size())) begins.push_back(l);
  }
  begins.push_back(vertices.NumLandmarks());
  return begins;
}

// The batch's edges chunk by chunk, cut into runs.
void CutRuns(EdgeRecords* s, Chunks* chunks) {
  const Array<int>& begins = chunks->chunk_begin;
  const auto chunk_of = [&](int e) {
    return static_cast<int>(std::upper_bound(begins.begin(), begins.end(), s->edges[e].landmark) - begins.begin()) - 1;
  };
  const int num_chunks = chunks->NumChunks();
  Array<int> chunk_edges{0, s->num_landmark_edges};
  if (num_chunks > 1) chunk_edges = KeySort()(s->batch_edges.begin(), s->batch_edges.end(), num_chunks, chunk_of);
  chunks->chunk_runs.push_back(0);
  for (int chunk = 0; chunk < num_chunks; ++chunk) {
    for (int k = chunk_edges[chunk]; k < chunk_edges[chunk + 1]; ++k) {
      const auto like_last = [&] {
        const EdgeRecord &last = s->edges[s->batch_edges[k - 1]], &edge = s->edges[s->batch_edges[k]];
        return last.type == edge.type && last.blocks_begin == edge.blocks_begin &&  // and so have the same poses
               last.landmark_position == edge.landmark_position;
      };
      if (k == chunk_edges[chunk] || !like_last()) chunks->runs.push_back({k, k});
      chunks->runs.back().end = k + 1;
    }
    chunks->chunk_runs.push_back(static_cast<int>(chunks->runs.size()));
  }
}

}  // namespace

bool Structure::OnePoseAnEdge() const {
  return !BatchGoesByRuns() && OneEdgePerSlot() &&
         std::all_of(edges.begin(), edges.begin() + num_landmark_edges,
                     [](const EdgeRecord& record) { return record.poses_end - record.poses_begin <= 1; });
}

Array<int> NumberPosesOfLandmarks(const Structure& s, int begin, int end) {
  Array<int> number(s.poses.size(), kNone);
  for (int slot = s.landmark_slots[begin]; slot < s.landmark_slots[end]; ++slot) number[s.slot_pose[slot]] = 0;
  int next = 0;
  for (int& n : number) n = n == kNone ? kNone : next++;
  return number;
}

Structure BuildStructure(Ordering ordering) {
  const Lists grouped = GroupEdges(ordering);
  const Lists seen_by = ListPosesOfLandmarks(ordering, grouped);
  const Array<int> order = SortLandmarks(ordering, seen_by);
  Numbering vertices = NumberVertices(std::move(ordering), order);
  Slots slots = FindSlots(order, seen_by, vertices);
  EdgeRecords edges = ListEdges(order, grouped, vertices, slots);
  NumberEdgeTypes(&edges);
  if (slots.BatchGoesByRuns()) SortBatchEdges(vertices.NumPoses(), &edges);
  PoseBlocks blocks = ListHessianBlocks(vertices.NumPoses(), slots.BatchGoesByRuns(), &edges);
  CutPoseBatches(&edges, &blocks);
  Chunks chunks;
  chunks.chunk_begin = CutChunks(vertices, edges, blocks);
  if (slots.BatchGoesByRuns()) CutRuns(&edges, &chunks);
  vertices.ordering.incidence = {};
  return {std::move(vertices), std::move(slots), std::move(edges), std::move(blocks), std::move(chunks)};
}

}  // namespace ch5
