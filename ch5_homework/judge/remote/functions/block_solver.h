#pragma once
/// block_solver.cc: stage 7.

#include "ch5_homework/judge/remote/remote.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {

inline Writer& operator<<(Writer& out, const SparseBlocks& blocks) {
  return out << std::vector<std::pair<std::pair<int, int>, MatXX>>(blocks.All().begin(), blocks.All().end());
}
inline Reader& operator>>(Reader& in, SparseBlocks& blocks) {
  std::vector<std::pair<std::pair<int, int>, MatXX>> numbers;
  in >> numbers;
  blocks.Clear();
  for (const auto& [place, block] : numbers) {
    blocks.Add(place.first, place.second, 0, 0);
    blocks(place.first, place.second) = block;
  }
  return in;
}

namespace block_solver {

struct Access : PlainBlockSolver {
  using PlainBlockSolver::b_;
  using PlainBlockSolver::b_schur_;
  using PlainBlockSolver::H_ll_;
  using PlainBlockSolver::H_pl_;
  using PlainBlockSolver::H_pp_;
  using PlainBlockSolver::S_;
};

}  // namespace block_solver

template <>
struct ObjectOf<PlainBlockSolver> {
  static std::unique_ptr<PlainBlockSolver> Make(Scene* scene) { return Chosen().make_block_solver(&scene->GetGraph()); }
  static auto Members(PlainBlockSolver& s) {
    using Access = block_solver::Access;
    return std::tie(s.*(&Access::H_pp_), s.*(&Access::H_pl_), s.*(&Access::H_ll_), s.*(&Access::S_), s.*(&Access::b_),
                    s.*(&Access::b_schur_));
  }
};

namespace block_solver {

using Solver = RemoteObject<PlainBlockSolver>;

struct BuildStructure {
  static constexpr char kName[] = "BuildStructure";
  static void Run(Solver solver) { solver.object->SetOrdering(); }  // calls it
};
struct BuildSystem {
  static constexpr char kName[] = "BuildSystem";
  static void Run(Solver solver) { solver.object->BuildSystem(); }
};
struct Solve {
  static constexpr char kName[] = "Solve";
  static bool Run(Solver solver, Damping damping, double lambda, VecX* delta_x) {
    solver.object->SetDamping(damping);
    return solver.object->Solve(lambda, delta_x);
  }
};

/// A PlainBlockSolver whose three graded functions run in the worker.
class RemoteBlockSolver : public PlainBlockSolver {
 public:
  explicit RemoteBlockSolver(Graph* graph) : PlainBlockSolver(graph), remote_{NewHandle(), &Scene::Of(graph), this} {}

  void BuildStructure() override {
    MakeHessianBlocks();
    Ask<block_solver::BuildStructure>(remote_);
    CheckBlocks();
  }
  void BuildSystem() override {
    Ask<block_solver::BuildSystem>(remote_);
    CheckBlocks();
  }
  bool Solve(double lambda, VecX* delta_x) override {
    const bool solved = Ask<block_solver::Solve>(remote_, GetDamping(), lambda, delta_x);
    CheckBlocks();
    return solved;
  }

  // The algorithms, unlike the tests, do not look at sizes.
  void MakeHessian() override {
    BuildSystem();
    if (b_.size() != Size()) throw WireError("b has another size");
  }
  bool SolveLinearSystem(double lambda, VecX* delta_x) override {
    return Solve(lambda, delta_x) && delta_x->size() == Size();
  }

 private:
  // Only blocks (i, j) of vertices i and j, and of their size: the judge's own code relies on it.
  void CheckBlocks() const {
    CheckBlocks("H_pp", H_pp_, ordering_.poses, ordering_.poses);
    CheckBlocks("H_pl", H_pl_, ordering_.poses, ordering_.landmarks);
    CheckBlocks("H_ll", H_ll_, ordering_.landmarks, ordering_.landmarks);
    CheckBlocks("S", S_, ordering_.poses, ordering_.poses);
  }
  static void CheckBlocks(const std::string& name, const SparseBlocks& blocks, const VertexList& rows,
                          const VertexList& columns) {
    for (const auto& [place, block] : blocks.All()) {
      const auto i = static_cast<size_t>(place.first), j = static_cast<size_t>(place.second);
      if (i < rows.size() && j < columns.size() && block.rows() == rows[i]->LocalDimension() &&
          block.cols() == columns[j]->LocalDimension()) {
        continue;
      }
      throw WireError(name + " has a block (" + std::to_string(place.first) + ", " + std::to_string(place.second) +
                      ") of size " + std::to_string(block.rows()) + "×" + std::to_string(block.cols()));
    }
  }

  Solver remote_;
};

inline void Remote(Submission* s) { s->make_block_solver = &Make<PlainBlockSolver, RemoteBlockSolver>; }
inline void Serve() { HandleAll<BuildStructure, BuildSystem, Solve>(); }

}  // namespace block_solver
}  // namespace ch5::homework
