#pragma once
/// NEES on a recording, whose truth has a world frame of its own.
///
/// Where W begins and which way its x axis points, no measurement tells: position and yaw, four numbers, are the gauge. A
/// covariance of a pose in W says nothing of them, and an alignment with the truth would take them from the errors that are
/// to be judged. So what is compared does not depend on W, the motion of the newest frame against the oldest:
///
///   T_0n = T_W_0⁻¹ T_W_n = (R, p),   P = J Σ Jᵀ
///   δp = R₀ᵀ(δpₙ − δp₀) + [p]× δθ₀,   δθ = δθₙ − Rᵀ δθ₀
///
/// Σ is the covariance of both poses, all else eliminated. J N = 0 for the gauge's directions N, so P is the same whatever
/// holds the gauge in Σ. All 6 degrees of freedom can be observed; roll and pitch alone are not judged. Windows overlap, so
/// their mean is no mean of independent runs, and χ²'s band for it (nees.h) is too narrow.

#include <memory>
#include <vector>

#include "ch5_backend/evaluate/nees.h"
#include "ch5_backend/experiments/studies/window/wrapped_policy.h"
#include "ch5_backend/types/recording.h"

namespace ch5 {

/// The motion across one window.
struct ComparedMotion {
  double t;  ///< of the newest frame [s]
  PoseConsistency pose;
  Vec6 variances;  ///< claimed of [δp, δθ] [m², rad²]
};

/// Of the windows of a run.
struct MotionNees {
  Mat66 truth = Mat66::Zero();  ///< covariance of the truth's own motion, in T_0n's increment
  std::vector<ComparedMotion> motions;
  double yaw_leak = 0.0;  ///< what the priors claim to know of yaw, its absolute value [rad⁻²]
  int priors = 0;
  double seconds = 0.0;  ///< spent on this

  double Mean() const;   ///< NaN without a window
  Vec2 Errors() const;   ///< root mean squares of position [m] and rotation [rad]
  Vec2 Claimed() const;  ///< σ of both, averaged alike

  /// Compares the motion across the window with the truth; nothing where there is no truth at both ends.
  /// @param window  solved, not yet slid
  void Compare(const std::vector<StampedState>& recorded, const Window& window);
};

/// The policy, whose every `every`-th window is compared before it slides, once one has.
/// @param recorded, found  must outlive it
std::unique_ptr<WindowPolicy> ComparedBeforeSlides(std::unique_ptr<WindowPolicy> policy,
                                                   const std::vector<StampedState>& recorded, int every,
                                                   MotionNees* found);

}  // namespace ch5
