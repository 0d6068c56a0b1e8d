#pragma once
/// What an estimate drifts by, without an alignment of the whole.

#include <limits>
#include <optional>
#include <vector>

#include "ch5_backend/types/recording.h"

namespace ch5 {

struct RelativeError {
  double position_rmse = 0.0;  ///< RPE: of the motion over an interval, position and yaw agreeing at its beginning [m]
  double path = 0.0;           ///< length of the truth's path over the compared states, the estimate's in its gaps [m]
  double end = 0.0;            ///< distance of the ends when position and yaw agree at the beginning [m]

  /// `end` in percent of the path; NaN at rest, where less than a centimeter of it is the truth's own rounding and noise.
  double DriftPercent() const { return path > 0.01 ? 100.0 * end / path : std::numeric_limits<double>::quiet_NaN(); }
};

/// Compares each estimate with the truth interpolated at its time, as CompareTrajectories does.
/// @param seconds  the interval of the RPE [s]; where the truth has a gap, it may be up to twice as long
/// @return nullopt with fewer than two states to compare, or none `seconds` apart
/// Source: Sturm et al., "A benchmark for the evaluation of RGB-D SLAM systems", IROS 2012, §IV; the alignment in
/// position and yaw is that of Zhang & Scaramuzza, IROS 2018, §IV.
std::optional<RelativeError> CompareMotions(const std::vector<StampedState>& estimate,
                                            const std::vector<StampedState>& truth, double seconds = 1.0);

/// What the errors are after pieces of the path of one length, from every state on: each piece is laid upon the truth, in
/// position and yaw, at its beginning, and compared at its end.
struct LengthErrors {
  double share = 0.0, length = 0.0;   ///< of the truth's path [1], [m]
  std::vector<double> position, yaw;  ///< one for each piece, ascending [m], [rad]
};

/// @param segments  whose world frames have nothing to do with each other, so that no piece spans two of them
/// @param shares    of the truth's path along all segments
/// @return          one for each share, without errors where no segment is so long; none if nothing can be compared
/// Source: Zhang & Scaramuzza, IROS 2018, §V.B; Geiger, Lenz, Urtasun, CVPR 2012.
std::vector<LengthErrors> ErrorsOverLengths(const std::vector<std::vector<StampedState>>& segments,
                                            const std::vector<StampedState>& truth, const std::vector<double>& shares);

/// @param sorted  ascending;  @param q  0 … 1;  @return NaN if there is none
double QuantileOfSorted(const std::vector<double>& sorted, double q);

}  // namespace ch5
