// The reading half of g2o_file.h.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "ch5_backend/files/csv_reader.h"
#include "ch5_backend/files/g2o_file.h"
#include "ch5_backend/files/g2o_tags.h"
#include "ch5_backend/files/tables/text_writer.h"
#include "ch5_backend/files/text_reader.h"
#include "ch5_backend/math/median.h"
#include "ch5_backend/math/psd.h"
#include "ch5_backend/types/pose_graph/edge_between.h"
#include "ch5_backend/types/pose_graph/vertex_se2.h"

namespace ch5 {
namespace {

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
      throw FileError(path_ + ": no pose in this file; one is a line that begins with " + TagOf(VertexKind::kSE3).name +
                      " or " + TagOf(VertexKind::kSE2).name +
                      (file_.unknown.empty() ? "" : ", not with " + std::string(Words(file_.unknown[0].text)[0])));
    }
    SortVertices();
    CountRepeatedEdges();
    file_.unended = text_.UnendedLine();
    // Last, since a file may name a vertex before it defines it.
    for (const Pending& edge : edges_) AddEdge(edge);
    for (const auto& [line, id] : fixed_) file_.graph.Vertices()[IndexOf(id, line, kFix)]->SetFixed();
    CheckOrderOfQuaternions();
    CheckAngles();
    return std::move(file_);
  }

 private:
  // Ids of vertices, then of offsets; numbers of the measurement, then of W.
  struct Pending {
    const G2oEdgeTag* tag;
    const G2oWord* word;  // null if it is g2o's own
    std::array<int64_t, 4> ids;
    std::vector<double> numbers;
    int line;
    size_t place;  // in file_.lines
  };

  void ReadRecord(std::string_view line) {
    const auto words = Words(line);
    if (words.empty()) return;
    const G2oWord* word = FindWord(words[0]);
    const std::string_view tag = word ? word->tag : words[0];
    if (const G2oVertexTag* vertex = FindVertexTag(tag)) return ReadVertex(words, *vertex, word);
    if (const G2oEdgeTag* edge = FindEdgeTag(tag)) return ReadEdge(words, *edge, word);
    const bool is_comment = tag[0] == '#';
    if (tag == kFix) {
      ReadFixed(words);
    } else if (const G2oVertexTag* offset = FindOffsetTag(tag)) {
      ReadOffset(words, *offset);
    } else if (!is_comment && !IsTag(tag)) {
      text_.Fail("expected a tag such as VERTEX_SE3:QUAT, got " + TextReader::Quote(tag));
    } else if (!is_comment) {
      if (!options_.leave_out) {
        text_.Fail(std::string(tag) + ": not known, so what it says would be missing; --leave-out solves the rest");
      }
      file_.unknown.push_back({G2oFile::Kind::kOther, -1, text_.Line(), std::string(line)});
    }
    file_.lines.push_back({G2oFile::Kind::kOther, -1, text_.Line(), std::string(line)});
  }

  int64_t ToId(std::string_view word) const {
    return text_.ToInteger(word, "vertex id", 0, std::numeric_limits<int64_t>::max());
  }

  // The numbers behind `first` words, in g2o's order, `count` of them.
  std::vector<double> ToNumbers(const std::vector<std::string_view>& words, size_t first, size_t count,
                                const G2oWord* word = nullptr) const {
    if (word) count = static_cast<size_t>(word->numbers);
    if (words.size() != first + count) {
      text_.Fail(std::string(words[0]) + " has " + std::to_string(first + count - 1) + " numbers, got " +
                 std::to_string(words.size() - 1));
    }
    std::vector<double> numbers;
    for (size_t k = first; k < words.size(); ++k) numbers.push_back(text_.ToDouble(words[k], "value"));
    if (!word) return numbers;
    try {
      return word->translate(numbers);
    } catch (const std::invalid_argument& error) {
      text_.Fail(std::string(words[0]) + ": " + error.what());
    }
  }

  void CheckQuaternion(const double* xyzw) const {
    if (const std::string why = WhyNotUnit(Qd(xyzw[3], xyzw[0], xyzw[1], xyzw[2])); !why.empty()) text_.Fail(why);
  }

  void ReadVertex(const std::vector<std::string_view>& words, const G2oVertexTag& tag, const G2oWord* word) {
    const std::vector<double> x = ToNumbers(words, 2, tag.numbers, word);
    if (tag.kind == VertexKind::kSE3) CheckQuaternion(&x[3]);
    const int64_t id = ToId(words[1]);
    if (const auto known = index_of_.find(id); known != index_of_.end()) {
      if (kind_of_[known->second] != tag.kind ||
          file_.graph.Vertices()[known->second]->Parameters() != tag.make(x.data())->Parameters()) {
        text_.Fail("vertex id " + std::to_string(id) + " is already that of line " +
                   std::to_string(line_of_[known->second]) + ", whose pose is another");
      }
      if (file_.repeated_vertices++ == 0) file_.first_repeated_vertex = text_.Line();
      return;
    }
    file_.lines.push_back({G2oFile::Kind::kVertex, AddVertex(tag, id, x.data()), text_.Line(), ""});
  }

  int AddVertex(const G2oVertexTag& tag, int64_t id, const double* x) {
    const int index = file_.graph.AddVertex(tag.make(x));
    index_of_.emplace(id, index);
    kind_of_.push_back(tag.kind);
    line_of_.push_back(text_.Line());
    angle_of_.push_back(x && tag.kind == VertexKind::kSE2 ? x[2] : 0.0);
    file_.ids.push_back(id);
    return index;
  }

  void ReadEdge(const std::vector<std::string_view>& words, const G2oEdgeTag& tag, const G2oWord* word) {
    const size_t ends = tag.ends.size(), ids = ends + tag.offsets;
    Pending edge{&tag, word, {}, {}, text_.Line(), file_.lines.size()};
    edge.numbers = ToNumbers(words, 1 + ids, tag.numbers + tag.dim * (tag.dim + 1) / 2, word);
    for (size_t k = 0; k < ids; ++k) edge.ids[k] = ToId(words[1 + k]);
    if (tag.dim == 6) CheckQuaternion(&edge.numbers[3]);
    for (size_t k = 1; k < ends; ++k) {
      if (edge.ids[k] == edge.ids[0] && !(word && word->has_own_ids)) {
        text_.Fail(std::string(words[0]) + ": an edge from vertex " + std::to_string(edge.ids[0]) + " to itself");
      }
    }
    file_.lines.push_back({G2oFile::Kind::kEdge, static_cast<int>(edges_.size()), text_.Line(), ""});
    edges_.push_back(std::move(edge));
  }

  void ReadFixed(const std::vector<std::string_view>& words) {
    if (words.size() < 2) text_.Fail("FIX: which vertex?");
    for (size_t k = 1; k < words.size(); ++k) fixed_.emplace_back(text_.Line(), ToId(words[k]));
  }

  void ReadOffset(const std::vector<std::string_view>& words, const G2oVertexTag& tag) {
    const std::vector<double> x = ToNumbers(words, 2, tag.numbers);
    if (tag.kind == VertexKind::kSE3) CheckQuaternion(&x[3]);
    const int64_t id = ToId(words[1]);
    if (!offsets_.emplace(id, tag.make(x.data())->Parameters()).second) {
      text_.Fail(std::string(words[0]) + ": there are two with the id " + std::to_string(id));
    }
  }

  void CountRepeatedEdges() {
    const auto content = [](const Pending* edge) { return std::tie(edge->tag, edge->ids, edge->numbers, edge->line); };
    const auto is_less = [&](const Pending* a, const Pending* b) { return content(a) < content(b); };
    std::vector<const Pending*> edges;
    for (const Pending& edge : edges_) edges.push_back(&edge);
    std::sort(edges.begin(), edges.end(), is_less);
    for (size_t k = 1; k < edges.size(); ++k) {
      const Pending &edge = *edges[k], &other = *edges[k - 1];
      if (edge.tag != other.tag || edge.ids != other.ids || edge.numbers != other.numbers) continue;
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

  // Angles in degrees are solved too, and lead to a wrong optimum. A pose's angle may count turns, so there its edges' steps
  // tell; an edge's may only if the poses' do. If both are in degrees, they agree read either way: then the steps must speak for
  // radians.
  void CheckAngles() const {
    constexpr double kDegree = M_PI / 180.0, kBetter = 0.5, kShare = 0.01;
    const auto is_beyond = [](double angle) { return std::abs(angle) > 2.0 * M_PI + 1e-3; };
    std::vector<double> steps, steps_in_degrees, turns, turns_in_degrees, both_in_degrees;
    const Pending* first = nullptr;
    for (const Pending& edge : edges_) {
      if (edge.tag->name != std::string_view(kEdgeSE2)) continue;
      const int i = IndexOf(edge.ids[0], edge.line, kEdgeSE2), j = IndexOf(edge.ids[1], edge.line, kEdgeSE2);
      const auto& poses = file_.graph.Vertices();
      const Vec2 step = (poses[j]->Parameters() - poses[i]->Parameters()).head<2>();
      const Vec2 p_z(edge.numbers[0], edge.numbers[1]);
      steps.push_back((Rotation2(angle_of_[i]) * p_z - step).norm());
      steps_in_degrees.push_back((Rotation2(kDegree * angle_of_[i]) * p_z - step).norm());
      if (!is_beyond(edge.numbers[2])) continue;
      if (!first) first = &edge;
      const double turn = angle_of_[j] - angle_of_[i];
      turns.push_back(std::abs(WrapAngle(turn - edge.numbers[2])));
      turns_in_degrees.push_back(std::abs(WrapAngle(turn - kDegree * edge.numbers[2])));
      both_in_degrees.push_back(std::abs(WrapAngle(kDegree * (turn - edge.numbers[2]))));
    }
    const auto are_better = [&](const std::vector<double>& one, const std::vector<double>& other) {
      return file_.has_poses && !one.empty() && Median(one) < kBetter * Median(other);
    };
    const auto pose = std::find_if(angle_of_.begin(), angle_of_.end(), is_beyond);
    const auto refuse = [&](int line, double angle) {
      text_.FailAt(line,
                   "the angle " + std::to_string(angle) +
                       " is beyond a full turn: g2o's angles are in radians; multiply degrees by pi/180, and what "
                       "W has for them by 180/pi if it is per degree, twice on the diagonal");
    };
    if (pose != angle_of_.end() && are_better(steps_in_degrees, steps))
      refuse(line_of_[static_cast<size_t>(pose - angle_of_.begin())], *pose);
    const bool are_many = static_cast<double>(turns.size()) > kShare * static_cast<double>(steps.size());
    const bool speaks_for_radians = are_better(turns, both_in_degrees) || are_better(steps, steps_in_degrees);
    if (first && are_many && !(are_better(turns, turns_in_degrees) && speaks_for_radians))
      refuse(first->line, first->numbers[2]);
  }

  // Ids that follow each other are a path, whatever the order of the lines: g2o writes them as they lie in a hash table.
  void SortVertices() {
    if (std::is_sorted(file_.ids.begin(), file_.ids.end())) return;
    const auto vertices = file_.graph.Vertices();
    const auto [kinds, lines, angles] = std::tuple(kind_of_, line_of_, angle_of_);
    std::vector<int> place(vertices.size());
    file_.graph.Clear();
    for (auto& [id, index] : index_of_) {
      const int before = std::exchange(index, file_.graph.AddVertex(vertices[index]));
      place[before] = index;
      file_.ids[index] = id;
      kind_of_[index] = kinds[before], line_of_[index] = lines[before], angle_of_[index] = angles[before];
    }
    for (G2oFile::Line& line : file_.lines)
      if (line.kind == G2oFile::Kind::kVertex) line.index = place[line.index];
  }

  void AddPosesOfEdges() {
    file_.has_poses = false;
    SeparateIds();
    std::map<int64_t, VertexKind> kinds;  // by id, as the first of its edges has it; AddEdge judges the others
    for (const Pending& edge : edges_) {
      for (size_t k = 0; k < edge.tag->ends.size(); ++k) kinds.emplace(edge.ids[k], edge.tag->ends[k]);
    }
    std::vector<G2oFile::Line> lines;
    for (const auto& [id, kind] : kinds)
      lines.push_back({G2oFile::Kind::kVertex, AddVertex(TagOf(kind), id, nullptr), 0, ""});
    file_.lines.insert(file_.lines.begin(), lines.begin(), lines.end());
    for (Pending& edge : edges_) edge.place += lines.size();
  }

  // Where landmarks are counted apart, as iSAM does, theirs follow on the poses' if both use a number.
  void SeparateIds() {
    std::set<int64_t> poses;
    for (const Pending& edge : edges_) poses.insert(edge.ids[0]);
    const auto last_id = [](Pending* edge) -> int64_t* {
      return edge->word && edge->word->has_own_ids ? &edge->ids[edge->tag->ends.size() - 1] : nullptr;
    };
    const bool shared = std::any_of(edges_.begin(), edges_.end(), [&](Pending& edge) {
      const int64_t* id = last_id(&edge);
      return id && poses.count(*id) > 0;
    });
    for (Pending& edge : edges_) {
      int64_t* id = shared ? last_id(&edge) : nullptr;
      if (id && *id > std::numeric_limits<int64_t>::max() - *poses.rbegin() - 1)
        text_.FailAt(edge.line, std::string(edge.word->name) + ": vertex id too large, got " + std::to_string(*id));
      if (id) *id += *poses.rbegin() + 1;
    }
  }

  [[noreturn]] void Fail(const Pending& edge, const std::string& message) const {
    text_.FailAt(edge.line, std::string(edge.tag->name) + ": " + message);
  }

  int IndexOf(int64_t id, int line, const std::string& tag) const {
    const auto known = index_of_.find(id);
    if (known == index_of_.end()) text_.FailAt(line, tag + ": there is no vertex with the id " + std::to_string(id));
    return known->second;
  }

  // The edge's vertices, a prior's world first.
  std::vector<std::shared_ptr<Vertex>> VerticesOf(const Pending& edge) {
    std::vector<std::shared_ptr<Vertex>> vertices;
    for (const VertexKind kind : edge.tag->world) vertices.push_back(World(kind));
    for (size_t k = 0; k < edge.tag->ends.size(); ++k) {
      const int index = IndexOf(edge.ids[k], edge.line, edge.tag->name);
      if (kind_of_[index] != edge.tag->ends[k]) {
        Fail(edge, "vertex " + std::to_string(edge.ids[k]) + " is of another type");
      }
      vertices.push_back(file_.graph.Vertices()[index]);
    }
    return vertices;
  }

  std::vector<VecX> OffsetsOf(const Pending& edge) const {
    std::vector<VecX> offsets;
    for (int k = 0; k < edge.tag->offsets; ++k) {
      const int64_t id = edge.ids[edge.tag->ends.size() + k];
      const auto known = offsets_.find(id);
      const auto size = edge.tag->ends[0] == VertexKind::kSE2 ? 3 : 7;
      if (known == offsets_.end() || known->second.size() != size) {
        const std::string kind = size == 3 ? "PARAMS_SE2OFFSET" : "PARAMS_SE3OFFSET";
        Fail(edge, "there is no " + kind + " with the id " + std::to_string(id));
      }
      offsets.push_back(known->second);
    }
    return offsets;
  }

  std::shared_ptr<Vertex> World(VertexKind kind) {
    std::shared_ptr<Vertex>& world = world_[kind];
    if (world) return world;
    world = TagOf(kind).make(nullptr);
    world->SetFixed();
    file_.graph.AddVertex(world);
    file_.world.push_back(world);
    return world;
  }

  // As the file's own word has it.
  MatXX InformationOf(const Pending& edge) {
    const MatXX W = FromUpperHalf(&edge.numbers[edge.tag->numbers], edge.tag->dim);
    if (!edge.word || !edge.word->is_root_or_covariance) return W;
    if (ListsHold() == G2oFile::Lists::kRoots) return FromRoot(W, edge.tag->dim == 3 ? edge.numbers[2] : 0.0);
    try {
      return InverseOfCovariance(W, edge.word->name);
    } catch (const std::invalid_argument& error) {
      text_.FailAt(edge.line, error.what());
    }
  }

  // Deviations of a meter and more on every axis of every edge are less likely than covariances below 1.
  G2oFile::Lists ListsHold() {
    if (file_.lists) return *file_.lists;
    const auto has_large = [](const Pending& edge) {
      return edge.word && edge.word->is_root_or_covariance &&
             FromUpperHalf(&edge.numbers[edge.tag->numbers], edge.tag->dim).diagonal().maxCoeff() >= 1.0;
    };
    const bool is_root = std::any_of(edges_.begin(), edges_.end(), has_large);
    file_.lists = is_root ? G2oFile::Lists::kRoots : G2oFile::Lists::kCovariances;
    return *file_.lists;
  }

  void AddEdge(const Pending& edge) {
    const std::shared_ptr<Edge> made = edge.tag->make(VerticesOf(edge), OffsetsOf(edge), edge.numbers.data());
    MatXX W = InformationOf(edge);
    if (!(W.array().abs() <= TextReader::kLargest).all())  // of a root squared or a covariance inverted
      Fail(edge, "the information is absurdly large (beyond 1e15)");
    const std::string fault = WhyNotPositiveSemiDefinite(W);
    if (!fault.empty()) {
      if (!options_.project_information) {
        Fail(edge, "the information matrix " + fault +
                       " (g2o gives its upper half row by row); --project-information takes the nearest one that is");
      }
      W = ProjectToPsd(W);
      ++file_.projected;
    }
    made->SetInformation(W);
    file_.graph.AddEdge(made);
    if (edge.tag->name != std::string_view(kEdgeSE2) && edge.tag->name != std::string_view(kEdgeSE3))
      file_.lines[edge.place].text = RecordOf(edge, W);
  }

  // What is measured does not change, so this is written again.
  static std::string RecordOf(const Pending& edge, const MatXX& W) {
    std::string record = std::string(edge.tag->name) + ' ';
    for (size_t k = 0; k < edge.tag->ends.size() + edge.tag->offsets; ++k) AppendNumber(edge.ids[k], ' ', &record);
    for (int k = 0; k < edge.tag->numbers; ++k) AppendNumber(edge.numbers[k], ' ', &record);
    for (const double w : UpperHalf(W)) AppendNumber(w, ' ', &record);
    record.back() = '\n';
    return record;
  }

  std::string path_;
  G2oOptions options_;
  TextReader text_;
  G2oFile file_;
  std::map<int64_t, int> index_of_;  // by id
  std::vector<VertexKind> kind_of_;  // by index
  std::vector<int> line_of_;         // by index
  std::vector<double> angle_of_;     // by index: as it stands in the file, with all its turns
  std::map<int64_t, VecX> offsets_;  // by id
  std::map<VertexKind, std::shared_ptr<Vertex>> world_;
  std::vector<Pending> edges_;
  std::vector<std::pair<int, int64_t>> fixed_;  // line and id
};

}  // namespace

G2oFile ReadG2o(const std::string& path, const G2oOptions& options) { return Reader(path, options).Read(); }

}  // namespace ch5
