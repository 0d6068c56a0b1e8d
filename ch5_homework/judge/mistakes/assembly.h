#pragma once
/// H and b as a loop over the pairs of an edge's vertices puts them together, rightly or wrongly: stages 1.1, 6 and 7.

#include <functional>
#include <utility>

#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {

/// One turn of the inner loop: the vertices i and j ≥ i of an edge, both free.
struct Turn {
  const Edge& edge;
  double drho;  ///< ρ'
  const MatXX& W_rho;
  size_t at_i, at_j;  ///< their numbers in the edge's list
  int i, j;           ///< where they begin in H and b

  const Vertex& v_i() const { return *edge.Vertices()[at_i]; }
  const Vertex& v_j() const { return *edge.Vertices()[at_j]; }
  bool IsDiagonal() const { return at_i == at_j; }
  MatXX Block(const MatXX& W) const { return edge.Jacobian(at_i).transpose() * W * edge.Jacobian(at_j); }
  MatXX Block() const { return Block(W_rho); }
};

inline int OrderedRow(const Edge& edge, size_t k) { return edge.Vertices()[k]->OrderingId(); }

struct Loop {
  const EdgeList& edges;
  int size;
  std::function<int(const Edge& edge, size_t k)> row_of = &OrderedRow;  ///< where the edge's vertex k begins
  bool stops_at_fixed = false;                                          ///< no pair behind a fixed vertex
};

template <typename Do>
void ForEachTurn(const Loop& loop, const Do& with) {
  for (const auto& edge : loop.edges) {
    double drho;
    MatXX W_rho;
    edge->RobustInfo(&drho, &W_rho);
    const auto& vertices = edge->Vertices();
    for (size_t i = 0; i < vertices.size(); ++i) {
      if (vertices[i]->IsFixed()) continue;
      for (size_t j = i; j < vertices.size(); ++j) {
        if (vertices[j]->IsFixed() && loop.stops_at_fixed) break;
        if (vertices[j]->IsFixed()) continue;
        with(Turn{*edge, drho, W_rho, i, j, loop.row_of(*edge, i), loop.row_of(*edge, j)});
      }
    }
  }
}

// ---- what may stand between two Jacobians, or before the residual ----------------------------------------------------

using Weight = MatXX (*)(const Turn& t);

inline MatXX WRho(const Turn& t) { return t.W_rho; }
inline MatXX W(const Turn& t) { return t.edge.Information(); }
inline MatXX RhoW(const Turn& t) { return t.drho * W(t); }
inline MatXX RhoRhoW(const Turn& t) { return t.drho * RhoW(t); }
inline MatXX RhoWRho(const Turn& t) { return t.drho * t.W_rho; }
inline MatXX RhoWW(const Turn& t) { return RhoW(t) * W(t); }
inline MatXX Covariance(const Turn& t) { return t.W_rho.inverse(); }
inline MatXX NoWeight(const Turn& t) { return MatXX::Identity(t.W_rho.rows(), t.W_rho.cols()); }
inline MatXX RhoAlone(const Turn& t) { return t.drho * NoWeight(t); }

// ---- H ---------------------------------------------------------------------------------------------------------------

/// What a turn of the loop does to H.
using Turning = std::function<void(MatXX* H, const Turn& t)>;

inline MatXX AssembleH(const Loop& loop, const Turning& turning) {
  MatXX H = MatXX::Zero(loop.size, loop.size);
  ForEachTurn(loop, [&](const Turn& t) { turning(&H, t); });
  return H;
}

// A block that would not fit (there, Eigen's assertion ends the student's run) is left out.
inline void Put(MatXX* H, int row, int column, const MatXX& block, bool assigned = false) {
  if (row + block.rows() > H->rows() || column + block.cols() > H->cols()) return;
  auto place = H->block(row, column, block.rows(), block.cols());
  place = assigned ? block : MatXX(place + block);
}

using Place = std::pair<int, int> (*)(const Turn& t);

inline std::pair<int, int> Rows(const Turn& t) { return {t.i, t.j}; }
inline std::pair<int, int> RowOfI(const Turn& t) { return {t.i, t.i}; }
inline std::pair<int, int> NumbersInEdge(const Turn& t) { return {static_cast<int>(t.at_i), static_cast<int>(t.at_j)}; }
inline std::pair<int, int> NumbersTimesSizes(const Turn& t) {
  return {static_cast<int>(t.at_i) * t.v_i().LocalDimension(), static_cast<int>(t.at_j) * t.v_j().LocalDimension()};
}
inline std::pair<int, int> Ids(const Turn& t) {
  return {t.v_i().Id() * t.v_i().LocalDimension(), t.v_j().Id() * t.v_j().LocalDimension()};
}

