#include <Eigen/Eigenvalues>

#include "ch5_backend/linear/reduced_solver.h"

namespace ch5 {
namespace {

class PseudoInverse : public ReducedSolver {
 public:
  explicit PseudoInverse(int nullity) : nullity_(nullity) {}

  void Prepare(const SymmetricBlockMatrix& S) override { A_.resize(S.Size(), S.Size()); }

  // x = Σ v_k v_kᵀb/λ_k over all but the `nullity` smallest λ_k.
  bool Solve(const SymmetricBlockMatrix& S, const VecX& b, const VecX& /*scale*/, VecX* x) override {
    S.CopyLower(&A_);
    const Eigen::SelfAdjointEigenSolver<MatXX> eigen(A_);  // reads the lower half; eigenvalues ascend
    const Eigen::Index rank = A_.rows() - nullity_;
    if (eigen.info() != Eigen::Success || rank < 0 || !(eigen.eigenvalues().tail(rank).array() > 0.0).all())
      return false;
    const auto vectors = eigen.eigenvectors().rightCols(rank);
    *x = vectors * (vectors.transpose() * b).cwiseQuotient(eigen.eigenvalues().tail(rank));
    return x->allFinite();
  }

 private:
  int nullity_;
  MatXX A_;
};

}  // namespace

std::unique_ptr<ReducedSolver> MakePseudoInverse(int nullity) { return std::make_unique<PseudoInverse>(nullity); }

}  // namespace ch5
