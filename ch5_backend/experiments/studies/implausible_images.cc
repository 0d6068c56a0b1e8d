#include "ch5_backend/experiments/studies/implausible_images.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <unordered_map>
#include <utility>

#include "ch5_backend/experiments/studies/recording_warnings.h"
#include "ch5_backend/math/median.h"

namespace ch5 {
namespace {

// The median way of the tracks that both images have, on the normalized plane; 0 if none has moved by more than rounding;
// nullopt if they share too few.
std::optional<double> StepOf(const std::vector<TrackedPoint>& before, const std::vector<TrackedPoint>& after) {
  constexpr size_t kFewest = 5;
  constexpr double kRounding = 1e-7;
  std::unordered_map<int, Vec2> places;
  for (const TrackedPoint& track : before) places.emplace(track.id, track.x);
  std::vector<double> ways;
  for (const TrackedPoint& track : after)
    if (const auto place = places.find(track.id); place != places.end())
      ways.push_back((track.x - place->second).norm());
  if (ways.size() < kFewest) return std::nullopt;
  return *std::max_element(ways.begin(), ways.end()) < kRounding ? 0.0 : Median(ways);
}

// A point of a track.
struct Seen {
  size_t image;
  TrackedPoint* point;
  TrackedPoint* second;                                   // the same one in camera 1, if it is seen there
  bool follows = false;                                   // the image before has it too
  Vec3 apart = Vec3::Zero();                              // from there, beyond how the others moved
  double most = std::numeric_limits<double>::infinity();  // of that, where a track goes on
};
using Tracks = std::map<int, std::vector<Seen>>;

Tracks TracksOf(std::vector<Image>* images) {
  constexpr double kTimes = 5.0, kLeast = 0.02;  // of how the others spread about their median; [rad]
  constexpr size_t kFewest = 8;                  // tracks in both images
  Tracks tracks;
  const auto ray = [](const Vec2& x) -> Vec3 { return x.homogeneous().normalized(); };
  for (size_t k = 0; k < images->size(); ++k) {
    Image& image = (*images)[k];
    std::unordered_map<int, TrackedPoint*> seconds;
    for (TrackedPoint& point : image.tracks1) seconds.emplace(point.id, &point);
    std::vector<double> steps[3];
    std::vector<Seen*> moved;
    for (TrackedPoint& point : image.tracks) {
      std::vector<Seen>& track = tracks[point.id];
      const auto second = seconds.find(point.id);
      track.push_back({k, &point, second == seconds.end() ? nullptr : second->second});
      if (track.size() < 2 || track[track.size() - 2].image + 1 != k) continue;
      Seen& seen = track.back();
      seen.follows = true;
      seen.apart = ray(point.x) - ray(track[track.size() - 2].point->x);
      moved.push_back(&seen);
      for (int axis = 0; axis < 3; ++axis) steps[axis].push_back(seen.apart[axis]);
    }
    if (moved.empty()) continue;
    const Vec3 typical(Median(steps[0]), Median(steps[1]), Median(steps[2]));
    std::vector<double> apart;
    for (Seen* seen : moved) apart.push_back((seen->apart -= typical).norm());
    if (moved.size() < kFewest) continue;
    const double most = std::max(kLeast, kTimes * Median(apart));
    for (Seen* seen : moved) seen->most = most;
  }
  return tracks;
}

struct JumpsOfTracks {
  std::vector<Seen*> falses, begins;  // points of no track, and the first ones of another point
};

// A false match comes back; what stays elsewhere is another point.
void FindJumps(std::vector<Seen>* track, JumpsOfTracks* jumps) {
  constexpr size_t kSteady = 3;   // images
  constexpr double kOther = 0.1;  // [rad]
  std::vector<Seen>& seen = *track;
  size_t begin = 0, good = 0;                       // the present point's first image, and its last one so far
  Vec3 away = Vec3::Zero(), before = Vec3::Zero();  // from the last one; of that from the one before it
  const auto leave_out = [&](size_t from, size_t end) {
    for (size_t k = from; k < end; ++k) jumps->falses.push_back(&seen[k]);
  };
  const auto is_small = [](const Seen& one) { return one.apart.norm() <= one.most; };
  const auto take = [&](size_t k) {
    good = k;
    before = std::exchange(away, Vec3::Zero());
  };
  for (size_t k = 1; k < seen.size(); ++k) {
    away += seen[k].apart;
    const size_t first = k + 1 - kSteady;
    if (!seen[k].follows || away.norm() <= seen[k].most) {
      leave_out(good + 1, k);
      if (!seen[k].follows) begin = k;
      take(k);
    } else if (first > good && first < k && std::all_of(&seen[first + 1], &seen[k] + 1, is_small)) {
      const bool is_elsewhere = away.norm() > kOther, returns = (before + away).norm() <= kOther;
      if (is_elsewhere) leave_out(returns ? good : good + 1, first);
      if (is_elsewhere && !returns) {
        good + 1 - begin < kSteady ? leave_out(begin, good + 1) : jumps->begins.push_back(&seen[first]);
        begin = first;
      }
      take(k);
    }
  }
  leave_out(good + 1, seen.size());
}

// Tracks that stay where they are in the image while the camera turns and the others move: dirt on the lens, the vehicle's own
// hood, or text. A point of the scene does so only on the axis of the turn.
std::vector<Seen*> FindFixed(const Recording& recording, Tracks* tracks) {
  constexpr double kStill = 1.5;   // RMS from a track's mean [px]
  constexpr double kTurn = 0.1;    // of the camera, and what the others move by [rad]
  constexpr size_t kFewest = 5;    // images
  constexpr double kShare = 0.03;  // of the tracks that last for such a turn; none where all is in order
  std::vector<Qd> attitude;
  std::vector<double> way = {0.0};  // of the median track, as far as it goes in one direction or another
  auto m = recording.imu.begin();
  Qd q = Qd::Identity();
  for (const Image& image : recording.images) {
    for (; m + 1 < recording.imu.end() && m->t < image.t; ++m) q = q * ExpSO3(((m + 1)->t - m->t) * m->gyroscope);
    if (!attitude.empty())
      way.push_back(way.back() + StepOf(recording.images[attitude.size() - 1].tracks, image.tracks).value_or(0.0));
    attitude.push_back(q);
  }
  std::vector<Seen*> fixed;
  double turned = 0.0, still = 0.0;
  for (auto& [id, track] : *tracks) {
    if (track.size() < kFewest) continue;
    const size_t first = track.front().image, last = track.back().image;
    double turn = 0.0, squares = 0.0;
    Vec2 mean = Vec2::Zero();
    for (const Seen& seen : track) {
      turn = std::max(turn, attitude[first].angularDistance(attitude[seen.image]));
      mean += seen.point->x / static_cast<double>(track.size());
    }
    for (const Seen& seen : track) squares += (seen.point->x - mean).squaredNorm() / static_cast<double>(track.size());
    const bool is_still = std::sqrt(squares) * recording.calibration.FocalLength() < kStill;
    if (turn > kTurn) turned += 1.0, still += is_still ? 1.0 : 0.0;
    if (is_still && way[last] - way[first] > kTurn)
      for (Seen& seen : track) fixed.push_back(&seen);
  }
  return still > kShare * turned ? fixed : std::vector<Seen*>();
}

JumpsOfTracks FindJumps(Tracks* tracks) {
  JumpsOfTracks jumps;
  for (auto& [id, track] : *tracks) FindJumps(&track, &jumps);
  return jumps;
}

// From each of these points on a track has an id of its own.
void Renumber(Tracks* tracks, const std::vector<Seen*>& begins) {
  const std::set<Seen*> new_from(begins.begin(), begins.end());
  int next = tracks->empty() ? 0 : tracks->rbegin()->first;
  for (auto& [id, track] : *tracks) {
    int now = id;
    for (Seen& one : track) {
      if (new_from.count(&one) > 0) now = ++next;
      one.point->id = now;
      if (one.second) one.second->id = now;
    }
  }
}

// A second camera that sees nothing in any image, as where its tracks' file was forgotten: then there is but one.
void CheckSecondCamera(bool strict, Recording* recording, RecordingWarnings* warnings) {
  const std::vector<Image>& images = recording->images;
  const auto is_seen = [](const Image& image) { return !image.tracks1.empty(); };
  if (!recording->calibration.camera1 || images.empty() || std::any_of(images.begin(), images.end(), is_seen)) return;
  const std::string words = Join("camera1 of the calibration sees no point in any of ", images.size(),
                                 " images; only the other camera is used");
  if (strict) throw std::invalid_argument(words);
  recording->calibration.camera1.reset();
  warnings->push_back({"second_camera_unseen", static_cast<double>(images.size()), kNoNumber, words});
}

}  // namespace

RecordingWarnings CheckImages(bool strict, Recording* recording) {
  constexpr double kJump = 0.5,
                   kSmall = 0.1;  // of the smallest tenth of steps: after a rest without noise, the first is less
  std::vector<Image>& images = recording->images;
  std::vector<std::optional<double>> steps = {std::nullopt};
  std::vector<double> moved;
  for (size_t k = 1; k < images.size(); ++k) {
    steps.push_back(StepOf(images[k - 1].tracks, images[k].tracks));
    if (steps.back().value_or(0.0) > 0.0) moved.push_back(*steps.back());
  }
  const auto is_copy = [&](size_t k) { return k < steps.size() && steps[k] == 0.0; };
  std::vector<size_t> copies;
  for (size_t first = 1, end = 1; first < images.size(); first = end + 1) {
    for (end = first; is_copy(end);) ++end;
    if (end == first || end == images.size() || steps[end].value_or(1.0) < kJump * Quantile(moved, kSmall)) continue;
    for (size_t k = first; k < end; ++k) copies.push_back(k);
  }
  if (copies.empty()) return {};
  const double t = images[copies.front()].t;
  const std::string words = Join("images left out: ", copies.size(),
                                 "; each repeats the one before under a new stamp; the first: at ", t, " s");
  if (strict) throw std::invalid_argument(words);
  for (auto k = copies.rbegin(); k != copies.rend(); ++k)
    images.erase(images.begin() + static_cast<std::ptrdiff_t>(*k));
  return {{"images_repeated", static_cast<double>(copies.size()), t, words, "", t}};
}

RecordingWarnings CheckTracks(bool strict, Recording* recording) {
  constexpr double kShareOfPoints = 0.05;  // 0.007 where all is in order
  constexpr double kShareOfTracks = 0.2;   // 0.04
  std::vector<Image>& images = recording->images;
  Tracks tracks = TracksOf(&images);
  size_t points = 0;
  for (const auto& [id, track] : tracks) points += track.size();
  JumpsOfTracks jumps = FindJumps(&tracks);
  RecordingWarnings warnings;
  const auto warn = [&](const char* name, const std::string& what, size_t all, const std::string& then, double share,
                        std::vector<Seen*>* some) {
    if (static_cast<double>(some->size()) < std::max(1.0, share * static_cast<double>(all))) return some->clear();
    const Seen& first =
        **std::min_element(some->begin(), some->end(), [](auto* x, auto* y) { return x->image < y->image; });
    const double t = images[first.image].t;
    const std::string words = Join(what, ": ", some->size(), " of ", all, "; ", then, "; the first: track ",
                                   first.point->id, " at ", t, " s");
    if (strict) throw std::invalid_argument(words);
    warnings.push_back({name, static_cast<double>(some->size()), static_cast<double>(all), words, "", t});
  };
  CheckSecondCamera(strict, recording, &warnings);
  std::vector<Seen*> fixed = FindFixed(*recording, &tracks);
  warn("fixed_points", "points left out", points, "they stay where they are in the image while the camera turns", 0.0,
       &fixed);
  warn("false_matches", "points left out", points, "each lies apart from its track", kShareOfPoints, &jumps.falses);
  warn("ids_reused", "tracks whose id goes on with another point", tracks.size(), "each becomes two", kShareOfTracks,
       &jumps.begins);
  Renumber(&tracks, jumps.begins);
  std::vector<std::set<int>> out(images.size());
  for (const std::vector<Seen*>* some : {&fixed, &jumps.falses})
    for (const Seen* one : *some) out[one->image].insert(one->point->id);
  for (size_t k = 0; k < images.size(); ++k) {
    for (std::vector<TrackedPoint>* seen : {&images[k].tracks, &images[k].tracks1}) {
      const auto is_out = [&](const TrackedPoint& point) { return out[k].count(point.id) > 0; };
      seen->erase(std::remove_if(seen->begin(), seen->end(), is_out), seen->end());
    }
  }
  return warnings;
}

}  // namespace ch5
