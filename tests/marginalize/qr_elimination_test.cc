#include "ch5_backend/marginalize/qr_elimination.h"

#include "ch5_backend/marginalize/marginalize.h"
#include "tests/marginalize/small_graphs.h"

namespace ch5 {
namespace {

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
  std::vector<std::shared_ptr<Vertex>> order = truth.kept;
  order.insert(order.end(), drop.begin(), drop.end());
  MatXX H;
  VecX b;
  DenseNormalEquations(edges, order, &H, &b);
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
