#include "ch5_backend/window/live_estimator.h"

#include <algorithm>
#include <stdexcept>

#include "ch5_backend/window/prediction.h"

namespace ch5 {

LiveEstimator::LiveEstimator(const EstimatorOptions& options, std::unique_ptr<WindowPolicy> policy, Callback callback)
    : estimator_(options, std::move(policy)), callback_(std::move(callback)), time_offset_(options.time_offset) {
  thread_ = std::thread([this] { Run(); });
}

LiveEstimator::~LiveEstimator() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void LiveEstimator::AddImu(const ImuMeasurement& measurement) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    RethrowError();
    CheckMeasurement(measurement, recent_);
    measurements_.push_back(measurement);
    recent_.push_back(measurement);
  }
  changed_.notify_all();
}

void LiveEstimator::AddFrame(Image image) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    RethrowError();
    CheckImage(image, last_image_);
    last_image_ = image.t;
    images_.push_back(std::move(image));
  }
  changed_.notify_all();
}

void LiveEstimator::Finish() {
  if (std::this_thread::get_id() == thread_.get_id()) {
    throw std::logic_error("LiveEstimator: the callback calls Finish, which would wait for the callback's own end");
  }
  std::unique_lock<std::mutex> lock(mutex_);
  finishing_ = true;
  changed_.notify_all();
  changed_.wait(lock, [this] { return error_ || (images_.empty() && !working_); });
  finishing_ = false;
  RethrowError();
}

std::optional<StampedState> LiveEstimator::PredictAt(double t) const {
  std::unique_lock<std::mutex> lock(mutex_);
  const std::optional<StampedState> newest = newest_;
  const std::vector<ImuMeasurement> recent = recent_;
  lock.unlock();
  const EstimatorOptions& options = estimator_.Options();
  return newest ? ch5::PredictAt(*newest, recent, t, options.calibration, options.max_imu_gap) : std::nullopt;
}

bool LiveEstimator::IsReady(const Image& image) const {
  constexpr double kPatience = 10.0;
  return finishing_ || last_image_ - image.t > kPatience ||
         std::max(last_taken_, measurements_.empty() ? last_taken_ : measurements_.back().t) >= image.t + time_offset_;
}

bool LiveEstimator::HasWork() const { return !images_.empty() && IsReady(images_.front()); }

// One measurement beyond the image, so that the IMU can be interpolated at its time.
void LiveEstimator::TakeMeasurements(double until, std::vector<ImuMeasurement>* taken) {
  while (!measurements_.empty() && last_taken_ < until) {
    last_taken_ = measurements_.front().t;
    taken->push_back(measurements_.front());
    measurements_.pop_front();
  }
}

void LiveEstimator::RethrowError() const {
  if (error_) std::rethrow_exception(error_);
}

void LiveEstimator::Run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stopping_ || HasWork(); });
    if (stopping_) return;
    const Image image = std::move(images_.front());
    images_.pop_front();
    std::vector<ImuMeasurement> taken;
    TakeMeasurements(image.t + time_offset_, &taken);
    working_ = true;
    lock.unlock();
    FrameReport report;
    std::exception_ptr error;
    try {
      for (const ImuMeasurement& measurement : taken) estimator_.AddImu(measurement);
      report = estimator_.AddFrame(image);
      if (callback_) callback_(report, estimator_);
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    working_ = false;
    error_ = error;
    newest_ = error ? std::nullopt : report.state;
    time_offset_ = estimator_.TimeOffset();
    // What is before the newest estimate, but for one measurement, no prediction asks for.
    const double from = newest_ ? newest_->t : last_taken_;
    const auto after = std::find_if(recent_.begin(), recent_.end(), [&](const auto& r) { return r.t > from; });
    if (after - recent_.begin() > 1) recent_.erase(recent_.begin(), after - 1);
    changed_.notify_all();
    if (error) return;
  }
}

}  // namespace ch5
