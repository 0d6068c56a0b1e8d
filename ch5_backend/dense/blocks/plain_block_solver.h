#pragma once
/// The block solver in plain words: g2o's BlockSolver with one Eigen matrix per block, one thread, any sizes.
///
///      ┌───────┬──────┐        H_pp(i, j)  of poses that share an edge; only i ≥ j are stored
///      │ H_pp  │ H_pl │        H_pl(i, l)  of a pose and a landmark that it sees
///      ├───────┼──────┤        H_ll(l, l)  of a landmark
///      │ H_plᵀ │ H_ll │
///      └───────┴──────┘        S = H_pp + λD − Σ_l H_pl H_ll⁻¹ H_plᵀ;  S(i, j), i ≥ j, of poses that share an edge or
///                              a landmark;  H_ll is damped by λD before it is inverted
///
/// Three functions are the homework (stage 7) and live in solutions/block_solver.cc or ch5_homework/block_solver.cc;
/// all else is in plain_block_solver.cc. SparseSolver (sparse/sparse_solver.h) computes the same fast.

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ch5_backend/graph/ordering.h"
#include "ch5_backend/solve/minimizer.h"
#include "ch5_backend/solve/normal_equations.h"

namespace ch5 {

class ReducedSolver;

/// The blocks (i, j) of a sparse matrix. Only those that were added exist.
class SparseBlocks {
 public:
  explicit SparseBlocks(std::string name) : name_(std::move(name)) {}

  void Clear() { blocks_.clear(); }
  /// Adds a block of zeros, unless it exists.
  void Add(int i, int j, int rows, int columns) { blocks_.try_emplace({i, j}, MatXX::Zero(rows, columns)); }
  void SetZero();

  /// @throws std::out_of_range if the block was never added; the message names it
  MatXX& operator()(int i, int j);
  const MatXX& operator()(int i, int j) const { return const_cast<SparseBlocks&>(*this)(i, j); }

  const std::map<std::pair<int, int>, MatXX>& All() const { return blocks_; }

 private:
  std::string name_;
  std::map<std::pair<int, int>, MatXX> blocks_;
};

class PlainBlockSolver : public NormalEquations {
 public:
  /// The graph must outlive the solver. SetOrdering, which Minimize calls, must come first.
  explicit PlainBlockSolver(Graph* graph);
  ~PlainBlockSolver() override;

  /// Stage 7a.  Finds which blocks H and S have.
  virtual void BuildStructure();
  /// Stages 7b, 7c.  H = Σ JᵀW_ρJ,  b = −Σ ρ'JᵀWr  over all edges.
  virtual void BuildSystem();
  /// Stages 7d, 7e.  Solves (H + λD) Δx = b: eliminates landmark by landmark, solves for the poses, substitutes back.
  virtual bool Solve(double lambda, VecX* delta_x);

  /// @throws GraphError if an edge ties two free landmarks
  void SetOrdering() override;
  void CheckOrdering() const override { ch5::CheckOrdering(ordering_); }
  int Size() const override { return ordering_.Size(); }
  double Cost() override { return ch5::Cost(ordering_.edges); }
  void MakeHessian() override { BuildSystem(); }
  bool SolveLinearSystem(double lambda, VecX* delta_x) override { return Solve(lambda, delta_x); }
  const VecX& RightHandSide() const override { return b_; }
  VecX HessianDiagonal() const override;
  VecX MultiplyHessian(const VecX& v) const override;
  void UpdateStates(const VecX& delta_x) override { Update(ordering_, delta_x); }
  void RollbackStates() override { RollBack(ordering_); }
  double StateNorm() const override { return ch5::StateNorm(ordering_); }
  std::string WhatIsNotFinite() override { return ch5::WhatIsNotFinite(ordering_.edges); }

  /// H as a dense matrix.
  MatXX DenseHessian() const;
  /// S and b_p − Σ_l H_pl H_ll⁻¹ b_l of the last Solve.
  MatXX SchurComplement() const;
  const VecX& ReducedRightHandSide() const { return b_schur_; }
  /// The pairs (i, j) of poses for which S has a block.
  std::vector<std::pair<int, int>> SchurPattern() const;
  const Ordering& GetOrdering() const { return ordering_; }

 protected:
  /// Which block row and column of H a free vertex has: those of pose `number` or of landmark `number`.
  struct BlockIndex {
    bool is_landmark;
    int number;
  };
  BlockIndex BlockIndexOf(const Vertex& vertex) const {
    return block_of_row_[static_cast<size_t>(vertex.OrderingId())];
  }
  int PoseDimension(int pose) const { return ordering_.poses[static_cast<size_t>(pose)]->LocalDimension(); }
  int PoseRow(int pose) const { return ordering_.poses[static_cast<size_t>(pose)]->OrderingId(); }
  int NumLandmarks() const { return static_cast<int>(ordering_.landmarks.size()); }
  /// The numbers of the poses that see landmark l.
  const std::vector<int>& PosesThatSee(int l) const { return seen_by_[static_cast<size_t>(l)]; }
  /// Landmark l's part of a vector of all unknowns.
  VecX::SegmentReturnType LandmarkPart(VecX* v, int l) const;

  /// Zero blocks of H wherever an edge has two free vertices.
  void MakeHessianBlocks();
  /// A zero block S(i, j) of two poses.
  void AddSchurBlock(int i, int j) { S_.Add(i, j, PoseDimension(i), PoseDimension(j)); }
  void SetSystemToZero();
  /// H_ll_inverse_ = (H_ll + λD)⁻¹. @return false if one is not positive definite
  bool InvertLandmarks(double lambda);
  /// S_ = H_pp + λD and b_schur_ = b_p.
  void BeginSchurComplement(double lambda);
  /// The first rows of Δx, those of the poses, by Cholesky of S_.
  bool SolvePoses(VecX* delta_x);

  GraphPointer graph_;
  Ordering ordering_;
  std::vector<BlockIndex> block_of_row_;  // by the first row of each block
  std::vector<std::vector<int>> seen_by_;
  SparseBlocks H_pp_{"H_pp"}, H_pl_{"H_pl"}, H_ll_{"H_ll"}, H_ll_inverse_{"H_ll_inverse"}, S_{"S"};
  VecX b_, b_schur_;
  VecX scale_;  // the damped diagonal of H_pp
  std::unique_ptr<ReducedSolver> reduced_solver_;
};

}  // namespace ch5
