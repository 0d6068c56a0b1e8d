#include "ch5_backend/marginalize/marginalize.h"

#include "ch5_backend/marginalize/layout.h"
#include "ch5_backend/math/psd.h"

namespace ch5 {
namespace {

// C += Aᵀ B for thin A and B (R×a, R×b, column-major): a product of dynamic matrices would spend its time on overhead.
void AddTransposedProduct(const double* A, int a, const double* B, int b, int R, double* C, Eigen::Index stride) {
  for (int j = 0; j < b; ++j) {
    for (int i = 0; i < a; ++i) {
      double sum = 0.0;
      for (int k = 0; k < R; ++k) sum += A[i * R + k] * B[j * R + k];
      C[j * stride + i] += sum;
    }
  }
}

class Elimination {
 public:
  explicit Elimination(const Layout& layout)
      : layout_(layout),
        H_(MatXX::Zero(layout.size, layout.size)),
        b_(VecX::Zero(layout.size)),
        touched_(static_cast<size_t>(layout.size), false) {}

  MarginalSystem Run() {
    for (Edge* edge : layout_.dense_edges) AddEdge(edge, nullptr);
    for (size_t l = 0; l < layout_.landmarks.size(); ++l) EliminateLandmark(l);
    H_.triangularView<Eigen::StrictlyUpper>() = H_.transpose();
    return {layout_.kept, DropDense(), std::move(b_)};
  }

 private:
  struct Segment {
    int column, dim;
  };

  // One landmark's V, w and b_l, and the columns of the dense part that w touches.
  struct Landmark {
    const Vertex* vertex;
    MatXX V;
    VecX b;
    MatXX w;
    std::vector<Segment> segments;
  };

  // H += JᵀW_ρJ (lower half), b −= ρ'JᵀWr, with the landmark's columns apart.
  void AddEdge(Edge* edge, Landmark* landmark) {
    edge->ComputeResidual();
    edge->ComputeJacobians();
    edge->RobustInfo(&drho_, &W_);
    Wr_.noalias() = drho_ * (edge->Information() * edge->Residual());
    const int R = edge->ResidualDimension();
    const auto& vertices = edge->Vertices();
    for (size_t i = 0; i < vertices.size(); ++i) {
      if (vertices[i]->IsFixed()) continue;
      const auto J_i = edge->Jacobian(i);
      const int dim_i = vertices[i]->LocalDimension();
      WJ_.noalias() = W_ * J_i;
      const bool is_landmark = landmark && vertices[i].get() == landmark->vertex;
      if (is_landmark) {
        AddTransposedProduct(WJ_.data(), dim_i, J_i.data(), dim_i, R, landmark->V.data(), dim_i);
        landmark->b.noalias() -= J_i.transpose() * Wr_;
        continue;
      }
      const int row = layout_.column.at(vertices[i].get());
      b_.segment(row, dim_i).noalias() -= J_i.transpose() * Wr_;
      for (size_t j = 0; j < vertices.size(); ++j) {
        if (vertices[j]->IsFixed()) continue;
        const int dim_j = vertices[j]->LocalDimension();
        const double* J_j = edge->Jacobian(j).data();
        if (landmark && vertices[j].get() == landmark->vertex) {
          Touch(landmark, row, dim_i);
          AddTransposedProduct(WJ_.data(), dim_i, J_j, dim_j, R, landmark->w.data() + row, layout_.size);
          continue;
        }
        const int column = layout_.column.at(vertices[j].get());
        if (column > row) continue;  // the lower half only
        AddTransposedProduct(WJ_.data(), dim_i, J_j, dim_j, R, &H_(row, column), layout_.size);
      }
    }
  }

  void Touch(Landmark* landmark, int column, int dim) {
    if (touched_[static_cast<size_t>(column)]) return;
    touched_[static_cast<size_t>(column)] = true;
    landmark->segments.push_back({column, dim});
  }

  // H ← H − M Mᵀ,  b ← b − M (V^-½)ᵀ b_l,  M = w V^-½, over the touched columns only.
  void EliminateLandmark(size_t l) {
    const int dim = layout_.landmarks[l]->LocalDimension();
    Landmark landmark{layout_.landmarks[l].get(), MatXX::Zero(dim, dim), VecX::Zero(dim), std::move(w_memory_), {}};
    if (landmark.w.cols() != dim) landmark.w.setZero(layout_.size, dim);
    for (Edge* edge : layout_.landmark_edges[l]) AddEdge(edge, &landmark);

    const MatXX V_inv_sqrt = PseudoInverseSquareRoot(landmark.V);
    const VecX half_b = V_inv_sqrt.transpose() * landmark.b;
    for (const Segment& s : landmark.segments) {
      auto w = landmark.w.middleRows(s.column, s.dim);
      w = (w * V_inv_sqrt).eval();
      b_.segment(s.column, s.dim).noalias() -= w * half_b;
    }
    for (const Segment& s : landmark.segments) {
      for (const Segment& t : landmark.segments) {
        if (t.column > s.column) continue;
        for (int k = 0; k < dim; ++k) {
          const double* m = landmark.w.data() + k * layout_.size;
          for (int j = 0; j < t.dim; ++j) {
            double* column = &H_(s.column, t.column + j);
            for (int i = 0; i < s.dim; ++i) column[i] -= m[s.column + i] * m[t.column + j];
          }
        }
      }
    }
    for (const Segment& s : landmark.segments) {  // leave the memory zero for the next one
      landmark.w.middleRows(s.column, s.dim).setZero();
      touched_[static_cast<size_t>(s.column)] = false;
    }
    w_memory_ = std::move(landmark.w);
  }

  // H_kk − H_kd H_dd⁺ H_dk, and b alike; H_dd is scaled to a unit diagonal, since its rows have many units.
  MatXX DropDense() {
    const int n = layout_.kept_size, m = layout_.size - n;
    const MatXX H_kd = H_.topRightCorner(n, m), H_dd = H_.bottomRightCorner(m, m);
    const VecX p_inverse = ScalingOf(H_dd).cwiseInverse();
    const MatXX inverse = PseudoInversePsd(p_inverse.asDiagonal() * H_dd * p_inverse.asDiagonal());
    const MatXX gain = H_kd * p_inverse.asDiagonal() * inverse * p_inverse.asDiagonal();
    MatXX H = H_.topLeftCorner(n, n) - gain * H_kd.transpose();
    const VecX b = b_.head(n) - gain * b_.tail(m);
    b_ = b;
    return 0.5 * (H + H.transpose());
  }

  const Layout& layout_;
  MatXX H_;
  VecX b_;
  std::vector<bool> touched_;
  MatXX w_memory_, W_, WJ_;
  VecX Wr_;
  double drho_ = 1.0;
};

}  // namespace

MarginalSystem EliminateVertices(const std::vector<std::shared_ptr<Edge>>& edges,
                                 const std::vector<std::shared_ptr<Vertex>>& drop) {
  const Layout layout = MakeLayout(edges, drop);
  return Elimination(layout).Run();
}

Prior Marginalize(const std::vector<std::shared_ptr<Edge>>& edges, const std::vector<std::shared_ptr<Vertex>>& drop,
                  const EigenCut& cut) {
  MarginalSystem system = EliminateVertices(edges, drop);
  SquareRootForm form = FactorNormalEquations(system.H, system.b, cut);
  Prior prior;
  for (const auto& vertex : system.kept) prior.x0.emplace_back(vertex->Parameters());
  prior.vertices = std::move(system.kept);
  prior.J = std::move(form.J);
  prior.r0 = std::move(form.r0);
  return prior;
}

}  // namespace ch5
