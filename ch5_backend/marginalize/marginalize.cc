#include "ch5_backend/marginalize/marginalize.h"

#include <algorithm>

#include "ch5_backend/marginalize/layout.h"
#include "ch5_backend/math/dense_kernels.h"
#include "ch5_backend/solve/linear_parts.h"

namespace ch5 {
namespace {

// Column-major memory behind which the kernels may read.
VecX Zeros(Eigen::Index size) { return VecX::Zero(size + kernels::kOverread); }

class Elimination {
 public:
  explicit Elimination(const Layout& layout)
      : layout_(layout), n_(layout.size), H_memory_(Zeros(n_ * n_)), H_(H_memory_.data(), n_, n_), b_(VecX::Zero(n_)) {}

  MarginalSystem Run() {
    for (Edge* edge : layout_.dense_edges) AddEdge(edge, nullptr);
    EliminateLandmarks();
    return EliminateDense();
  }

 private:
  // What the edges of one landmark leave behind: V, b_l, and its columns w of the dense part, n×dim.
  struct Landmark {
    const Vertex* vertex;
    MatXX V;
    VecX b;
    double* w;
  };

  // The rows of one vertex in J̃ᵀ.
  struct Part {
    size_t vertex;  // position in the edge
    int column;     // of the dense part; −1: the landmark
    int dim;
    int row;
  };

  // H += J̃ᵀJ̃ (lower half), b −= J̃ᵀr̃ (solve/linear_parts.h), with the landmark's columns apart.
  void AddEdge(Edge* edge, Landmark* landmark) {
    edge->Linearize();
    FindParts(*edge, landmark ? landmark->vertex : nullptr);
    const int rows = WhitenTransposed(*edge);
    P_.resize(rows * rows + kernels::kOverread);
    kernels::SubtractProductAAt(rows, edge->ResidualDimension(), A_.data(), rows, P_.data(), rows,
                                kernels::Old::kForget);
    for (const Part& j : parts_) {
      for (int c = 0; c < j.dim; ++c) {
        const double* P = P_.data() + (j.row + c) * rows;  // −(J̃ᵀ[J̃ r̃]), a column
        (j.column < 0 ? landmark->b[c] : b_[j.column + c]) += P[rows - 1];
        for (const Part& i : parts_) {
          if (i.row < j.row) continue;
          double* H = i.column < 0   ? landmark->V.data() + c * j.dim
                      : j.column < 0 ? landmark->w + c * n_ + i.column
                                     : &H_(i.column, j.column + c);
          for (int r = i.row == j.row ? c : 0; r < i.dim; ++r) H[r] -= P[i.row + r];
        }
      }
    }
  }

  // The free vertices of an edge in the order of their columns, so that P's lower half is that of H.
  void FindParts(const Edge& edge, const Vertex* landmark) {
    parts_.clear();
    for (size_t i = 0; i < edge.Vertices().size(); ++i) {
      const Vertex* vertex = edge.Vertices()[i].get();
      if (vertex->IsFixed()) continue;
      const int column = vertex == landmark ? -1 : layout_.column.at(vertex);
      parts_.push_back({i, column, vertex->LocalDimension(), 0});
    }
    std::sort(parts_.begin(), parts_.end(), [](const Part& a, const Part& b) { return a.column < b.column; });
    for (size_t i = 1; i < parts_.size(); ++i) parts_[i].row = parts_[i - 1].row + parts_[i - 1].dim;
  }

