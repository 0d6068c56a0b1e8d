#pragma once
/// The chapter's studies without parameters: each writes its tables into the folder `csv`.

#include <filesystem>
#include <functional>

namespace ch5 {

/// Bundle adjustment of the course's scene and of a larger one: how it converges, what it finds, what H looks like. Writes
/// mono_ba_….csv (summary, trace, frames, points, iterations), hessian.csv, spectrum.csv, and hessian_….csv (vertices,
/// edges, blocks).
/// @param progress  called with the fraction done;  @throws WriteError
void RunMonoBaStudy(const std::filesystem::path& csv, const std::function<void(double)>& progress);

/// Stage 2 as pictures: the slides' chain of three scalars, and what marginalizing fills in on a real scene. Writes
/// marginalize_chain.csv (before, moved, after), marginalize_scene.csv and marginalize_fill.csv: a scene of
/// 5 frames × 12 points loses its landmarks, then frame 0; or frame 0 at once, which couples every landmark.
/// @throws WriteError
void RunMarginalizeStudy(const std::filesystem::path& csv);

/// The two window policies side by side: what each of them takes out of one and the same window, and then frame by frame.
/// Writes these tables of a simulated flight with few tracks, and its film (window/film.h); all or none:
///
///   slide_vertices      each vertex of one window of eight frames, and whether a policy's slide marginalizes it
///   slide_observations  each observation of that window: prior (taken into it), again (taken, and used again), lost, stays
///   slide_matrices      H of that window, and the prior's after the slide
///   slide_priors        the prior before and after: size, rank, dimension of the null space, information on position, yaw
///   slide_frames        the frames of each policy's own window after each image, and what they still have
/// @throws WriteError
void RunSlideStudy(const std::filesystem::path& csv);

/// A flight whose IMU is silent for two seconds: positions and errors of the segments before and after, and the truth's. Writes
/// restart.csv.  @throws WriteError
void RunRestartStudy(const std::filesystem::path& csv);

}  // namespace ch5
