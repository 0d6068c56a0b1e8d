#pragma once
/// The two policies side by side: what each of them takes out of one and the same window, and then frame by frame.

#include <filesystem>

namespace ch5 {

/// Writes five tables of a simulated flight with few tracks; all or none:
///
///   slide_vertices      each vertex of one window of eight frames, and whether a policy's slide marginalizes it
///   slide_observations  each observation of that window: prior (taken into it), again (taken, and used again), lost, stays
///   slide_matrices      H of that window, and the prior's after the slide
///   slide_priors        the prior before and after: size, rank, dimension of the null space, information on position, yaw
///   slide_frames        the frames of each policy's own window after each image, and what they still have
/// @throws WriteError
void RunSlideStudy(const std::filesystem::path& csv);

}  // namespace ch5
