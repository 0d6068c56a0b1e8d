#pragma once
/// Sliding-window problems as text, "VIOWIN 1": frames, IMU samples, landmarks and a prior, as plain values.
///
/// Conventions: T_W_B with right perturbation [δp, δθ]; an observation's residual is sqrt_information·(prediction −
/// observation) on the normalized plane; the prior's is r + J (x ⊟ x0), with ⊟ as VertexPose::Minus and
/// VertexSpeedBias::Minus have it; the noise is per sample (ImuNoise::continuous = false).

#include <filesystem>
#include <vector>

#include "ch5_backend/files/text_reader.h"
#include "ch5_backend/types/recording.h"

namespace ch5 {

struct WindowDump {
  /// Of the observations.
  enum class Loss { kNone, kHuber, kCauchy };

  /// The measurements between two frames.
  struct ImuInterval {
    int i = 0, j = 0;                             ///< from frame i to frame j
    Vec3 b_a = Vec3::Zero(), b_g = Vec3::Zero();  ///< the biases at which it was integrated
    std::vector<ImuSample> samples;               ///< the first with dt = 0, at frame i
  };

  /// Where a frame sees a landmark.
  struct Observation {
    int frame = 0;
    Vec2 x = Vec2::Zero();  ///< normalized plane
  };

  /// A landmark with its observations.
  struct Landmark {
    int id = 0;
    int host = 0;                     ///< frame of the first observation, which defines the ray
    double inverse_depth = 0.0;       ///< initial estimate, in the host's camera [1/m]
    double true_inverse_depth = 0.0;  ///< not for a solver
    Vec2 x_host = Vec2::Zero();
    std::vector<Observation> observations;  ///< in other frames
  };

  /// Which state a block of the prior is.
  enum class BlockKind { kPose, kSpeedBias, kExtrinsic };

  /// A block of the prior's columns.
  struct PriorBlock {
    BlockKind kind = BlockKind::kPose;
    int frame = 0;  ///< of a pose or speed-bias
    VecX x0;        ///< [p, q_x, q_y, q_z, q_w] or [v, b_a, b_g] at the linearization point
    int LocalDimension() const { return kind == BlockKind::kSpeedBias ? 9 : 6; }
  };

  Vec3 reaction = Vec3(0, 0, 9.81);  ///< G in W: what a resting accelerometer feels [m/s²]
  ImuNoise noise;
  double sqrt_information = 1.0;  ///< of an observation
  Loss loss = Loss::kNone;        ///< of observations only
  double loss_parameter = 0.0;
  Transform T_B_C;
  bool extrinsic_fixed = true;
  std::vector<StampedState> frames;  ///< initial estimates
  std::vector<StampedState> truth;   ///< of the same frames; not for a solver
  std::vector<ImuInterval> imu;
  std::vector<Landmark> landmarks;
  std::vector<PriorBlock> prior_blocks;
  VecX prior_r;                   ///< m×1; m = 0: no prior
  MatXX prior_J;                  ///< m×Σ LocalDimension, in the order of the blocks
  std::vector<int> fixed_frames;  ///< whose poses are constants
};

/// @throws FileError "file:line: record: what is wrong, got value" for a number that cannot be read, an unknown name,
///         an index out of range, a quaternion that is not of length 1, two blocks of a prior for the same state, a
///         prior on speed and biases without an IMU, a time that does not fit into 64 bits of nanoseconds, or a file
///         that is shorter or longer than it says
WindowDump ReadWindowDump(const std::filesystem::path& path);

}  // namespace ch5
