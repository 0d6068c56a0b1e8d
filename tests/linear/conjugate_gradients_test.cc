#include "ch5_backend/linear/conjugate_gradients.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/linear/block_matrices.h"

namespace ch5::test {
namespace {

// A x = b with dense A and M⁻¹, counting the products.
struct System {
  MatXX A, M_inverse;
  VecX b;
  int products = 0;

  auto Multiply() {
    return [this](const VecX& v, VecX* Av) {
      *Av = A * v;
      ++products;
    };
  }
  auto Precondition() const {
    return [this](const VecX& r, VecX* z) { *z = M_inverse * r; };
  }
  LinearIterate Start() const {
    LinearIterate iterate;
    iterate.Resize(b.size());
    iterate.StartAtZero(b, Precondition());
    return iterate;
  }
};

System MakeSystem(uint64_t seed) {
  const MatXX A = MakeMatrix(std::vector<int>(8, 3), Chain(8), seed).Dense();
  return {A, A.diagonal().cwiseInverse().asDiagonal(), RandomVector(static_cast<int>(A.rows()), seed + 1)};
}

const auto kNever = [](const LinearIterate&) { return false; };

TEST(ConjugateGradients, KnowTheirResidualAndTheDecreaseOfTheModel) {
  System s = MakeSystem(1);
  LinearIterate iterate = s.Start();
  VecX x = VecX::Zero(s.b.size());
  int asked = 0;
  double before = 0.0;
  const auto check = [&](const LinearIterate& it) {
    const double Q = s.b.dot(x) - 0.5 * x.dot(s.A * x);
    EXPECT_LT((it.r - (s.b - s.A * x)).norm(), 1e-13 * s.b.norm());
    EXPECT_LT((it.z - s.M_inverse * it.r).norm(), 1e-14 * s.b.norm());
    EXPECT_NEAR(it.rMr, it.r.dot(it.z), 1e-14 * it.rMr);
    EXPECT_NEAR(it.decrease, Q, 1e-13 * Q);
    EXPECT_EQ(it.decrease_before, before);
    EXPECT_GT(it.decrease, before) << "each iterate is better than the one before";
    EXPECT_EQ(it.count, ++asked);
    before = it.decrease;
    return it.count == 5;
  };
  EXPECT_TRUE(ConjugateGradients(s.Multiply(), s.Precondition(), check, 100, &iterate, &x));
  EXPECT_EQ(asked, 5) << "the stop rule stops them";
  EXPECT_EQ(s.products, 5);
}

// In exact arithmetic k different eigenvalues of M⁻¹A take k iterations.
TEST(ConjugateGradients, NeedAsManyIterationsAsThereAreEigenvalues) {
  System s = MakeSystem(2);
  const VecX root = VecX::NullaryExpr(24, [](Eigen::Index i) { return i < 10 ? 1.0 : i < 20 ? 3.0 : 10.0; });
  const MatXX Q = MatXX(s.A.householderQr().householderQ());
  for (const int eigenvalues : {1, 3}) {
    s.A = Q * root.asDiagonal() * Q.transpose();
    s.M_inverse = eigenvalues == 1 ? MatXX(s.A.inverse()) : MatXX::Identity(24, 24);
    LinearIterate iterate = s.Start();
    VecX x = VecX::Zero(24);
    EXPECT_TRUE(ConjugateGradients(s.Multiply(), s.Precondition(), kNever, eigenvalues, &iterate, &x));
    EXPECT_LT((s.A * x - s.b).norm(), 1e-13 * s.b.norm()) << eigenvalues;
  }
}

TEST(ConjugateGradients, ZeroNeedsNoIteration) {
  System s = MakeSystem(4);
  s.b.setZero();
  LinearIterate iterate = s.Start();
  VecX x = VecX::Zero(s.b.size());
  EXPECT_TRUE(ConjugateGradients(s.Multiply(), s.Precondition(), kNever, 100, &iterate, &x));
  EXPECT_EQ(x, VecX::Zero(s.b.size()));
  EXPECT_EQ(s.products, 0);
}

TEST(ConjugateGradients, SeeThatAMatrixIsIndefinite) {
  System s = MakeSystem(5);
  s.A(4, 4) = -50.0;
  LinearIterate iterate = s.Start();
  VecX x = VecX::Zero(s.b.size());
  EXPECT_FALSE(ConjugateGradients(s.Multiply(), s.Precondition(), kNever, 100, &iterate, &x));
}

}  // namespace
}  // namespace ch5::test
