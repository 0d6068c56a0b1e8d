#include "ch5_backend/marginalize/square_root.h"

#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/marginalize/qr_elimination.h"
#include "tests/marginalize/small_graphs.h"

namespace ch5 {
namespace {

TEST(SquareRoot, PriorReproducesTheNormalEquations) {
  const SmallWindow window;
  const auto drop = window.Oldest();
  const MarginalSystem system = EliminateVertices(window.EdgesAt(drop), drop);
  for (const SquareRootForm& form : {FactorNormalEquations(system.H, system.b, system.scale),
                                     FactorNormalEquations(system.H, system.b, EigenvalueCutoff::Okvis()),
                                     FactorNormalEquations(system.H, system.b, EigenvalueCutoff::Vins())}) {
    // Directions that rounding decides about, kept or cut, are as large as this.
    EXPECT_LT(RelativeError(form.J.transpose() * form.J, system.H), 1e-8);
    // b lies in the range of H up to what the cut removed.
    EXPECT_LT((form.J.transpose() * form.r0 + system.b).norm(), 1e-6 * system.b.norm());
  }
}

// H of rank 3 in states whose units differ by 1e6: as many rows, and b, which lies in H's range, is kept.
TEST(SquareRoot, BothFactorizationsFindTheRank) {
  Random random(11);
  MatXX B(3, 5);
  for (int k = 0; k < B.size(); ++k) B.data()[k] = random.Normal() * std::pow(10.0, k / 3 * 3 - 6);
  const MatXX H = B.transpose() * B;
  const VecX b = B.transpose() * Vec3(1.0, -2.0, 0.5);
  const SquareRootForm triangle = FactorNormalEquations(H, b, H.diagonal());
  const SquareRootForm eigen = FactorNormalEquations(H, b, EigenvalueCutoff::Okvis());
  EXPECT_EQ(triangle.J.rows(), 3);
  EXPECT_EQ(eigen.J.rows(), 3);
  for (const SquareRootForm& form : {triangle, eigen}) {
    EXPECT_LT(RelativeError(form.J.transpose() * form.J, H), 1e-13);
    EXPECT_LT(RelativeError(form.J.transpose() * form.r0, -b), 1e-9);
    EXPECT_NEAR(form.r0.norm(), Vec3(1.0, -2.0, 0.5).norm(), 1e-6);
  }
  EXPECT_EQ(FactorNormalEquations(MatXX(0, 0), VecX(0), VecX(0)).J.size(), 0);
  EXPECT_EQ(FactorNormalEquations(MatXX::Zero(2, 2), VecX::Zero(2), VecX::Zero(2)).J.rows(), 0);
}

// By hand: beside a diagonal of 1e4, from which an elimination has left it, 1e-12 is rounding.
TEST(SquareRoot, WhatAnEliminationHasLeftOfAZeroIsNoKnowledge) {
  const MatXX H = Vec2(1.0, 1e-12).asDiagonal();
  const VecX b = Vec2(1.0, 1e-13);
  EXPECT_EQ(FactorNormalEquations(H, b, H.diagonal()).J.rows(), 2);
  const SquareRootForm form = FactorNormalEquations(H, b, Vec2(1.0, 1e4));
  EXPECT_EQ(form.J, Eigen::RowVector2d(1.0, 0.0));
  EXPECT_EQ(form.r0, -VecX::Ones(1));
}

// The factor is computed panel by panel; pivots and rank take no notice.
TEST(SquareRoot, ARankOfSeveralPanelsIsFound) {
  Random random(5);
  const MatXX B = NormalMatrix(30, 40, &random);
  const VecX r0 = VecX::LinSpaced(30, -1.0, 1.0);
  const MatXX H = B.transpose() * B;
  const SquareRootForm form = FactorNormalEquations(H, -B.transpose() * r0, H.diagonal());
  EXPECT_EQ(form.J.rows(), 30);
  EXPECT_LT(RelativeError(form.J.transpose() * form.J, B.transpose() * B), 1e-13);
  EXPECT_LT((form.J.transpose() * form.r0 - B.transpose() * r0).norm(), 1e-11);
}

// By hand: of A = diag(4, 0) only the first eigenvalue is above the cutoff.
TEST(SquareRoot, PseudoInverseRootOfASingularMatrixByHand) {
  const MatXX A = Vec2(4.0, 0.0).asDiagonal(), expected = Vec2(0.25, 0.0).asDiagonal();
  const MatXX M = PseudoInverseSquareRoot(A);
  EXPECT_LT((M * M.transpose() - expected).norm(), 1e-15);
  EXPECT_EQ(PseudoInverseSquareRoot(MatXX::Constant(1, 1, 4.0))(0, 0), 0.5);
  EXPECT_EQ(PseudoInverseSquareRoot(MatXX::Zero(1, 1))(0, 0), 0.0);
}

// basalt's test_linearization: QR and Schur give the same H and b.
TEST(QrElimination, QrEqualsSchur) {
  for (const uint64_t seed : {1u, 2u, 3u}) {
    const SmallWindow window(seed);
    const auto drop = window.Oldest();
    const MarginalSystem schur = EliminateVertices(window.EdgesAt(drop), drop);
    const Prior qr = MarginalizeQr<double>(window.EdgesAt(drop), drop);
    ASSERT_EQ(qr.vertices, schur.kept);
    EXPECT_LT(RelativeError(qr.J.transpose() * qr.J, schur.H), 1e-8);
    EXPECT_LT((qr.J.transpose() * qr.r0 + schur.b).norm(), 1e-8 * schur.b.norm());
  }
}

// In single precision QR stays near the truth, while the Schur complement of H loses twice the digits.
TEST(QrElimination, QrIsBetterThanSchurInSinglePrecision) {
  const SmallWindow window;
  const auto drop = window.Oldest();
  const auto edges = window.EdgesAt(drop);
  const MarginalSystem truth = EliminateVertices(edges, drop);
  const Prior qr = MarginalizeQr<float>(edges, drop);
  const MatXX H = DenseNormalEquations(edges, truth.kept, drop).H;
  Eigen::MatrixXf schur = H.cast<float>();
  for (Eigen::Index last = H.rows() - 1; last >= truth.H.rows(); --last) {  // one variable after the other
    const Eigen::VectorXf column = schur.col(last).head(last);
    const float pivot = schur(last, last);
    schur = (schur.topLeftCorner(last, last) - column * column.transpose() / pivot).eval();
  }
  const double qr_error = RelativeError(qr.J.transpose() * qr.J, truth.H);
  const double schur_error = RelativeError(schur.cast<double>(), truth.H);
  EXPECT_LT(qr_error, 1e-3);
  EXPECT_LT(qr_error, 0.1 * schur_error) << "QR " << qr_error << ", Schur " << schur_error;
}

// basalt's test_qr: a column that repeats another cannot be told from it; QR and Schur agree on what remains.
TEST(QrElimination, QrAndSchurAgreeOnAColumnThatIsRepeated) {
  Random random(9);
  std::vector<std::shared_ptr<Vertex>> x;
  for (int k = 0; k < 3; ++k) x.push_back(std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0)));
  std::vector<std::shared_ptr<Edge>> edges;
  for (int e = 0; e < 4; ++e) {
    const MatXX A = MatXX::Constant(1, 1, random.Normal()), B = MatXX::Constant(1, 1, random.Normal());
    edges.push_back(std::make_shared<LinearEdge>(x, std::vector<MatXX>{A, A, B}, VecX::Constant(1, random.Normal())));
  }
  const Prior schur = Marginalize(edges, {x[0], x[1]});
  const Prior qr = MarginalizeQr<double>(edges, {x[0], x[1]});
  EXPECT_LT(RelativeError(qr.J.transpose() * qr.J, schur.J.transpose() * schur.J), 1e-9);
  EXPECT_LT((qr.J.transpose() * qr.r0 - schur.J.transpose() * schur.r0).norm(), 1e-9);
}

}  // namespace
}  // namespace ch5
