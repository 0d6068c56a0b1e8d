#include "ch5_backend/marginalize/marginalize.h"

#include <algorithm>

#include "ch5_backend/graph/whitening.h"
#include "ch5_backend/marginalize/layout.h"
#include "ch5_backend/math/dense_kernels.h"
#include "ch5_backend/types/fast_edge.h"

namespace ch5 {
namespace {

// Memory for a column-major matrix; the kernels may read a little beyond it.
VecX Zeros(Eigen::Index size) { return VecX::Zero(size + kernels::kOverread); }

class Elimination {
 public:
  explicit Elimination(const Layout& layout)
      : layout_(layout), n_(layout.size), H_memory_(Zeros(n_ * n_)), H_(H_memory_.data(), n_, n_), b_(VecX::Zero(n_)) {}

  MarginalSystem Run() {
    for (const Layout::EdgeColumns& entry : layout_.dense_edges) AddEdge(entry, nullptr);
    EliminateLandmarks();
    return EliminateDense();
  }

 private:
  // One landmark's blocks of the normal equations; H_pl is n×dim, column-major.
  struct Landmark {
    MatXX H_ll;
    VecX b_l;
    double* H_pl;
  };

  // One free vertex of an edge.
  struct Block {
    size_t vertex;  // position in the edge
    int column;     // its first column in the dense part, or Layout::kLandmark
    int dim;
    int row;  // its first row in J̃ᵀ
  };

  // H += J̃ᵀJ̃ (lower half), b −= J̃ᵀr̃ (graph/whitening.h), the landmark's columns into its own blocks.
  void AddEdge(const Layout::EdgeColumns& entry, Landmark* landmark) {
    FindBlocks(entry);
    if (AddPlainEdge(*entry.edge, landmark)) return;
    const int rows = Columns() + 1;
    P_.resize(rows * rows + kernels::kOverread);  // −[J̃ r̃]ᵀ[J̃ r̃]
    if (!NegativeProducts(entry.edge, ColumnsInEdge(*entry.edge), P_.data())) {
      entry.edge->Linearize();
      WhitenTransposed(*entry.edge);
      kernels::SubtractProductAAt(rows, entry.edge->ResidualDimension(), A_.data(), rows, P_.data(), rows,
                                  kernels::Old::kForget);
    }
    for (const Block& j : blocks_) {
      for (int c = 0; c < j.dim; ++c) {
        const double* P = P_.data() + (j.row + c) * rows;
        Gradient(j, c, landmark) += P[rows - 1];
        for (const Block& i : blocks_) {
          if (i.row < j.row) continue;
          double* H = BlockColumn(i, j, c, landmark);
          for (int r = i.row == j.row ? c : 0; r < i.dim; ++r) H[r] -= P[i.row + r];
        }
      }
    }
  }

  // The most frequent kind of edge: two rows, W = w I.  @return false if the edge is of another kind
  bool AddPlainEdge(const Edge& edge, Landmark* landmark) {
    constexpr int kMostVertices = 5, kMostColumns = 32;
    const double w = edge.IsotropicInformation();
    if (edge.ResidualDimension() != 2 || w < 0.0 || Columns() > kMostColumns || edge.Vertices().size() > kMostVertices)
      return false;
    double r[2], J[2 * kMostColumns], row_0[kMostColumns], row_1[kMostColumns];
    double* J_of[kMostVertices] = {};
    for (const Block& block : blocks_) J_of[block.vertex] = J + 2 * block.row;
    const FastEdge* fast = AsFast(edge);
    if (!fast || !fast->LinearizeInto(r, J_of)) return false;
    const TwoRowWhitening white(w, edge.GetLossFunction(), r);
    for (int c = 0; c < Columns(); ++c) {
      row_0[c] = white.M[0][0] * J[2 * c] + white.M[0][1] * J[2 * c + 1];
      row_1[c] = white.M[1][0] * J[2 * c] + white.M[1][1] * J[2 * c + 1];
    }
    for (const Block& j : blocks_) {
      const double *x = row_0 + j.row, *y = row_1 + j.row;
      for (int c = 0; c < j.dim; ++c) Gradient(j, c, landmark) -= x[c] * white.r[0] + y[c] * white.r[1];
      for (const Block& i : blocks_) {
        if (i.row < j.row) continue;
        const double *a = row_0 + i.row, *b = row_1 + i.row;
        for (int c = 0; c < j.dim; ++c) {
          double* H = BlockColumn(i, j, c, landmark);
          if (i.dim == 6) {  // a pose; the upper half of its own block is written but never read
            Eigen::Map<Vec6>{H} += x[c] * Eigen::Map<const Vec6>(a) + y[c] * Eigen::Map<const Vec6>(b);
          } else {
            for (int k = 0; k < i.dim; ++k) H[k] += x[c] * a[k] + y[c] * b[k];
          }
        }
      }
    }
    return true;
  }

  double& Gradient(const Block& j, int c, Landmark* landmark) {
    return j.column < 0 ? landmark->b_l[c] : b_[j.column + c];
  }
  // Column c of block (i, j): of the dense part, of H_pl, or of H_ll.
  double* BlockColumn(const Block& i, const Block& j, int c, Landmark* landmark) {
    if (i.column < 0) return landmark->H_ll.data() + c * j.dim;
    return j.column < 0 ? landmark->H_pl + c * n_ + i.column : &H_(i.column, j.column + c);
  }