  // A = [J̃ r̃]ᵀ in the order of the parts.  @return its rows
  int WhitenTransposed(const Edge& edge) {
    const int R = edge.ResidualDimension();
    const int rows = parts_.empty() ? 1 : parts_.back().row + parts_.back().dim + 1;
    A_.resize(rows * R + kernels::kOverread);
    Eigen::Map<MatXX> A(A_.data(), rows, R);
    const double scale = ScalarWhitening(edge);
    if (scale < 0.0) {
      M_.resize(R * R);
      r_.resize(R);
      WhitenFully(edge, edge.GetRobustWeight(), M_.data(), r_.data());  // row-major: Mᵀ to Eigen
      A.bottomRows<1>() = r_.transpose();
    } else {
      for (int k = 0; k < R; ++k) A(rows - 1, k) = scale * edge.Residual()[k];
    }
    for (const Part& part : parts_) {
      const auto J = edge.Jacobian(part.vertex);
      if (scale < 0.0) {
        A.middleRows(part.row, part.dim).noalias() = J.transpose() * Eigen::Map<const MatXX>(M_.data(), R, R);
        continue;
      }
      for (int k = 0; k < R; ++k) {
        for (int c = 0; c < part.dim; ++c) A(part.row + c, k) = scale * J(k, c);
      }
    }
    return rows;
  }

  // All landmarks at once:  H ← H − M Mᵀ,  b ← b − M N ᵀb_l,  the columns of M being w N with N Nᵀ = V⁺.
  void EliminateLandmarks() {
    int columns = 0;
    for (const auto& landmark : layout_.landmarks) columns += landmark->LocalDimension();
    if (columns == 0) return;
    VecX M = Zeros(n_ * columns);
    double* w = M.data();
    for (size_t l = 0; l < layout_.landmarks.size(); ++l) {
      const int dim = layout_.landmarks[l]->LocalDimension();
      Landmark landmark{layout_.landmarks[l].get(), MatXX::Zero(dim, dim), VecX::Zero(dim), w};
      for (Edge* edge : layout_.landmark_edges[l]) AddEdge(edge, &landmark);
      const MatXX N = PseudoInverseSquareRoot(landmark.V);
      Eigen::Map<MatXX> M_l(w, n_, dim);
      M_l = (M_l * N).eval();
      b_.noalias() -= M_l * (N.transpose() * landmark.b);
      w += n_ * dim;
    }
    const int n = static_cast<int>(n_);
    kernels::SubtractProductAAt(n, columns, M.data(), n, H_.data(), n);
  }

  // The same for what is dropped of the dense part:  M = H_kd N,  N Nᵀ = H_dd⁺.
  MarginalSystem EliminateDense() const {
    const int n = layout_.kept_size, m = layout_.size - n;
    const MatXX N = PseudoInverseSquareRoot(H_.bottomRightCorner(m, m));
    const MatXX M = H_.bottomLeftCorner(m, n).transpose() * N;
    MatXX H = H_.topLeftCorner(n, n);
    if (m > 0) H.selfadjointView<Eigen::Lower>().rankUpdate(M, -1.0);  // Eigen divides by m
    H.triangularView<Eigen::StrictlyUpper>() = H.transpose();
    return {layout_.kept, H, b_.head(n) - M * (N.transpose() * b_.tail(m))};
  }

  const Layout& layout_;
  Eigen::Index n_;
  VecX H_memory_;
  Eigen::Map<MatXX> H_;  // only the lower half has a meaning
  VecX b_;
  // Of the edge at hand.
  std::vector<Part> parts_;
  VecX A_, P_, M_, r_;
};

}  // namespace

MarginalSystem EliminateVertices(const std::vector<std::shared_ptr<Edge>>& edges,
                                 const std::vector<std::shared_ptr<Vertex>>& drop) {
  const Layout layout = MakeLayout(edges, drop);
  return Elimination(layout).Run();
}

Prior Marginalize(const std::vector<std::shared_ptr<Edge>>& edges, const std::vector<std::shared_ptr<Vertex>>& drop,
                  const std::optional<EigenCut>& cut) {
  MarginalSystem system = EliminateVertices(edges, drop);
  SquareRootForm form =
      cut ? FactorNormalEquations(system.H, system.b, *cut) : FactorNormalEquations(system.H, system.b);
  Prior prior;
  for (const auto& vertex : system.kept) prior.x0.emplace_back(vertex->Parameters());
  prior.vertices = std::move(system.kept);
  prior.J = std::move(form.J);
  prior.r0 = std::move(form.r0);
  return prior;
}

}  // namespace ch5
