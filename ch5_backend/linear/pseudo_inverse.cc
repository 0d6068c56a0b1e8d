#include <stdexcept>

#include "ch5_backend/linear/reduced_solver.h"
#include "ch5_backend/math/psd.h"

namespace ch5 {

namespace {

class PseudoInverseSolver : public ReducedSolver {
 public:
  explicit PseudoInverseSolver(int nullity) : nullity_(nullity) {}

  void Prepare(const SymmetricBlockMatrix& S, ThreadPool* /*pool*/) override { A_.resize(S.Size(), S.Size()); }
  bool Solve(const SymmetricBlockMatrix& S, const VecX& b, const VecX& /*scale*/, VecX* x) override {
    S.CopyLower(&A_);
    try {
      *x = PseudoInversePsd(A_.selfadjointView<Eigen::Lower>(), nullity_) * b;
    } catch (const std::invalid_argument&) {
      return false;
    }
    return x->allFinite();
  }

 private:
  int nullity_;
  MatXX A_;
};

}  // namespace

std::unique_ptr<ReducedSolver> MakePseudoInverse(int nullity) { return std::make_unique<PseudoInverseSolver>(nullity); }

}  // namespace ch5
