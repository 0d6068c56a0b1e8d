#include "ch5_backend/window/live_estimator.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/window/prediction.h"

namespace ch5 {

void LiveOptions::Validate() const {
  CheckOption("LiveOptions::max_lag", max_lag, 0);
  CheckOption("LiveOptions::patience", patience, 0, 86400);
}

LiveEstimator::LiveEstimator(const EstimatorOptions& options, std::unique_ptr<WindowPolicy> policy, Callback callback,
                             const LiveOptions& live)
    : estimator_(options, std::move(policy)),
      callback_(std::move(callback)),
      live_(live),
      time_offset_(options.time_offset) {
  live.Validate();
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
    waits_since_ = Clock::now();
    imu_is_silent_ = false;
  }
  changed_.notify_all();
}

void LiveEstimator::AddFrame(Image image) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    RethrowError();
    CheckImage(image, last_image_);
    last_image_ = image.t;
    if (!answered_) answered_ = image.t;
    if (images_.empty()) waits_since_ = Clock::now();
    images_.push_back(std::move(image));
  }
  changed_.notify_all();
}

void LiveEstimator::Restart() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    RethrowError();
    images_.clear();
    measurements_.clear();
    recent_.clear();
    newest_.reset();
    answered_.reset();
    last_taken_ = last_image_ = -std::numeric_limits<double>::infinity();
    restarting_ = true;
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
  if (!newest) return std::nullopt;
  return ch5::PredictAt(*newest, recent, t, options.calibration, options.max_imu_gap, options.weights.max_imu_seconds);
}

Backlog LiveEstimator::GetBacklog() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return {images_.size(), answered_ ? last_image_ - *answered_ : 0.0, dropped_};
}

bool LiveEstimator::IsReady(const Image& image) const {
  return finishing_ ||
         std::max(last_taken_, measurements_.empty() ? last_taken_ : measurements_.back().t) >= image.t + time_offset_;
}

// Until an image can be answered; @return false if the thread shall end.
bool LiveEstimator::WaitForImage(std::unique_lock<std::mutex>* lock) {
  const auto patience = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(live_.patience));
  while (!stopping_) {
    if (images_.empty()) {
      changed_.wait(*lock);
    } else if (imu_is_silent_ || IsReady(images_.front())) {
      return true;
    } else {
      changed_.wait_until(*lock, waits_since_ + patience);
      imu_is_silent_ = Clock::now() >= waits_since_ + patience;
    }
  }
  return false;
}

void LiveEstimator::DropLateImages() {
  while (last_image_ - images_.front().t > live_.max_lag) {
    images_.pop_front();
    ++dropped_;
  }
}

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

void LiveEstimator::NoteAnswer(double t, const std::optional<StampedState>& state) {
  newest_ = state;
  answered_ = t;
  // What is before the newest estimate, but for one measurement, no prediction asks for.
  const double from = newest_ ? newest_->t : last_taken_;
  const auto after = std::find_if(recent_.begin(), recent_.end(), [&](const auto& r) { return r.t > from; });
  if (after - recent_.begin() > 1) recent_.erase(recent_.begin(), after - 1);
}

void LiveEstimator::Run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    if (!WaitForImage(&lock)) return;
    DropLateImages();
    const Image image = std::move(images_.front());
    images_.pop_front();
    std::vector<ImuMeasurement> taken;
    TakeMeasurements(image.t + time_offset_, &taken);
    working_ = true;
    const bool restarts = std::exchange(restarting_, false);
    lock.unlock();
    FrameReport report;
    std::exception_ptr error;
    try {
      if (restarts) estimator_.Restart();
      for (const ImuMeasurement& measurement : taken) estimator_.AddImu(measurement);
      report = estimator_.AddFrame(image);
      if (callback_) callback_(report, estimator_);
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    working_ = false;
    error_ = error;
    time_offset_ = estimator_.TimeOffset();
    if (!restarting_) NoteAnswer(image.t, error ? std::nullopt : report.state);
    changed_.notify_all();
    if (error) return;
  }
}

}  // namespace ch5
