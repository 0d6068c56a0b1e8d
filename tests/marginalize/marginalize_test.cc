#include "ch5_backend/marginalize/marginalize.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "ch5_backend/marginalize/qr_elimination.h"
#include "tests/marginalize/scenes.h"

namespace ch5 {
namespace {

MatXX Schur(const MatXX& H, Eigen::Index n) {
  const Eigen::Index m = H.rows() - n;
  return H.topLeftCorner(n, n) -
         H.topRightCorner(n, m) * H.bottomRightCorner(m, m).inverse() * H.bottomLeftCorner(m, n);
}
VecX SchurB(const MatXX& H, const VecX& b, Eigen::Index n) {
  const Eigen::Index m = H.rows() - n;
  return b.head(n) - H.topRightCorner(n, m) * H.bottomRightCorner(m, m).inverse() * b.tail(m);
}

TEST(Marginalize, EqualsADenseSchurComplement) {
  for (const uint64_t seed : {1u, 2u, 3u}) {
    const SmallWindow window(seed);
    const auto drop = window.Oldest();
    const auto edges = window.EdgesAt(drop);
    const MarginalSystem system = EliminateVertices(edges, drop);
    std::vector<std::shared_ptr<Vertex>> order = system.kept;
    order.insert(order.end(), drop.begin(), drop.end());
    MatXX H;
    VecX b;
    DenseNormalEquations(edges, order, &H, &b);
    // Five orders of magnitude lie between a bias' information and a depth's: 1e-9 of the norm is rounding.
    EXPECT_LT(RelativeError(system.H, Schur(H, system.H.rows())), 1e-9);
    EXPECT_LT(RelativeError(system.b, SchurB(H, b, system.H.rows())), 1e-9);
  }
}

// Landmarks alone, or nothing at all: the dense block that goes is empty.
TEST(Marginalize, DropsLandmarksAloneOrNothing) {
  const SmallWindow window;
  const std::vector<std::shared_ptr<Vertex>> nothing, landmarks(window.landmarks.begin(), window.landmarks.end());
  for (const auto& drop : {nothing, landmarks}) {
    const MarginalSystem system = EliminateVertices(window.graph.Edges(), drop);
    std::vector<std::shared_ptr<Vertex>> order = system.kept;
    order.insert(order.end(), drop.begin(), drop.end());
    MatXX H;
    VecX b;
    DenseNormalEquations(window.graph.Edges(), order, &H, &b);
    EXPECT_LT(RelativeError(system.H, drop.empty() ? H : Schur(H, system.H.rows())), 1e-9);
  }
}

TEST(Marginalize, PriorReproducesTheNormalEquations) {
  const SmallWindow window;
  const auto drop = window.Oldest();
  const MarginalSystem system = EliminateVertices(window.EdgesAt(drop), drop);
  for (const SquareRootForm& form :
       {FactorNormalEquations(system.H, system.b), FactorNormalEquations(system.H, system.b, EigenCut::Okvis()),
        FactorNormalEquations(system.H, system.b, EigenCut::Vins())}) {
    // Directions that rounding decides about, kept or cut, are as large as this.
    EXPECT_LT(RelativeError(form.J.transpose() * form.J, system.H), 1e-8);
    // b lies in the range of H up to what the cut removed.
    EXPECT_LT((form.J.transpose() * form.r0 + system.b).norm(), 1e-6 * system.b.norm());
  }
}

// H of rank 3 in states whose units differ by 1e6: as many rows, and b, which lies in H's range, is kept.
TEST(Marginalize, BothFactorisationsFindTheRank) {
  Random random(11);
  MatXX B(3, 5);
  for (int k = 0; k < B.size(); ++k) B.data()[k] = random.Normal() * std::pow(10.0, k / 3 * 3 - 6);
  const MatXX H = B.transpose() * B;
  const VecX b = B.transpose() * Vec3(1.0, -2.0, 0.5);
  const SquareRootForm triangle = FactorNormalEquations(H, b);
  const SquareRootForm eigen = FactorNormalEquations(H, b, EigenCut::Okvis());
  EXPECT_EQ(triangle.J.rows(), 3);
  EXPECT_EQ(eigen.J.rows(), 3);
  for (const SquareRootForm& form : {triangle, eigen}) {
    EXPECT_LT(RelativeError(form.J.transpose() * form.J, H), 1e-13);
    EXPECT_LT(RelativeError(form.J.transpose() * form.r0, -b), 1e-9);
    EXPECT_NEAR(form.r0.norm(), Vec3(1.0, -2.0, 0.5).norm(), 1e-6);
  }
  EXPECT_EQ(FactorNormalEquations(MatXX(0, 0), VecX(0)).J.size(), 0);
  EXPECT_EQ(FactorNormalEquations(MatXX::Zero(2, 2), VecX::Zero(2)).J.rows(), 0);
}

// The factor is computed panel by panel; pivots and rank take no notice.
TEST(Marginalize, ARankOfSeveralPanelsIsFound) {
  Random random(5);
  MatXX B(30, 40);
  for (int k = 0; k < B.size(); ++k) B.data()[k] = random.Normal();
  const VecX r0 = VecX::LinSpaced(30, -1.0, 1.0);
  const SquareRootForm form = FactorNormalEquations(B.transpose() * B, -B.transpose() * r0);
  EXPECT_EQ(form.J.rows(), 30);
  EXPECT_LT(RelativeError(form.J.transpose() * form.J, B.transpose() * B), 1e-13);
  EXPECT_LT((form.J.transpose() * form.r0 - B.transpose() * r0).norm(), 1e-11);
}

// basalt's test_linearization: QR and Schur give the same H and b.
TEST(Marginalize, QrEqualsSchur) {
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
TEST(Marginalize, QrIsBetterThanSchurInSinglePrecision) {
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
  const Eigen::MatrixXf H_float = H.cast<float>();
  const Eigen::Index n = truth.H.rows(), m = H.rows() - n;
  const Eigen::MatrixXf schur = H_float.topLeftCorner(n, n) - H_float.topRightCorner(n, m) *
                                                                  H_float.bottomRightCorner(m, m).inverse() *
                                                                  H_float.bottomLeftCorner(m, n);
  const double qr_error = RelativeError(qr.J.transpose() * qr.J, truth.H);
  const double schur_error = RelativeError(schur.cast<double>(), truth.H);
  EXPECT_LT(qr_error, 1e-3);
  EXPECT_LT(qr_error, 0.1 * schur_error) << "QR " << qr_error << ", Schur " << schur_error;
  // A prior by QR is positive semi-definite by construction; Schur's in single precision need not be.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXf> eigen(0.5f * (schur + schur.transpose()));
  RecordProperty("schur_smallest_eigenvalue", std::to_string(eigen.eigenvalues()[0]));
}

// basalt's test_qr: a column that repeats another cannot be told from it; QR and Schur agree on what remains.
TEST(Marginalize, QrAndSchurAgreeOnAColumnThatIsRepeated) {
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

// On a linear problem nothing is lost: the kept variables' optimum with the prior is that of the whole batch.
TEST(Marginalize, LinearSmootherEqualsTheBatch) {
  Random random(7);
  const auto matrix = [&](int rows, int cols) {
    MatXX A(rows, cols);
    for (int j = 0; j < cols; ++j) {
      for (int i = 0; i < rows; ++i) A(i, j) = random.Normal();
    }
    return A;
  };
  constexpr int kStates = 30, kLag = 7;  // as in gtsam's testBatchFixedLagSmoother
  std::vector<std::shared_ptr<Vertex>> x;
  std::vector<std::shared_ptr<Edge>> all;
  for (int k = 0; k < kStates; ++k) x.push_back(std::make_shared<VertexVector<3>>(Vec3::Zero()));
  all.push_back(std::make_shared<LinearEdge>(std::vector{x[0]}, std::vector{matrix(3, 3)}, matrix(3, 1)));
  for (int k = 1; k < kStates; ++k) {
    all.push_back(std::make_shared<LinearEdge>(std::vector{x[k - 1], x[k]}, std::vector{matrix(4, 3), matrix(4, 3)},
                                               matrix(4, 1)));
  }
  MatXX H;
  VecX b;
  DenseNormalEquations(all, x, &H, &b);
  const VecX batch = H.partialPivLu().solve(b);

  // The window holds kLag states; the oldest one is marginalised into the prior, which is marginalised in turn.
  std::vector<std::shared_ptr<Edge>> window{all[0]};
  for (int k = 1; k < kStates; ++k) {
    window.push_back(all[k]);
    if (k < kLag) continue;
    const std::shared_ptr<Vertex> oldest = x[k - kLag];
    std::vector<std::shared_ptr<Edge>> at, rest;
    for (const auto& edge : window) {
      const auto& v = edge->Vertices();
      (std::find(v.begin(), v.end(), oldest) == v.end() ? rest : at).push_back(edge);
    }
    rest.push_back(std::make_shared<EdgePrior>(Marginalize(at, {oldest})));
    window = rest;
  }
  const std::vector<std::shared_ptr<Vertex>> kept(x.end() - kLag, x.end());
  DenseNormalEquations(window, kept, &H, &b);
  const VecX smoothed = H.partialPivLu().solve(b);
  EXPECT_LT((smoothed - batch.tail(3 * kLag)).norm(), 1e-9 * batch.norm());
}

// On a nonlinear problem it is so at the linearisation point: one Gauss-Newton step is that of the batch.
TEST(Marginalize, GaussNewtonStepEqualsTheBatchAtTheLinearisationPoint) {
  SmallWindow window;
  window.poses[0]->SetFixed(false);
  window.extrinsic->SetFixed();
  const auto drop = window.Oldest();
  const auto edges = window.EdgesAt(drop);
  Problem batch(&window.graph);
  batch.MakeHessian();
  VecX step;
  ASSERT_TRUE(batch.SolveLinearSystem(0.0, &step));
  std::map<const Vertex*, VecX> expected;
  for (const auto& v : window.graph.Vertices()) {
    if (v->OrderingId() >= 0) expected[v.get()] = step.segment(v->OrderingId(), v->LocalDimension());
  }

  auto prior = std::make_shared<EdgePrior>(Marginalize(edges, drop));
  for (const auto& edge : edges) window.graph.RemoveEdge(edge);
  for (const auto& v : drop) window.graph.RemoveVertex(v);
  window.graph.AddEdge(prior);
  Problem smoother(&window.graph);
  smoother.MakeHessian();
  ASSERT_TRUE(smoother.SolveLinearSystem(0.0, &step));
  for (const auto& v : window.graph.Vertices()) {
    if (v->OrderingId() < 0) continue;
    const VecX ours = step.segment(v->OrderingId(), v->LocalDimension());
    // H's condition number is about 1e10: what two ways to solve can differ by (a prior by QR is as far off).
    EXPECT_LT((ours - expected[v.get()]).norm(), 1e-5 * (0.1 + expected[v.get()].norm())) << v->TypeInfo() << v->Id();
  }
}

// Bᵀ(JᵀJ)B from one product and (JB)ᵀ(JB) from the Jacobians are the same, wherever the states have gone.
TEST(EdgePrior, ProductsAreThoseOfItsJacobians) {
  SmallWindow window;
  const auto drop = window.Oldest();
  EdgePrior prior(Marginalize(window.EdgesAt(drop), drop));
  for (const double step : {0.0, 0.03, 0.3}) {
    int size = 1;
    for (const auto& vertex : prior.Vertices()) {
      vertex->Plus(VecX::LinSpaced(vertex->LocalDimension(), -step, step).eval().data());
      size += vertex->LocalDimension();
    }
    MatXX C(size, size), rows(prior.ResidualDimension(), size);
    ASSERT_TRUE(prior.ProductsInto(C.data()));
    prior.Linearize();
    size = 0;
    for (size_t i = 0; i < prior.Vertices().size(); ++i) {
      const auto J = prior.Jacobian(i);
      rows.middleCols(size, J.cols()) = J;
      size += static_cast<int>(J.cols());
    }
    rows.rightCols<1>() = prior.Residual();
    const MatXX expected = rows.transpose() * rows;
    EXPECT_LT(RelativeError(MatXX(C.selfadjointView<Eigen::Lower>()), expected), 1e-14) << step;
  }
  prior.SetLossFunction(std::make_shared<HuberLoss>(1.0));
  EXPECT_FALSE(prior.ProductsInto(nullptr));
}

TEST(Marginalize, DoesNotDependOnTheOrderOfEdges) {
  const SmallWindow window;
  const auto drop = window.Oldest();
  auto edges = window.EdgesAt(drop);
  const MarginalSystem first = EliminateVertices(edges, drop);
  std::reverse(edges.begin(), edges.end());
  const MarginalSystem second = EliminateVertices(edges, drop);
  EXPECT_EQ(first.kept, second.kept);
  EXPECT_LT(RelativeError(second.H, first.H), 1e-13);
}

TEST(Marginalize, RepeatsToTheBit) {
  const SmallWindow a, b;  // other addresses, same ids
  const Prior first = Marginalize(a.EdgesAt(a.Oldest()), a.Oldest());
  const Prior second = Marginalize(b.EdgesAt(b.Oldest()), b.Oldest());
  EXPECT_EQ(first.J, second.J);
  EXPECT_EQ(first.r0, second.r0);
}

// A landmark seen from one place only leaves its depth unobserved: the pseudo-inverse drops it and nothing is NaN.
TEST(Marginalize, SurvivesAnUnobservedLandmark) {
  auto host = std::make_shared<VertexPose>(), target = std::make_shared<VertexPose>();
  auto landmark = std::make_shared<VertexInverseDepth>(0.2);
  auto edge = std::make_shared<EdgeReprojection>(landmark, host, target, Vec2(0.1, 0.2), Vec2(0.1, 0.2));
  const Prior prior = Marginalize({edge}, {landmark});
  EXPECT_TRUE(prior.J.allFinite());
  EXPECT_TRUE(prior.r0.allFinite());
  EXPECT_EQ(prior.vertices.size(), 2u);
}

TEST(Marginalize, RefusesAnEdgeBetweenTwoDroppedLandmarks) {
  std::vector<std::shared_ptr<Vertex>> points{std::make_shared<VertexPointXYZ>(Vec3::Zero()),
                                              std::make_shared<VertexPointXYZ>(Vec3::Ones())};
  auto edge = std::make_shared<LinearEdge>(points, std::vector<MatXX>(2, MatXX::Identity(3, 3)), VecX::Zero(3));
  EXPECT_THROW(EliminateVertices({edge}, points), std::invalid_argument);
}

}  // namespace
}  // namespace ch5