/// A statement of the loop: += of the block, or at the mirrored place of its transpose.
struct Statement {
  bool mirrored = false;
  double times = 1.0;
  Weight weight = &WRho;
  Place place = &Rows;
  bool turned = false;    ///< the transpose of what is right there
  bool assigned = false;  ///< = for +=

  Statement Times(double n) const {
    return With([n](Statement* s) { s->times = n; });
  }
  Statement Of(Weight other) const {
    return With([other](Statement* s) { s->weight = other; });
  }
  Statement At(Place other) const {
    return With([other](Statement* s) { s->place = other; });
  }
  Statement Turned() const {
    return With([](Statement* s) { s->turned = true; });
  }
  Statement Assigned() const {
    return With([](Statement* s) { s->assigned = true; });
  }

  void Run(MatXX* H, const Turn& t) const {
    const auto [row, column] = place(t);
    MatXX block = times * t.Block(weight(t));
    if (mirrored != turned) block.transposeInPlace();
    Put(H, mirrored ? column : row, mirrored ? row : column, block, assigned);
  }

 private:
  template <typename Set>
  Statement With(const Set& set) const {
    Statement changed = *this;
    set(&changed);
    return changed;
  }
};

const Statement kFirst{}, kMirror{true}, kNothing = kFirst.Times(0.0);

/// On a diagonal block; on another one and on its mirror image.
inline Turning Three(const Statement& diagonal, const Statement& first, const Statement& mirror) {
  return [=](MatXX* H, const Turn& t) {
    (t.IsDiagonal() ? diagonal : first).Run(H, t);
    if (!t.IsDiagonal()) mirror.Run(H, t);
  };
}
inline Turning Two(const Statement& first, const Statement& mirror) { return Three(first, first, mirror); }
inline Turning BothOf(Weight weight) { return Two(kFirst.Of(weight), kMirror.Of(weight)); }
/// J_i stands for J_j; where Eigen would not let it, J_j.
inline void WithJacobianOfI(MatXX* H, const Turn& t) {
  const bool alike = t.v_i().LocalDimension() == t.v_j().LocalDimension();
  const MatXX block = alike ? Turn{t.edge, t.drho, t.W_rho, t.at_i, t.at_i, t.i, t.i}.Block() : t.Block();
  Put(H, t.i, t.j, block);
  if (!t.IsDiagonal()) Put(H, t.j, t.i, block.transpose());
}
/// J_j stands for J_i, likewise.
inline void WithJacobianOfJ(MatXX* H, const Turn& t) {
  const bool alike = t.v_i().LocalDimension() == t.v_j().LocalDimension();
  const MatXX block = alike ? Turn{t.edge, t.drho, t.W_rho, t.at_j, t.at_j, t.j, t.j}.Block() : t.Block();
  Put(H, t.i, t.j, block);
  if (!t.IsDiagonal()) Put(H, t.j, t.i, block.transpose());
}
/// Skips an edge whose residual is zero.
inline void WithoutEdgesThatFit(MatXX* H, const Turn& t) {
  if (!t.edge.Residual().isZero(0.0)) Two(kFirst, kMirror)(H, t);
}

// ---- b ---------------------------------------------------------------------------------------------------------------

/// How often a turn adds JᵀWr to b: of i where j is i, else of i and of j. Right is once, where j is i.
struct Shares {
  double diagonal, of_i, of_j;
};
constexpr Shares kOnce{1, 0, 0};

inline VecX AssembleB(const Loop& loop, double sign, Weight weight, const Shares& shares = kOnce,
                      bool assigned = false) {
  VecX b = VecX::Zero(loop.size);
  ForEachTurn(loop, [&](const Turn& t) {
    const auto write = [&](size_t k, int row, double times) {
      const Eigen::Index dim = t.edge.Vertices()[k]->LocalDimension();
      if (times == 0.0 || row < 0 || row + dim > b.size()) return;
      const VecX share = sign * times * t.edge.Jacobian(k).transpose() * weight(t) * t.edge.Residual();
      b.segment(row, dim) = assigned ? share : VecX(b.segment(row, dim) + share);
    };
    write(t.at_i, t.i, t.IsDiagonal() ? shares.diagonal : shares.of_i);
    if (!t.IsDiagonal()) write(t.at_j, t.j, shares.of_j);
  });
  return b;
}

}  // namespace ch5::homework
