#pragma once
/// An edge is one residual r(x) with its information W and loss ρ:  cost ½ ρ(rᵀWr).
///
/// r = prediction − measurement.  J_i = ∂r(x_i ⊞ δ)/∂δ at δ = 0.  Storage is fixed-size (SizedEdge); the virtual
/// boundary hands out views, so solvers need not know the sizes.

#include <cassert>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "ch5_backend/graph/loss.h"
#include "ch5_backend/graph/vertex.h"
#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

/// The vertices of an edge in its own order: a view, valid while the edge lives.
class VertexSpan {
 public:
  VertexSpan(const std::shared_ptr<Vertex>* first, size_t size) : first_(first), size_(size) {}

  const std::shared_ptr<Vertex>* begin() const { return first_; }
  const std::shared_ptr<Vertex>* end() const { return first_ + size_; }
  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const std::shared_ptr<Vertex>* data() const { return first_; }
  const std::shared_ptr<Vertex>& operator[](size_t i) const {
    assert(i < size_);
    return first_[i];
  }
  const std::shared_ptr<Vertex>& front() const { return (*this)[0]; }
  const std::shared_ptr<Vertex>& back() const { return (*this)[size_ - 1]; }
  /// @throws std::out_of_range
  const std::shared_ptr<Vertex>& at(size_t i) const {
    if (i >= size_) throw std::out_of_range("an edge has no vertex " + std::to_string(i));
    return first_[i];
  }
  operator std::vector<std::shared_ptr<Vertex>>() const { return {begin(), end()}; }

 private:
  const std::shared_ptr<Vertex>* first_;
  size_t size_;
};

class Edge {
 public:
  virtual ~Edge() = default;
  Edge(const Edge&) = delete;
  Edge& operator=(const Edge&) = delete;

  const VertexSpan& Vertices() const { return vertices_; }
  int ResidualDimension() const { return residual_dimension_; }

  virtual void ComputeResidual() = 0;
  /// Fills all of J_0, J_1, …, which hold NaN before, at the present state. The default differentiates ComputeResidual
  /// numerically; the residual on return is that of the present state.
  virtual void ComputeJacobians() { ComputeJacobiansNumerically(); }
  /// Both, as a solver asks for them. An edge whose residual and Jacobians share their work computes them together here.
  virtual void Linearize() {
    ComputeResidual();
    ComputeJacobians();
  }
  /// True once the Jacobians have been differentiated numerically. That moves the vertices for a moment, so two such
  /// edges at one vertex cannot be linearized at once.
  bool HasNumericJacobians() const { return numeric_jacobians_; }
  /// False where the residual is a number but the model does not hold at the present state: a point behind its camera,
  /// which a pinhole projects as if it were ahead. Solvers do not ask; EdgesOutOfDomain finds these edges.
  virtual bool InDomain() const { return true; }
  /// The type's name, as it appears in messages.
  virtual std::string TypeInfo() const = 0;
  /// The same, and the id once it is in a graph.
  std::string Name() const { return TypeInfo() + (id_ < 0 ? "" : " " + std::to_string(id_)); }

  /// r, ResidualDimension()×1, of the last ComputeResidual.
  Eigen::Map<const VecX> Residual() const { return {residual_, residual_dimension_}; }
  /// J_i, ResidualDimension()×LocalDimension() of vertex i, of the last ComputeJacobians.
  Eigen::Map<const MatXX> Jacobian(size_t i) const {
    if (!HasJacobians()) TakeJacobians();
    return {jacobians_[i], residual_dimension_, vertices_[i]->LocalDimension()};
  }

  /// W, symmetric positive semi-definite; the identity unless set.
  Eigen::Map<const MatXX> Information() const { return {information_, residual_dimension_, residual_dimension_}; }
  /// w of W = w I, or −1 if W is another matrix.
  double IsotropicInformation() const { return isotropic_information_; }
  /// @throws std::invalid_argument if W has the wrong size, a number that is not finite, or is not symmetric
  ///         positive semi-definite (relative tolerance 1e-9).
  void SetInformation(const MatXX& information);
  /// W = w I: the same, without a matrix to check.  @throws std::invalid_argument unless w ≥ 0 is finite
  void SetIsotropicInformation(double w);

  /// Shared by many edges; none means ρ(s) = s.
  void SetLossFunction(std::shared_ptr<const LossFunction> loss) { loss_ = std::move(loss); }
  const LossFunction* GetLossFunction() const { return loss_.get(); }

  /// s = rᵀWr of the last residual.
  double Chi2() const;
  /// ½ρ(s).
  double Cost() const;
  /// What the loss does to this edge's part of H and b at the last residual.
  RobustWeight GetRobustWeight() const;
  /// W_ρ = ρ'W + 2ρ''(Wr)(Wr)ᵀ into `robust_information`, ρ' into `drho`: H gets JᵀW_ρJ and b gets −ρ'JᵀWr.
  void RobustInfo(double* drho, MatXX* robust_information) const;

  int Id() const { return id_; }

  /// An optimization uses the edges of one level only, 0 by default. Edges of another level are ignored, for example
  /// outliers, but stay in the graph.
  int Level() const { return level_; }
  /// @throws std::invalid_argument if `level` is negative
  void SetLevel(int level);

 protected:
  /// For an edge with its vertices in its own memory, as SizedEdge: that costs no allocation, and they are found beside it.
  Edge(int residual_dimension, VertexSpan vertices, double* residual, double* information)
      : residual_dimension_(residual_dimension), vertices_(vertices), residual_(residual), information_(information) {}
  Edge(int residual_dimension, std::vector<std::shared_ptr<Vertex>> vertices, double* residual, double* information)
      : Edge(residual_dimension, VertexSpan(nullptr, 0), residual, information) {
    listed_vertices_ = std::move(vertices);
    vertices_ = VertexSpan(listed_vertices_.data(), listed_vertices_.size());
    jacobians_.assign(vertices_.size(), nullptr);
  }

  /// For an edge whose sizes are known at run time only.
  void SetMemory(double* residual, double* information) {
    residual_ = residual;
    information_ = information;
    NoteInformation();
  }
  /// Call this after writing to W directly.
  void NoteInformation();

  /// Takes the Jacobians' memory and fills in jacobians_, when they are first asked for. An edge whose sizes are known at
  /// run time only needs one of its own: without, it throws std::logic_error.
  virtual void TakeJacobians() const;

  /// Central differences, δ = 1e-6 (error O(δ²) + ε/δ ≈ 1e-10 relative).
  void ComputeJacobiansNumerically();

  bool HasJacobians() const { return vertices_.empty() || (!jacobians_.empty() && jacobians_[0]); }

  int residual_dimension_;
  VertexSpan vertices_;
  mutable std::vector<double*> jacobians_;  // column-major; empty or null until they are needed

 private:
  friend class Graph;  // numbers its edges

  std::vector<std::shared_ptr<Vertex>> listed_vertices_;  // empty where the derived class keeps them
  double* residual_;
  double* information_;
  std::shared_ptr<const LossFunction> loss_;
  int id_ = -1;
  int level_ = 0;
  bool numeric_jacobians_ = false;
  double isotropic_information_ = 1.0;
};

}  // namespace ch5
