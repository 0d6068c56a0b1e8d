#include "ch5_backend/files/g2o_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <tuple>

#include "ch5_backend/files/csv_reader.h"
#include "ch5_backend/files/tables/text_writer.h"
#include "ch5_backend/files/text_reader.h"
#include "ch5_backend/math/median.h"
#include "ch5_backend/math/psd.h"
#include "ch5_backend/types/pose_graph/edge_between.h"

namespace ch5 {
namespace {

constexpr char kVertexSE2[] = "VERTEX_SE2", kVertexSE3[] = "VERTEX_SE3:QUAT";
constexpr char kEdgeSE2[] = "EDGE_SE2", kEdgeSE3[] = "EDGE_SE3:QUAT", kFix[] = "FIX";
constexpr char kToroVertex[] = "VERTEX2", kToroEdge[] = "EDGE2";

// A letter, then letters, digits and a little punctuation.
bool IsTag(std::string_view word) {
  const auto is_letter = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); };
  for (const char c : word) {
    if (!is_letter(c) && !(c >= '0' && c <= '9') && c != '_' && c != ':' && c != '-') return false;
  }
  return is_letter(word[0]);
}

// The quaternion that the file contains if w comes first in it, though q was read as x y z w.
Qd WithScalarFirst(const Qd& q) { return {q.x(), q.y(), q.z(), q.w()}; }

class Reader {
 public:
  Reader(const std::string& path, const G2oOptions& options) : path_(path), options_(options), text_(path) {}

  G2oFile Read() {
    while (const auto line = text_.ReadLine()) ReadRecord(*line);
    if (file_.ids.empty()) AddPosesOfEdges();
    if (file_.ids.empty()) {
      throw FileError(path_ + ": no pose in this file; one is a line that begins with " + kVertexSE3 + " or " +
                      kVertexSE2 +
                      (file_.unknown.empty() ? "" : ", not with " + std::string(Words(file_.unknown[0].text)[0])));
    }
    CountRepeatedEdges();
    // Last, since a file may name a vertex before it defines it.
    for (const Pending& edge : edges_) AddEdge(edge);
    for (const auto& [line, id] : fixed_) Vertex(id, line, kFix)->SetFixed();
    CheckOrderOfQuaternions();
    return std::move(file_);
  }

 private:
  struct Pending {
    int line;
    bool is_3d;
    int64_t i, j;
    std::vector<double> numbers;
  };

  void ReadRecord(std::string_view line) {
    const auto words = Words(line);
    if (words.empty()) return;
    const std::string_view tag = words[0];
    if (tag == kVertexSE2 || tag == kVertexSE3 || tag == kToroVertex) {
      ReadVertex(words, tag == kVertexSE3);
    } else if (tag == kEdgeSE2 || tag == kEdgeSE3 || tag == kToroEdge) {
      ReadEdge(words, tag == kEdgeSE3);
    } else {
      if (tag == kFix) {
        if (words.size() < 2) text_.Fail("FIX: which vertex?");
        for (size_t k = 1; k < words.size(); ++k) fixed_.emplace_back(text_.Line(), ToId(words[k]));
      } else if (tag[0] != '#' && !IsTag(tag)) {
        text_.Fail("expected a tag such as VERTEX_SE3:QUAT, got " + TextReader::Quote(tag));
      }
      file_.lines.push_back({G2oFile::Kind::kOther, -1, text_.Line(), std::string(line)});
      if (tag != kFix && tag[0] != '#') file_.unknown.push_back(file_.lines.back());
    }
  }

  int64_t ToId(std::string_view word) const {
    return text_.ToInteger(word, "vertex id", 0, std::numeric_limits<int64_t>::max());
  }

  std::vector<double> ToNumbers(const std::vector<std::string_view>& words, size_t first, size_t count) const {
    if (words.size() != first + count) {
      text_.Fail(std::string(words[0]) + " has " + std::to_string(first + count - 1) + " numbers, got " +
                 std::to_string(words.size() - 1));
    }
    std::vector<double> numbers;
    for (size_t k = first; k < words.size(); ++k) numbers.push_back(text_.ToDouble(words[k], "value"));
    return numbers;
  }

