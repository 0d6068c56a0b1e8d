/// Edges that are given by their formulas: dual numbers, automatic differentiation, and the check of Jacobians.
#include "ch5_backend/graph/auto_diff_edge.h"

#include <gtest/gtest.h>

#include "ch5_backend/math/transform.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/bal/edge_bal.h"
#include "ch5_backend/types/plus_jacobian.h"
#include "ch5_backend/types/pose_graph/edge_between.h"
#include "tests/derivatives.h"

namespace ch5 {
namespace {

TEST(Dual, EachFunctionHasItsDerivative) {
  using D = Dual<2>;
  const auto at = [](auto x, auto y) {
    using std::abs, std::atan2, std::cos, std::exp, std::log, std::sin, std::sqrt, std::tan;
    using std::acos, std::asin, std::atan, std::fabs, std::hypot, std::pow, std::tanh;
    return sqrt(x * y) + exp(x / y) - log(y) * sin(x) + cos(2.0 * y) / 3.0 - tan(x - 1.0) + atan2(y, -x) * abs(-y) +
           asin(x) * acos(x * x) + atan(y) - tanh(x) * pow(y, 1.5) + pow(x, 3) / hypot(x, y) - fabs(-x);
  };
  const double x = 0.7, y = 1.9, h = 1e-6;
  const D f = at(D::Unknown(x, 0), D::Unknown(y, 1));
  EXPECT_EQ(f.value, at(x, y));
  EXPECT_NEAR(f.gradient[0], (at(x + h, y) - at(x - h, y)) / (2.0 * h), 1e-8);
  EXPECT_NEAR(f.gradient[1], (at(x, y + h) - at(x, y - h)) / (2.0 * h), 1e-8);
  EXPECT_TRUE(f < f + 1.0 && f >= f && f == f);
}

// EdgeSE3Between and EdgeBAL by their formulas.
class EdgeBetweenByFormula : public AutoDiffEdge<EdgeBetweenByFormula, 6, VertexPose, VertexPose> {
 public:
  EdgeBetweenByFormula(std::shared_ptr<VertexPose> i, std::shared_ptr<VertexPose> j, const Qd& q_z, const Vec3& p_z)
      : AutoDiffEdge(std::move(i), std::move(j)), q_z_(q_z), p_z_(p_z) {}
  template <typename T>
  Eigen::Matrix<T, 6, 1> Evaluate(const Eigen::Matrix<T, 7, 1>& i, const Eigen::Matrix<T, 7, 1>& j) const {
    using Q = Eigen::Quaternion<T>;
    const Q q_i(i[6], i[3], i[4], i[5]), q_j(j[6], j[3], j[4], j[5]), q_z = q_z_.cast<T>();
    const Eigen::Matrix<T, 3, 1> dp = j.template head<3>() - i.template head<3>(), p_z = p_z_.cast<T>();
    const Q q_d = q_z.conjugate() * (q_i.conjugate() * q_j);
    Eigen::Matrix<T, 6, 1> r;
    r << q_z.conjugate() * (q_i.conjugate() * dp - p_z), q_d.vec() * T(q_d.w() < T(0.0) ? -1.0 : 1.0);
    return r;
  }
  std::string TypeInfo() const override { return "EdgeBetweenByFormula"; }

 private:
  Qd q_z_;
  Vec3 p_z_;
};

class EdgeBALByFormula : public AutoDiffEdge<EdgeBALByFormula, 2, VertexCameraBAL, VertexPointXYZ> {
 public:
  EdgeBALByFormula(std::shared_ptr<VertexCameraBAL> camera, std::shared_ptr<VertexPointXYZ> p_W, const Vec2& pixel)
      : AutoDiffEdge(std::move(camera), std::move(p_W)), pixel_(pixel) {}
  template <typename T>
  Eigen::Matrix<T, 2, 1> Evaluate(const Eigen::Matrix<T, 9, 1>& c, const Eigen::Matrix<T, 3, 1>& X) const {
    using std::cos, std::sin, std::sqrt;
    const Eigen::Matrix<T, 3, 1> omega = c.template head<3>();
    const T angle = sqrt(omega.squaredNorm());
    const Eigen::Matrix<T, 3, 1> axis = omega / angle;
    const Eigen::Matrix<T, 3, 1> P = X * cos(angle) + axis.cross(X) * sin(angle) +
                                     axis * (axis.dot(X) * (T(1.0) - cos(angle))) + c.template segment<3>(3);
    const Eigen::Matrix<T, 2, 1> p = -P.template head<2>() / P[2];
    const T n = p.squaredNorm();
    return p * (c[6] * (1.0 + c[7] * n + c[8] * n * n)) - pixel_.cast<T>();
  }
  std::string TypeInfo() const override { return "EdgeBALByFormula"; }

