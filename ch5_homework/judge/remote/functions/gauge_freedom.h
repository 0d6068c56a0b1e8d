#pragma once
/// gauge_freedom.cc: stage 4.

#include "ch5_homework/judge/remote/remote.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework::gauge_freedom {

struct NullSpace {
  static constexpr char kName[] = "GaugeNullSpace";
  static MatXX Run(Scene& scene, const std::vector<int>& places, GaugeGroup group) {
    return Chosen().gauge_freedom.null_space(At(places, scene.Vertices()), group);
  }
};
struct Projection {
  static constexpr char kName[] = "GaugeProjection";
  static MatXX Run(const MatXX& U, const MatXX& V) { return Chosen().gauge_freedom.projection(U, V); }
};
struct MotionJacobian {
  static constexpr char kName[] = "GaugeMotionJacobian";
  static MatXX Run(Scene& scene, const std::vector<int>& places, double yaw) {
    return Chosen().gauge_freedom.motion_jacobian(At(places, scene.Vertices()), yaw);
  }
};
struct TransformCovariance {
  static constexpr char kName[] = "TransformCovariance";
  static MatXX Run(const MatXX& covariance, const MatXX& motion, const MatXX& Q, const MatXX& Q_C) {
    return Chosen().gauge_freedom.transform_covariance(covariance, motion, Q, Q_C);
  }
};

// The given code makes matrices of the right size; the tests rely on it.
template <typename F>
MatXX OfSize(Eigen::Index rows, Eigen::Index columns, const MatXX& A) {
  if (A.rows() == rows && A.cols() == columns) return A;
  throw WireError(std::string("a matrix of another size from ") + F::kName);
}
template <typename F, typename Argument>
MatXX AskAbout(const VertexList& vertices, Argument argument) {
  Scene& scene = Scene::Of(vertices.at(0).get());
  return Ask<F>(scene, PlacesOf(vertices, scene.Vertices()), argument);
}

inline void Remote(Submission* s) {
  s->gauge_freedom = {
      [](const Vertices& vertices, GaugeGroup group) {
        return OfSize<NullSpace>(TotalLocalDimension(vertices), NumGaugeDirections(group),
                                 AskAbout<NullSpace>(vertices, group));
      },
      [](const MatXX& U, const MatXX& V) { return OfSize<Projection>(U.rows(), U.rows(), Ask<Projection>(U, V)); },
      [](const Vertices& vertices, double yaw) {
        const int size = TotalLocalDimension(vertices);
        return OfSize<MotionJacobian>(size, size, AskAbout<MotionJacobian>(vertices, yaw));
      },
      [](const MatXX& covariance, const MatXX& motion, const MatXX& Q, const MatXX& Q_C) {
        return OfSize<TransformCovariance>(covariance.rows(), covariance.cols(),
                                           Ask<TransformCovariance>(covariance, motion, Q, Q_C));
      }};
}
inline void Serve() { HandleAll<NullSpace, Projection, MotionJacobian, TransformCovariance>(); }

}  // namespace ch5::homework::gauge_freedom
