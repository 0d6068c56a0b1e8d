#include "ch5_backend/experiments/studies/odometry_settings.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>
#include <tuple>

namespace ch5 {
namespace {

constexpr const char* kNames[] = {"policy", "first_estimates", "window", "max_features", "seconds", "pixel_sigma"};
constexpr const char* kFlags[] = {"estimate_extrinsic", "estimate_time_offset", "keep_focal_length", "mono"};

std::string OptionOf(std::string name) {
  std::replace(name.begin(), name.end(), '_', '-');
  return "--" + name;
}

std::optional<double> Parse(const std::string& word) {
  double value = 0.0;
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  return error == std::errc() && stop == end ? std::optional(value) : std::nullopt;
}

// "A:B", either of which may be empty.
std::pair<double, double> Interval(const std::string& word) {
  const size_t colon = word.find(':');
  const std::string first = word.substr(0, colon), last = colon == std::string::npos ? "" : word.substr(colon + 1);
  const std::optional<double> from = first.empty() ? 0.0 : Parse(first);
  const std::optional<double> to = last.empty() ? std::numeric_limits<double>::infinity() : Parse(last);
  if (colon != std::string::npos && from && to && *from >= 0.0 && *from < *to) return {*from, *to};
  throw std::invalid_argument("must be A:B with 0 ≤ A < B, in seconds since the first IMU measurement, got '" + word +
                              "'");
}

}  // namespace

void OdometrySettings::Set(const std::string& name, const std::string& word) {
  const auto flag = [&] { return OneOf<bool>(word, {{"true", true}, {"false", false}}); };
  if (name == "policy") {
    policy = OneOf<std::string>(word, {{"vins", "vins"}, {"okvis", "okvis"}});
  } else if (name == "estimate_extrinsic") {
    estimator.estimate_extrinsic = flag();
  } else if (name == "estimate_time_offset") {
    estimator.estimate_time_offset = flag();
    finds_clock = false;
  } else if (name == "keep_focal_length") {
    corrects_focal_length = !flag();
  } else if (name == "mono") {
    mono = flag();
  } else if (name == "first_estimates") {
    using Constraints = ObservabilityConstraints;
    estimator.observability_constraints = OneOf<Constraints>(
        word,
        {{"none", Constraints::kNone}, {"prior", Constraints::kMarginalizedEdges}, {"full", Constraints::kAllEdges}});
  } else if (name == "window") {
    window = NumberIn(word, 4, 1000);
  } else if (name == "max_features") {
    max_features = NumberIn(word, 8, 100000);
  } else if (name == "pixel_sigma") {
    UsePixelSigma(NumberIn(word, 0.01, 100.0));
    finds_noise = false;
  } else if (name == "seconds") {
    std::tie(from, to) = Interval(word);
  } else {
    throw std::invalid_argument("nothing of this name is known here");
  }
}

void OdometrySettings::UsePixelSigma(double pixels) {
  const EstimatorOptions usual;
  estimator.weights.pixel_sigma = pixels;
  estimator.max_outlier_pixels = usual.max_outlier_pixels * pixels / usual.weights.pixel_sigma;
}

std::vector<std::unique_ptr<WindowPolicy>> OdometrySettings::Policies() const {
  auto policies = AllPolicies(window);
  const auto is_other = [&](const auto& one) { return !policy.empty() && one->Name() != policy; };
  policies.erase(std::remove_if(policies.begin(), policies.end(), is_other), policies.end());
  return policies;
}

void OdometrySettings::Restrict(Recording* recording) const {
  const auto is_outside = [&](const auto& item) { return item.t < from || item.t > to; };
  const auto cut = [&](auto* items) {
    items->erase(std::remove_if(items->begin(), items->end(), is_outside), items->end());
  };
  cut(&recording->imu);
  cut(&recording->images);
  if (recording->imu.size() < 2 || recording->images.size() < 2) {
    const bool is_part = from > 0.0 || std::isfinite(to);
    throw std::invalid_argument(std::string("fewer than two images or IMU measurements") +
                                (is_part ? " lie in the seconds asked for" : ""));
  }
  if (mono) {
    recording->calibration.camera1.reset();
    for (Image& frame : recording->images) frame.tracks1.clear();
  }
  if (max_features == 0) return;
  std::map<int, int> images;  // of each track so far
  for (Image& frame : recording->images) {
    for (const TrackedPoint& point : frame.tracks) ++images[point.id];
    std::stable_sort(frame.tracks.begin(), frame.tracks.end(),
                     [&](const auto& a, const auto& b) { return images[a.id] > images[b.id]; });
    if (frame.tracks.size() > static_cast<size_t>(max_features)) {
      frame.tracks.resize(static_cast<size_t>(max_features));
    }
  }
}

void DeclareOdometryOptions(CommandLine* line, EstimatorWords* given) {
  for (const std::string name : kNames) {
    line->Option(OptionOf(name), [=](const std::string& word) {
      OdometrySettings().Set(name, word);  // refused before the recording is read
      given->push_back({name, word, OptionOf(name)});
    });
  }
  for (const std::string name : kFlags) {
    line->Flag(OptionOf(name), [=] { given->push_back({name, "true", OptionOf(name)}); });
  }
}

OdometrySettings ReadOdometrySettings(const EstimatorWords& of_file, const EstimatorWords& given) {
  OdometrySettings settings;
  for (const EstimatorWords* words : {&of_file, &given}) {
    for (const EstimatorWord& word : *words) {
      try {
        settings.Set(word.name, word.word);
      } catch (const std::invalid_argument& error) {
        const std::string message = word.where + ": " + error.what();
        if (words == &of_file) throw FileError(message);
        throw std::invalid_argument(message);
      }
    }
  }
  return settings;
}

}  // namespace ch5
