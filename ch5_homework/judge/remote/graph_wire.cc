#include "ch5_homework/judge/remote/graph_wire.h"

#include <algorithm>
#include <cmath>

#include "ch5_backend/types/vertices.h"

namespace ch5::homework {

static Writer& operator<<(Writer& out, const Linearisation& numbers) { return out << numbers.r << numbers.J; }
static Reader& operator>>(Reader& in, Linearisation& numbers) { return in >> numbers.r >> numbers.J; }

static Writer& operator<<(Writer& out, const EdgeNumbers& edge) {
  return out << edge.type << edge.id << edge.level << edge.vertices << edge.W << edge.cauchy << edge.before
             << edge.after;
}
static Reader& operator>>(Reader& in, EdgeNumbers& edge) {
  return in >> edge.type >> edge.id >> edge.level >> edge.vertices >> edge.W >> edge.cauchy >> edge.before >>
         edge.after;
}

namespace {

double ScaleOf(const LossFunction* loss) {
  if (loss == nullptr || dynamic_cast<const TrivialLoss*>(loss) != nullptr) return 0.0;
  // A student's own choice: no check asks more than that there is one.
  if (dynamic_cast<const CauchyLoss*>(loss) == nullptr) return 1.0;
  const double slope = loss->Evaluate(1.0)[1];  // ρ'(1) = 1/(1 + 1/δ²)
  return std::sqrt(slope / (1.0 - slope));
}

Linearisation Shown(const Edge& edge) {
  Linearisation shown{edge.Residual(), {}};
  for (size_t i = 0; i < edge.Vertices().size(); ++i) shown.J.push_back(edge.Jacobian(i));
  return shown;
}

VertexList Select(const std::vector<int>& places, const VertexList& all) {
  VertexList selected;
  for (const int place : places) {
    if (place < 0 || place >= static_cast<int>(all.size())) throw WireError("an edge has a vertex that is not there");
    selected.push_back(all[static_cast<size_t>(place)]);
  }
  return selected;
}

void CheckSizes(const Linearisation& numbers, Eigen::Index rows, const VertexList& vertices) {
  bool fits = numbers.r.size() == rows && numbers.J.size() == vertices.size();
  for (size_t i = 0; fits && i < vertices.size(); ++i) {
    fits = numbers.J[i].rows() == rows && numbers.J[i].cols() == vertices[i]->LocalDimension();
  }
  if (!fits) throw WireError("an edge's residual and Jacobians do not fit together");
}

int TotalColumns(const VertexList& vertices) {
  int columns = 0;
  for (const auto& vertex : vertices) columns += vertex->LocalDimension();
  return columns;
}

}  // namespace

// ---- to numbers ------------------------------------------------------------------------------------------------------

Writer& operator<<(Writer& out, const VertexNumbers& vertex) {
  return out << vertex.type << vertex.id << vertex.role << vertex.fixed << vertex.local_dimension << vertex.x;
}
Reader& operator>>(Reader& in, VertexNumbers& vertex) {
  return in >> vertex.type >> vertex.id >> vertex.role >> vertex.fixed >> vertex.local_dimension >> vertex.x;
}
Writer& operator<<(Writer& out, const GraphNumbers& graph) { return out << graph.vertices << graph.edges; }
Reader& operator>>(Reader& in, GraphNumbers& graph) { return in >> graph.vertices >> graph.edges; }

VertexNumbers NumbersOf(const Vertex& vertex) {
  return {vertex.TypeInfo(),       vertex.Id(),        vertex.GetRole(), vertex.IsFixed(),
          vertex.LocalDimension(), vertex.Parameters()};
}

std::vector<VertexNumbers> NumbersOf(const VertexList& vertices) {
  std::vector<VertexNumbers> numbers;
  for (const auto& vertex : vertices) numbers.push_back(NumbersOf(*vertex));
  return numbers;
}

GraphNumbers NumbersOf(const VertexList& vertices, const EdgeList& edges) {
  GraphNumbers graph{NumbersOf(vertices), {}};
  for (const auto& edge : edges) {
    EdgeNumbers numbers{
        edge->TypeInfo(), edge->Id(), edge->Level(), {}, edge->Information(), ScaleOf(edge->GetLossFunction()),
        Shown(*edge),     {}};
    for (const auto& vertex : edge->Vertices()) {
      numbers.vertices.push_back(PlaceOf(vertex.get(), vertices));
      if (numbers.vertices.back() < 0)
        throw std::logic_error(edge->TypeInfo() + " has a vertex that is not in the graph");
    }
    edge->Linearize();
    numbers.after = Shown(*edge);
    graph.edges.push_back(std::move(numbers));
  }
  return graph;
}

int PlaceOf(const Vertex* vertex, const VertexList& vertices) {
  if (vertex == nullptr) return kNull;
  const auto it = std::find_if(vertices.begin(), vertices.end(), [&](const auto& v) { return v.get() == vertex; });
  return it == vertices.end() ? kUnknown : static_cast<int>(it - vertices.begin());
}

// ---- from numbers ----------------------------------------------------------------------------------------------------

std::shared_ptr<Vertex> MakeVertex(const VertexNumbers& numbers) {
  std::shared_ptr<Vertex> vertex;
  if (numbers.type == "VertexPose") vertex = std::make_shared<VertexPose>();
  if (numbers.type == "VertexSpeedBias") vertex = std::make_shared<VertexSpeedBias>();
  if (numbers.type == "VertexInverseDepth") vertex = std::make_shared<VertexInverseDepth>(0.0);
  if (numbers.type == "VertexPointXYZ") vertex = std::make_shared<VertexPointXYZ>(Vec3::Zero());
  if (numbers.type == "VertexVector1") vertex = std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0));
  if (!vertex) throw WireError("vertices of the type " + numbers.type + " cannot travel");
  if (vertex->LocalDimension() != numbers.local_dimension) throw WireError("a " + numbers.type + " of another size");
  vertex->SetRole(numbers.role == Role::kLandmark ? Role::kLandmark : Role::kPose);
  SetVertex(numbers, vertex.get());
  return vertex;
}

