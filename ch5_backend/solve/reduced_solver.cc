#include "ch5_backend/solve/reduced_solver.h"

#include <Eigen/Cholesky>
#include <limits>

namespace ch5 {
namespace {

class DenseCholesky : public ReducedSolver {
 public:
  void Prepare(const SymmetricBlockMatrix& S) override { A_.resize(S.Size(), S.Size()); }

  bool Solve(const SymmetricBlockMatrix& S, const VecX& b, const VecX& scale, VecX* x) override {
    S.CopyLower(&A_);
    const Eigen::LLT<Eigen::Ref<MatXX>> llt(A_);  // in place
    if (llt.info() != Eigen::Success) return false;
    const double rounding = 8.0 * static_cast<double>(A_.rows()) * std::numeric_limits<double>::epsilon();
    for (int i = 0; i < A_.rows(); ++i) {
      if (!(A_(i, i) * A_(i, i) > rounding * scale[i])) return false;
    }
    *x = b;
    llt.solveInPlace(*x);
    return x->allFinite();
  }

 private:
  MatXX A_;
};

class BlockPcg : public ReducedSolver {
 public:
  BlockPcg(int max_iterations, double tolerance) : max_iterations_(max_iterations), tolerance_(tolerance) {}

  void Prepare(const SymmetricBlockMatrix& S) override {
    for (VecX* v : {&r_, &z_, &p_, &Ap_}) v->resize(S.Size());
    factors_.clear();
    for (int j = 0; j < S.NumColumns(); ++j) factors_.emplace_back(S.Dim(j));
  }

  bool Solve(const SymmetricBlockMatrix& S, const VecX& b, const VecX&, VecX* x) override {
    if (!Factorize(S)) return false;
    x->setZero(b.size());
    r_ = b;
    Precondition(S);
    p_ = z_;
    double rz = r_.dot(z_);
    const double goal = tolerance_ * b.norm();
    for (int i = 0; i < max_iterations_ && r_.norm() > goal; ++i) {
      S.Multiply(p_.data(), Ap_.data());
      const double curvature = p_.dot(Ap_);
      if (!(curvature > 0.0)) return false;
      *x += (rz / curvature) * p_;
      r_ -= (rz / curvature) * Ap_;
      Precondition(S);
      const double rz_new = r_.dot(z_);
      p_ = z_ + (rz_new / rz) * p_;
      rz = rz_new;
    }
    return x->allFinite();
  }

 private:
  bool Factorize(const SymmetricBlockMatrix& S) {
    for (int j = 0; j < S.NumColumns(); ++j) {
      using Block = Eigen::Map<const MatXX, 0, Eigen::OuterStride<>>;
      factors_[j].compute(
          Block(S.Values(S.ColumnBegin(j)), S.Dim(j), S.Dim(j), Eigen::OuterStride<>(Stride(S.Dim(j)))));
      if (factors_[j].info() != Eigen::Success) return false;
    }
    return true;
  }

  void Precondition(const SymmetricBlockMatrix& S) {
    z_ = r_;
    for (int j = 0; j < S.NumColumns(); ++j) {
      auto z_j = z_.segment(S.Offset(j), S.Dim(j));
      factors_[j].solveInPlace(z_j);
    }
  }

  int max_iterations_;
  double tolerance_;
  std::vector<Eigen::LLT<MatXX>> factors_;
  VecX r_, z_, p_, Ap_;
};

}  // namespace

std::unique_ptr<ReducedSolver> MakeDenseCholesky() { return std::make_unique<DenseCholesky>(); }
std::unique_ptr<ReducedSolver> MakeBlockPcg(int max_iterations, double tolerance) {
  return std::make_unique<BlockPcg>(max_iterations, tolerance);
}

}  // namespace ch5