  Qd ToQuaternion(const double* xyzw) const {
    const Qd q(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
    if (const std::string why = WhyNotUnit(q); !why.empty()) text_.Fail(why);
    return q.normalized();
  }

  void ReadVertex(const std::vector<std::string_view>& words, bool is_3d) {
    const std::vector<double> x = ToNumbers(words, 2, is_3d ? 7 : 3);
    const int64_t id = ToId(words[1]);
    const int index = static_cast<int>(file_.ids.size());
    const auto [known, is_new] = index_of_.emplace(id, index);
    if (!is_new) {
      text_.Fail("vertex id " + std::to_string(id) + " is already that of line " +
                 std::to_string(line_of_[known->second]));
    }
    if (is_3d) {
      file_.graph.AddVertex(std::make_shared<VertexPose>(ToQuaternion(&x[3]), Vec3(x[0], x[1], x[2])));
    } else {
      file_.graph.AddVertex(std::make_shared<VertexSE2>(Vec2(x[0], x[1]), x[2]));
    }
    file_.ids.push_back(id);
    line_of_.push_back(text_.Line());
    file_.lines.push_back({G2oFile::Kind::kVertex, index, text_.Line(), ""});
  }

  void ReadEdge(const std::vector<std::string_view>& words, bool is_3d) {
    std::vector<double> numbers = ToNumbers(words, 3, is_3d ? 7 + 21 : 3 + 6);
    if (is_3d) ToQuaternion(&numbers[3]);
    if (words[0] == kToroEdge) {  // xx xy yy θθ xθ yθ → xx xy xθ yy yθ θθ
      const std::vector<double> toro = numbers;
      for (const auto& [to, from] : {std::pair(5, 7), {6, 5}, {7, 8}, {8, 6}}) numbers[to] = toro[from];
    }
    const int64_t i = ToId(words[1]), j = ToId(words[2]);
    if (i == j) text_.Fail(std::string(words[0]) + ": an edge from vertex " + std::to_string(i) + " to itself");
    file_.lines.push_back({G2oFile::Kind::kEdge, static_cast<int>(edges_.size()), text_.Line(), ""});
    edges_.push_back({text_.Line(), is_3d, i, j, std::move(numbers)});
  }

  void CountRepeatedEdges() {
    const auto content = [](const Pending* edge) { return std::tie(edge->i, edge->j, edge->numbers, edge->line); };
    const auto is_less = [&](const Pending* a, const Pending* b) { return content(a) < content(b); };
    std::vector<const Pending*> edges;
    for (const Pending& edge : edges_) edges.push_back(&edge);
    std::sort(edges.begin(), edges.end(), is_less);
    for (size_t k = 1; k < edges.size(); ++k) {
      const Pending &edge = *edges[k], &other = *edges[k - 1];
      if (edge.i != other.i || edge.j != other.j || edge.numbers != other.numbers) continue;
      if (file_.repeated++ == 0 || edge.line < file_.first_repeated) file_.first_repeated = edge.line;
    }
  }

  // Numbers written as w x y z are read as other rotations, small ones as half turns, and lead to a wrong optimum. The
  // poses may be a bad guess, or the edges large turns: so whichever agree better tell.
  void CheckOrderOfQuaternions() const {
    constexpr size_t kLeastEdges = 10;
    constexpr double kDegrees = 180.0 / M_PI, kFar = 90.0, kNear = 60.0;  // 18 % and 6 % of all rotations turn by less
    std::vector<double> from_poses, from_poses_w, alone, alone_w;
    for (const auto& edge : file_.graph.Edges()) {
      const auto* between = dynamic_cast<const EdgeSE3Between*>(edge.get());
      if (!between) continue;
      const Qd &z = between->q_z(), &q_i = between->GetVertex<0>().q(), &q_j = between->GetVertex<1>().q();
      const Qd z_w = WithScalarFirst(z);
      from_poses.push_back(z.angularDistance(q_i.conjugate() * q_j));
      from_poses_w.push_back(z_w.angularDistance(WithScalarFirst(q_i).conjugate() * WithScalarFirst(q_j)));
      alone.push_back(z.angularDistance(Qd::Identity()));
      alone_w.push_back(z_w.angularDistance(Qd::Identity()));
    }
    if (alone.size() < kLeastEdges) return;
    const double as_read = kDegrees * std::min(Median(from_poses), Median(alone));
    const double as_w_first = kDegrees * std::min(Median(from_poses_w), Median(alone_w));
    if (as_read < kFar || as_w_first > kNear) return;
    const auto whole = [](double degrees) { return std::to_string(std::lround(degrees)); };
    throw FileError(path_ +
                    ": the quaternions stand as w x y z, but g2o's order is x y z w: read so, edges and poses are " +
                    whole(as_read) + " degrees apart (median), and with w first " + whole(as_w_first));
  }

  void AddPosesOfEdges() {
    file_.has_poses = false;
    std::map<int64_t, bool> is_3d;  // by id, as the first of its edges has it; AddEdge judges the others
    for (const Pending& edge : edges_) {
      is_3d.emplace(edge.i, edge.is_3d);
      is_3d.emplace(edge.j, edge.is_3d);
    }
    std::vector<G2oFile::Line> lines;
    for (const auto& [id, spatial] : is_3d) {
      const int index = static_cast<int>(file_.ids.size());
      index_of_.emplace(id, index);
      if (spatial) {
        file_.graph.AddVertex(std::make_shared<VertexPose>());
      } else {
        file_.graph.AddVertex(std::make_shared<VertexSE2>());
      }
      file_.ids.push_back(id);
      lines.push_back({G2oFile::Kind::kVertex, index, 0, ""});
    }
    file_.lines.insert(file_.lines.begin(), lines.begin(), lines.end());
  }

  std::shared_ptr<ch5::Vertex> Vertex(int64_t id, int line, const char* tag) const {
    const auto known = index_of_.find(id);
    if (known == index_of_.end()) {
      text_.FailAt(line, std::string(tag) + ": there is no pose with the id " + std::to_string(id));
    }
    return file_.graph.Vertices()[known->second];
  }

  template <typename T>
  std::shared_ptr<T> VertexOfType(int64_t id, int line, const char* tag) const {
    auto vertex = std::dynamic_pointer_cast<T>(Vertex(id, line, tag));
    if (!vertex) text_.FailAt(line, std::string(tag) + ": vertex " + std::to_string(id) + " is of another type");
    return vertex;
  }

  void AddEdge(const Pending& edge) {
    const double* z = edge.numbers.data();
    std::shared_ptr<Edge> made;
    if (edge.is_3d) {
      made = std::make_shared<EdgeSE3Between>(VertexOfType<VertexPose>(edge.i, edge.line, kEdgeSE3),
                                              VertexOfType<VertexPose>(edge.j, edge.line, kEdgeSE3),
                                              Qd(z[6], z[3], z[4], z[5]), Vec3(z[0], z[1], z[2]));
    } else {
      made = std::make_shared<EdgeSE2Between>(VertexOfType<VertexSE2>(edge.i, edge.line, kEdgeSE2),
                                              VertexOfType<VertexSE2>(edge.j, edge.line, kEdgeSE2), Vec2(z[0], z[1]),
                                              z[2]);
    }
    const int dim = made->ResidualDimension();
    const double* w = z + (edge.is_3d ? 7 : 3);
    MatXX W(dim, dim);
    for (int i = 0; i < dim; ++i) {
      for (int j = i; j < dim; ++j) W(i, j) = W(j, i) = *w++;
    }
    const std::string fault = WhyNotPositiveSemiDefinite(W);
    if (!fault.empty()) {
      if (!options_.project_information) {
        text_.FailAt(edge.line,
                     made->TypeInfo() + ": the information matrix " + fault +
                         " (g2o gives its upper half row by row); --project-information takes the nearest one that is");
      }
      W = ProjectToPsd(W);
      ++file_.projected;
    }
    made->SetInformation(W);
    file_.graph.AddEdge(std::move(made));
  }

  std::string path_;
  G2oOptions options_;
  TextReader text_;
  G2oFile file_;
  std::map<int64_t, int> index_of_;  // by id
  std::vector<int> line_of_;         // by index
  std::vector<Pending> edges_;
  std::vector<std::pair<int, int64_t>> fixed_;  // line and id
};

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
        case G2oFile::Kind::kEdge: AppendEdge(edges_.extract(line.index)); break;
        case G2oFile::Kind::kOther: AppendOther(line.text); break;
      }
    }
    while (!vertices_.empty()) AppendVertex(vertices_.extract(vertices_.begin()));
    while (!edges_.empty()) AppendEdge(edges_.extract(edges_.begin()));
    return std::move(text_);
  }

 private:
  template <typename T>
  using ById = std::map<int, const T*>;

  bool IsNew(const Vertex& vertex) const { return static_cast<size_t>(vertex.Id()) >= file_.ids.size(); }

  // Nothing, if it has been removed; the same below.
  void AppendVertex(const ById<Vertex>::node_type& vertex) {
    if (vertex.empty()) return;
    const auto* pose = vertex.mapped();
    const bool is_3d = dynamic_cast<const VertexPose*>(pose);
    if (!is_3d && !dynamic_cast<const VertexSE2*>(pose)) HasNoRecord(pose->TypeInfo(), pose->Id());
    Begin(is_3d ? kVertexSE3 : kVertexSE2);
    AppendNumber(names_.at(pose->Id()), ' ', &text_);
    AppendNumbers(pose->Parameters(), &text_);
    text_.back() = '\n';
    if (!IsNew(*pose) || !pose->IsFixed()) return;
    Begin(kFix);
    AppendNumber(names_.at(pose->Id()), '\n', &text_);
  }

  void AppendEdge(const ById<Edge>::node_type& edge) {
    if (edge.empty()) return;
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
    const auto W = edge.mapped()->Information();
    for (int i = 0; i < W.rows(); ++i) AppendNumbers(W.row(i).tail(W.cols() - i), &text_);
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

G2oFile ReadG2o(const std::string& path, const G2oOptions& options) { return Reader(path, options).Read(); }

std::string FormatG2o(const G2oFile& file) { return Writer(file).Text(); }

}  // namespace ch5
