/// Stage 7 in the worker.

#include "ch5_homework/judge/remote/members.h"
#include "ch5_homework/judge/remote/remote.h"

namespace ch5::homework {
namespace {

/// A PlainBlockSolver whose three graded functions run in the worker, on a copy of the graph.
class RemoteBlockSolver : public PlainBlockSolver {
 public:
  explicit RemoteBlockSolver(Graph* graph) : PlainBlockSolver(graph), handle_(NewHandle()) {}

  void BuildStructure() override {
    MakeHessianBlocks();
    SolverNumbers numbers;
    Ask("BuildStructure", Arguments(), &numbers);
    Take(numbers);
  }
  void BuildSystem() override {
    SolverNumbers numbers;
    Ask("BuildSystem", Arguments(), &numbers);
    Take(numbers);
  }
  bool Solve(double lambda, VecX* delta_x) override {
    SolverNumbers numbers;
    bool solved;
    Writer arguments = Arguments();
    arguments << GetDamping() << lambda;
    Ask("Solve", arguments, &solved, delta_x, &numbers);
    Take(numbers);
    return solved;
  }

  // The algorithms, unlike the tests, do not look at sizes.
  void MakeHessian() override {
    BuildSystem();
    if (b_.size() != Size()) throw WorkerFailure("GARBAGE in the reply to BuildSystem: b has another size");
  }
  bool SolveLinearSystem(double lambda, VecX* delta_x) override {
    return Solve(lambda, delta_x) && delta_x->size() == Size();
  }

 private:
  Writer Arguments() const { return Pack(handle_, NumbersOf(graph_->Vertices(), graph_->Edges())); }

  void Take(const SolverNumbers& numbers) {
    const auto& poses = ordering_.poses;
    const auto& landmarks = ordering_.landmarks;
    TakeBlocks("H_pp", numbers.H_pp, poses, poses, &H_pp_);
    TakeBlocks("H_pl", numbers.H_pl, poses, landmarks, &H_pl_);
    TakeBlocks("H_ll", numbers.H_ll, landmarks, landmarks, &H_ll_);
    TakeBlocks("S", numbers.S, poses, poses, &S_);
    b_ = numbers.b;
    b_schur_ = numbers.b_schur;
  }

  // Only blocks (i, j) of vertices i and j, and of their size: the judge's own code relies on it.
  static void TakeBlocks(const std::string& name, const Blocks& blocks, const VertexList& rows,
                         const VertexList& columns, SparseBlocks* taken) {
    taken->Clear();
    for (const auto& [place, block] : blocks) {
      const auto i = static_cast<size_t>(place.first), j = static_cast<size_t>(place.second);
      if (i >= rows.size() || j >= columns.size() || block.rows() != rows[i]->LocalDimension() ||
          block.cols() != columns[j]->LocalDimension()) {
        throw WorkerFailure("GARBAGE: " + name + " has a block (" + std::to_string(place.first) + ", " +
                            std::to_string(place.second) + ") of size " + std::to_string(block.rows()) + "×" +
                            std::to_string(block.cols()));
      }
      taken->Add(place.first, place.second, 0, 0);
      (*taken)(place.first, place.second) = block;
    }
  }

  int handle_;
};

[[maybe_unused]] const bool added = [] {
  Linked()->make_block_solver = &MakeBlockSolver<RemoteBlockSolver>;
  return true;
}();

}  // namespace
}  // namespace ch5::homework