  // The free vertices of an edge in the order of their columns, so that the lower half of its products is that of H.
  void FindBlocks(const Layout::EdgeColumns& entry) {
    blocks_.clear();
    const auto& vertices = entry.edge->Vertices();
    for (size_t i = 0; i < vertices.size(); ++i) {
      const int column = layout_.ColumnsOf(entry)[i];
      if (column != Layout::kFixed) blocks_.push_back({i, column, vertices[i]->LocalDimension(), 0});
    }
    std::sort(blocks_.begin(), blocks_.end(), [](const Block& a, const Block& b) { return a.column < b.column; });
    for (size_t i = 1; i < blocks_.size(); ++i) blocks_[i].row = blocks_[i - 1].row + blocks_[i - 1].dim;
  }
  int Columns() const { return blocks_.empty() ? 0 : blocks_.back().row + blocks_.back().dim; }

  // The columns of the blocks among those of all vertices of the edge, then the residual's.
  const std::vector<int>& ColumnsInEdge(const Edge& edge) {
    std::vector<int> begin{0};
    for (const auto& vertex : edge.Vertices()) begin.push_back(begin.back() + vertex->LocalDimension());
    columns_.clear();
    for (const Block& block : blocks_) {
      for (int c = 0; c < block.dim; ++c) columns_.push_back(begin[block.vertex] + c);
    }
    columns_.push_back(begin.back());
    return columns_;
  }

  // A = [J̃ r̃]ᵀ in the order of the blocks.
  void WhitenTransposed(const Edge& edge) {
    const int R = edge.ResidualDimension(), rows = Columns() + 1;
    A_.resize(rows * R + kernels::kOverread);
    Eigen::Map<MatXX> A(A_.data(), rows, R);
    const double scale = ScalarWhitening(edge);
    if (scale < 0.0) {
      M_.resize(R * R);
      r_.resize(R);
      Whiten(edge, edge.GetRobustWeight(), M_.data(), r_.data());  // row-major: Mᵀ to Eigen
      A.bottomRows<1>() = r_.transpose();
    } else {
      for (int k = 0; k < R; ++k) A(rows - 1, k) = scale * edge.Residual()[k];
    }
    for (const Block& block : blocks_) {
      const auto J = edge.Jacobian(block.vertex);
      if (scale < 0.0) {
        A.middleRows(block.row, block.dim).noalias() = J.transpose() * Eigen::Map<const MatXX>(M_.data(), R, R);
        continue;
      }
      for (int k = 0; k < R; ++k) {
        for (int c = 0; c < block.dim; ++c) A(block.row + c, k) = scale * J(k, c);
      }
    }
  }

  // All landmarks at once:  H ← H − M Mᵀ,  b ← b − M Nᵀb_l,  where M has the columns H_pl N, N Nᵀ = H_ll⁺.
  void EliminateLandmarks() {
    int columns = 0;
    for (const auto& landmark : layout_.landmarks) columns += landmark->LocalDimension();
    if (columns == 0) return;
    VecX M = Zeros(n_ * columns);
    Landmark landmark{{}, {}, M.data()};
    for (size_t l = 0; l < layout_.landmarks.size(); ++l) {
      const int dim = layout_.landmarks[l]->LocalDimension();
      landmark.H_ll.setZero(dim, dim);
      landmark.b_l.setZero(dim);
      for (const Layout::EdgeColumns& entry : layout_.landmark_edges[l]) AddEdge(entry, &landmark);
      const MatXX N = PseudoInverseSquareRoot(landmark.H_ll);
      Eigen::Map<MatXX> M_l(landmark.H_pl, n_, dim);
      if (dim == 1) {  // an inverse depth: no matrix products
        M_l *= N(0, 0);
        b_ -= M_l * (N(0, 0) * landmark.b_l[0]);
      } else {
        M_l = (M_l * N).eval();
        b_.noalias() -= M_l * (N.transpose() * landmark.b_l);
      }
      landmark.H_pl += n_ * dim;
    }
    const int n = static_cast<int>(n_);
    kernels::SubtractProductAAt(n, columns, M.data(), n, H_.data(), n);
  }

  // The same for the dropped vertices of the dense part:  M = H_kd N,  N Nᵀ = H_dd⁺.
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
  Eigen::Map<MatXX> H_;  // only the lower half is used
  VecX b_;
  // Scratch memory, of the current edge.
  std::vector<Block> blocks_;
  std::vector<int> columns_;
  VecX A_, P_, M_, r_;
};

}  // namespace

MarginalSystem EliminateVertices(const std::vector<std::shared_ptr<Edge>>& edges,
                                 const std::vector<std::shared_ptr<Vertex>>& drop) {
  const Layout layout = MakeLayout(edges, drop);
  return Elimination(layout).Run();
}

// H_rr − H_rm H_mm⁻¹ H_mr, then its root.  Leutenegger (2015), §4.3
Prior Marginalize(const std::vector<std::shared_ptr<Edge>>& edges, const std::vector<std::shared_ptr<Vertex>>& drop,
                  const std::optional<EigenvalueCutoff>& cutoff) {
  MarginalSystem system = EliminateVertices(edges, drop);
  SquareRootForm form =
      cutoff ? FactorNormalEquations(system.H, system.b, *cutoff) : FactorNormalEquations(system.H, system.b);
  Prior prior;
  for (const auto& vertex : system.kept) prior.x0.emplace_back(vertex->Parameters());
  prior.vertices = std::move(system.kept);
  prior.J = std::move(form.J);
  prior.r0 = std::move(form.r0);
  return prior;
}

}  // namespace ch5
