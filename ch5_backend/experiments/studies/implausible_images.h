#pragma once
/// Images and tracks that a camera cannot have seen.

#include "ch5_backend/experiments/studies/odometry_study.h"

namespace ch5 {

/// Leaves out images that repeat the one before under a new stamp, as a camera that stalls sends them: no track moves, and then
/// all do at once. Says so.
/// @param strict  refuses them
/// @throws std::invalid_argument if so
RecordingWarnings CheckImages(bool strict, Recording* recording);

/// Leaves out points that lie apart from their track for an image or two, false matches, and gives a track a new id from where it
/// goes on with another point, as of a tracker that uses ids again. Names either if they are not few; few stay. Drops a second
/// camera that sees nothing at all, and says so.
/// @throws std::invalid_argument with `strict`, instead
RecordingWarnings CheckTracks(bool strict, Recording* recording);

}  // namespace ch5