 private:
  Vec2 pixel_;
};

template <typename A, typename B>
void ExpectSame(A&& a, B&& b) {
  a.Linearize();
  b.Linearize();
  const double scale = 1.0 + a.Residual().norm();
  EXPECT_LT((a.Residual() - b.Residual()).norm(), 1e-12 * scale);
  for (size_t i = 0; i < a.Vertices().size(); ++i) {
    EXPECT_LT((a.Jacobian(i) - b.Jacobian(i)).norm(), 1e-11 * (scale + a.Jacobian(i).norm())) << "vertex " << i;
  }
}

TEST(AutoDiffEdge, HasTheJacobiansThatAreWrittenByHand) {
  Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const auto pose = [&] {
      return std::make_shared<VertexPose>(ExpSO3(NormalVector(&random, 1.0)), NormalVector(&random, 2.0));
    };
    const auto i = pose(), j = pose();
    const Qd q_z = ExpSO3(NormalVector(&random, 1.0));
    const Vec3 p_z = NormalVector(&random, 1.0);
    ExpectSame(EdgeBetweenByFormula(i, j, q_z, p_z), EdgeSE3Between(i, j, q_z, p_z));

    Vec9 camera;
    camera << NormalVector(&random, 0.5), NormalVector(&random, 1.0), 500.0, 1e-2, -1e-3;
    const auto c = std::make_shared<VertexCameraBAL>(camera);
    const auto p = std::make_shared<VertexPointXYZ>(Vec3(0, 0, -8) + NormalVector(&random, 1.0));
    ExpectSame(EdgeBALByFormula(c, p, Vec2(3, 4)), EdgeBAL(c, p, Vec2(3, 4)));
  }
}

TEST(AutoDiffEdge, LeavesTheVerticesAloneSoThreadsMayShareThem) {
  const auto i = std::make_shared<VertexPose>(), j = std::make_shared<VertexPose>();
  EdgeBetweenByFormula edge(i, j, Qd::Identity(), Vec3(1, 0, 0));
  edge.Linearize();
  EXPECT_FALSE(edge.HasNumericJacobians());
}

// r = x², whose Jacobian is 2x, times a factor that is right at 1.
class EdgeSquare : public SizedEdge<1, VertexScalar> {
 public:
  EdgeSquare(double x, double factor)
      : SizedEdge(std::make_shared<VertexScalar>(VertexScalar::Estimate(x))), factor_(factor) {}
  void ComputeResidual() override { r_ = GetVertex<0>().GetEstimate().cwiseAbs2(); }
  void ComputeJacobians() override {
    if (factor_ != 0.0) J<0>()[0] = 2.0 * factor_ * GetVertex<0>().GetEstimate()[0];
  }
  std::string TypeInfo() const override { return "EdgeSquare"; }

 private:
  double factor_;
};

TEST(CheckJacobians, FindsAWrongOneAndOneThatIsNotFilled) {
  EdgeSquare right(3.0, 1.0), wrong(3.0, -1.0), forgotten(3.0, 0.0);
  EXPECT_TRUE(CheckJacobians(&right)) << CheckJacobians(&right).message;
  EXPECT_EQ(right.Vertices()[0]->Parameters()[0], 3.0) << "the vertex is where it was";
  const JacobianCheck check = CheckJacobians(&wrong);
  EXPECT_FALSE(check);
  EXPECT_NEAR(check.worst, 12.0 / 9.0, 1e-6);
  EXPECT_NE(check.message.find("EdgeSquare, vertex 0"), std::string::npos) << check.message;
  EXPECT_FALSE(CheckJacobians(&forgotten));
}

TEST(Transform, NeighborsCancel) {
  Random random(5);
  const Transform T_W_B{ExpSO3(NormalVector(&random, 1.0)), NormalVector(&random, 2.0)};
  const Transform T_B_C{ExpSO3(NormalVector(&random, 1.0)), NormalVector(&random, 2.0)};
  const Vec3 p_C(1, 2, 3);
  EXPECT_LT((T_W_B * T_B_C * p_C - T_W_B * (T_B_C * p_C)).norm(), 1e-14);
  EXPECT_LT((Inverse(T_B_C) * (Inverse(T_W_B) * (T_W_B * T_B_C * p_C)) - p_C).norm(), 1e-14);
  const Transform none = T_W_B * Inverse(T_W_B);
  EXPECT_LT(none.p.norm() + none.q.angularDistance(Qd::Identity()), 1e-14);
}

}  // namespace
}  // namespace ch5
