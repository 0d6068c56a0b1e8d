// The writing half of g2o_file.h.

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>

#include "ch5_backend/files/g2o_file.h"
#include "ch5_backend/files/g2o_tags.h"
#include "ch5_backend/files/tables/text_writer.h"
#include "ch5_backend/files/text_reader.h"
#include "ch5_backend/types/pose_graph/edge_between.h"
#include "ch5_backend/types/pose_graph/vertex_se2.h"

namespace ch5 {
namespace {

template <typename Numbers>
void AppendNumbers(const Numbers& numbers, std::string* text) {
  for (Eigen::Index k = 0; k < numbers.size(); ++k) AppendNumber(static_cast<double>(numbers[k]), ' ', text);
}

[[noreturn]] void HasNoRecord(const std::string& type, int id) {
  throw std::invalid_argument("FormatG2o: " + type + " " + std::to_string(id) + " has no record in g2o's format");
}

class Writer {
 public:
  explicit Writer(const G2oFile& file) : file_(file) {
    std::set<int64_t> taken(file.ids.begin(), file.ids.end());
    int64_t free = 0;
    for (const auto& vertex : file.graph.Vertices()) {
      if (std::find(file.world.begin(), file.world.end(), vertex) != file.world.end()) continue;
      while (IsNew(*vertex) && !taken.insert(free).second) ++free;
      const int64_t name = IsNew(*vertex) ? free : file.ids[vertex->Id()];
      names_.emplace(vertex->Id(), name);
      present_.insert(name);
      vertices_[vertex->Id()] = vertex.get();
    }
    for (const auto& edge : file.graph.Edges()) edges_[edge->Id()] = edge.get();
  }

  std::string Text() {
    for (const G2oFile::Line& line : file_.lines) {
      switch (line.kind) {
        case G2oFile::Kind::kVertex: AppendVertex(vertices_.extract(line.index)); break;
        case G2oFile::Kind::kEdge: AppendEdge(edges_.extract(line.index), line.text); break;
        case G2oFile::Kind::kOther: AppendOther(line.text); break;
      }
    }
    while (!vertices_.empty()) AppendVertex(vertices_.extract(vertices_.begin()));
    while (!edges_.empty()) AppendEdge(edges_.extract(edges_.begin()), "");
    return std::move(text_);
  }

 private:
  template <typename T>
  using ById = std::map<int, const T*>;

  bool IsNew(const Vertex& vertex) const { return static_cast<size_t>(vertex.Id()) >= file_.ids.size(); }

  // Nothing, if it has been removed; the same below.
  void AppendVertex(const ById<Vertex>::node_type& vertex) {
    if (vertex.empty()) return;
    const Vertex* pose = vertex.mapped();
    Begin(TagOf(KindOf(*pose)).name);
    AppendNumber(names_.at(pose->Id()), ' ', &text_);
    AppendNumbers(pose->Parameters(), &text_);
    text_.back() = '\n';
    if (!IsNew(*pose) || !pose->IsFixed()) return;
    Begin(kFix);
    AppendNumber(names_.at(pose->Id()), '\n', &text_);
  }

  static VertexKind KindOf(const Vertex& vertex) {
    if (dynamic_cast<const VertexSE2*>(&vertex)) return VertexKind::kSE2;
    if (dynamic_cast<const VertexPose*>(&vertex)) return VertexKind::kSE3;
    if (dynamic_cast<const VertexPointXY*>(&vertex)) return VertexKind::kXY;
    if (dynamic_cast<const VertexPointXYZ*>(&vertex)) return VertexKind::kXYZ;
    HasNoRecord(vertex.TypeInfo(), vertex.Id());
  }

  // @param record  as it was read; empty for the two types whose record is made here
  void AppendEdge(const ById<Edge>::node_type& edge, const std::string& record) {
    if (edge.empty()) return;
    if (!record.empty()) {
      text_ += record;
      return;
    }
    const auto* between = dynamic_cast<const EdgeSE3Between*>(edge.mapped());
    const auto* planar = dynamic_cast<const EdgeSE2Between*>(edge.mapped());
    if (!between && !planar) HasNoRecord(edge.mapped()->TypeInfo(), edge.key());
    Begin(between ? kEdgeSE3 : kEdgeSE2);
    for (const auto& vertex : edge.mapped()->Vertices()) AppendNumber(names_.at(vertex->Id()), ' ', &text_);
    if (between) {
      AppendNumbers(between->p_z(), &text_);
      AppendNumbers(between->q_z().coeffs(), &text_);
    } else {
      AppendNumbers(planar->p_z(), &text_);
      AppendNumber(planar->ThetaZ(), ' ', &text_);
    }
    for (const double w : UpperHalf(edge.mapped()->Information())) AppendNumber(w, ' ', &text_);
    text_.back() = '\n';
  }

  // As it was, but for the poses of a FIX that have been removed.
  void AppendOther(const std::string& line) {
    const auto words = Words(line);
    std::string left;
    size_t removed = 0;
    for (size_t k = 1; k < words.size() && words[0] == kFix; ++k) {
      const bool is_there = present_.count(std::stoll(std::string(words[k]))) > 0;
      if (is_there) left.append(" ").append(words[k]);
      removed += !is_there;
    }
    if (removed == 0) text_ += line + '\n';
    if (removed > 0 && !left.empty()) text_ += kFix + left + '\n';
  }

  void Begin(const char* tag) { (text_ += tag) += ' '; }

  const G2oFile& file_;
  std::map<int, int64_t> names_;  // in the file, by id in the graph
  std::set<int64_t> present_;     // these names
  ById<Vertex> vertices_;         // not yet written
  ById<Edge> edges_;
  std::string text_;
};

}  // namespace

std::string FormatG2o(const G2oFile& file) { return Writer(file).Text(); }

}  // namespace ch5