VertexList MakeVertices(const std::vector<VertexNumbers>& numbers) {
  VertexList vertices;
  for (const VertexNumbers& one : numbers) vertices.push_back(MakeVertex(one));
  return vertices;
}

void SetVertex(const VertexNumbers& numbers, Vertex* vertex) {
  if (numbers.x.size() != vertex->Dimension()) {
    throw WireError("a " + vertex->TypeInfo() + " with " + std::to_string(numbers.x.size()) + " parameters");
  }
  vertex->Parameters() = numbers.x;
  vertex->SetFixed(numbers.fixed);
}

WireEdge::WireEdge(const EdgeNumbers& numbers, const VertexList& all)
    : Edge(static_cast<int>(numbers.W.rows()), Select(numbers.vertices, all), nullptr, nullptr),
      type_(numbers.type),
      r_(VecX::Zero(numbers.W.rows())),
      W_(MatXX::Zero(numbers.W.rows(), numbers.W.rows())),
      J_(MatXX::Zero(numbers.W.rows(), TotalColumns(vertices_))) {
  Eigen::Index column = 0;
  for (size_t i = 0; i < vertices_.size(); ++i) {
    jacobians_[i] = J_.data() + column * J_.rows();
    column += vertices_[i]->LocalDimension();
  }
  Set(numbers);
}

void WireEdge::Set(const EdgeNumbers& numbers) {
  if (numbers.W.rows() != W_.rows() || numbers.W.cols() != W_.cols()) throw WireError("an information of another size");
  CheckSizes(numbers.before, W_.rows(), vertices_);
  CheckSizes(numbers.after, W_.rows(), vertices_);
  r_ = numbers.before.r;
  W_ = numbers.W;
  SetMemory(r_.data(), W_.data());
  ShowJacobians(numbers.before);
  after_ = numbers.after;
  linearised_ = 0;
  SetLossFunction(numbers.cauchy > 0.0 ? std::make_shared<CauchyLoss>(numbers.cauchy) : nullptr);
}

void WireEdge::ShowJacobians(const Linearisation& numbers) {
  for (size_t i = 0; i < vertices_.size(); ++i) {
    Eigen::Map<MatXX>(jacobians_[i], W_.rows(), vertices_[i]->LocalDimension()) = numbers.J[i];
  }
}

void WireEdge::ComputeResidual() {
  r_ = after_.r;
  linearised_ |= kResidual;
}

void WireEdge::ComputeJacobians() {
  ShowJacobians(after_);
  linearised_ |= kJacobians;
}

WireGraph::WireGraph(const GraphNumbers& numbers) : vertices_(MakeVertices(numbers.vertices)) {
  for (size_t k = 0; k < vertices_.size(); ++k) {
    if (numbers.vertices[k].id >= 0) graph_.AddVertex(vertices_[k], numbers.vertices[k].id);
  }
  for (const EdgeNumbers& one : numbers.edges) {
    edges_.push_back(std::make_shared<WireEdge>(one, vertices_));
    edges_.back()->SetLevel(one.level);
    if (one.id >= 0) graph_.AddEdge(edges_.back(), one.id);
  }
}

void WireGraph::Refresh(const GraphNumbers& numbers) {
  if (numbers.vertices.size() != vertices_.size() || numbers.edges.size() != edges_.size()) {
    throw WireError("another graph under the same number");
  }
  for (size_t k = 0; k < vertices_.size(); ++k) SetVertex(numbers.vertices[k], vertices_[k].get());
  for (size_t k = 0; k < edges_.size(); ++k) edges_[k]->Set(numbers.edges[k]);
}

std::vector<int> WireGraph::Linearised() const {
  std::vector<int> linearised;
  for (const auto& edge : edges_) linearised.push_back(edge->Linearised());
  return linearised;
}

void ShowAsLinearised(const GraphNumbers& numbers, const std::vector<int>& linearised, const EdgeList& edges) {
  if (linearised.size() != edges.size()) throw WireError("not one answer for each edge");
  for (size_t k = 0; k < edges.size(); ++k) {
    const EdgeNumbers& one = numbers.edges[k];
    const auto& shown_r = (linearised[k] & WireEdge::kResidual ? one.after : one.before).r;
    const auto& shown_J = (linearised[k] & WireEdge::kJacobians ? one.after : one.before).J;
    // An edge gives its numbers to be read only; here they are set as its Compute functions would have.
    std::copy_n(shown_r.data(), shown_r.size(), const_cast<double*>(edges[k]->Residual().data()));
    for (size_t i = 0; i < shown_J.size(); ++i) {
      std::copy_n(shown_J[i].data(), shown_J[i].size(), const_cast<double*>(edges[k]->Jacobian(i).data()));
    }
  }
}

}  // namespace ch5::homework
