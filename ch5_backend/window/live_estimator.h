#pragma once
/// An estimator that runs beside the program: measurements come from any threads, none of which waits for a solve.
///
///   driver of the IMU ── AddImu ───►┐                                 ┌─► callback, once an image
///                                   ├─► in order of time ─► Estimator ┤
///   tracker of images ── AddFrame ─►┘                                 └─► PredictAt, at the IMU's rate
///
/// An image waits until a measurement has come from its time or later. So the estimates are those of a single thread that
/// feeds the recording in order of time, to the bit, whenever what arrives; only how late they come depends on the machine.

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>

#include "ch5_backend/window/estimator.h"

namespace ch5 {

class LiveEstimator {
 public:
  /// Called in the estimator's thread, for each image in the order of time; `report` says what became of it, and why. It may
  /// read the estimator (TakeSnapshot), and call AddImu, AddFrame and PredictAt of this object, but not Finish.
  using Callback = std::function<void(const FrameReport& report, const Estimator& estimator)>;

  /// @throws OptionError, or std::invalid_argument if the policy is null
  LiveEstimator(const EstimatorOptions& options, std::unique_ptr<WindowPolicy> policy, Callback callback);
  /// Ends after the image that is being solved. What still waits is lost, unless Finish was called.
  ~LiveEstimator();

  /// May be called by any threads at once, but the measurements must come in order of time, and so must the images.
  /// Measurements wait for the image that needs them: without images they take 40 MB an hour at 200 Hz.
  /// @throws MeasurementError, which leaves everything as it was, or what has ended the estimator's thread: an exception of
  ///         the callback or of the policy
  void AddImu(const ImuMeasurement& measurement);
  /// An image more than ten seconds younger than one that waits is taken as a sign that the IMU is silent, and ends the
  /// waiting.
  void AddFrame(Image image);

  /// Waits until all images have been answered, with the measurements that there are.
  /// @throws as AddImu; std::logic_error in the callback, which would wait for its own end
  void Finish();

  /// The newest estimate, carried on by the measurements fed since: Estimator::PredictAt, by any thread at any time.
  std::optional<StampedState> PredictAt(double t) const;

 private:
  void Run();
  bool HasWork() const;
  bool IsReady(const Image& image) const;
  void TakeMeasurements(double until, std::vector<ImuMeasurement>* taken);
  void RethrowError() const;

  Estimator estimator_;  // of the thread alone
  Callback callback_;
  mutable std::mutex mutex_;  // of all below
  std::condition_variable changed_;
  std::deque<ImuMeasurement> measurements_;  // not yet taken
  std::deque<Image> images_;                 // likewise
  std::vector<ImuMeasurement> recent_;       // from shortly before the newest estimate on
  std::optional<StampedState> newest_;
  double time_offset_;
  double last_taken_ = -std::numeric_limits<double>::infinity();
  double last_image_ = -std::numeric_limits<double>::infinity();
  bool finishing_ = false, stopping_ = false, working_ = false;
  std::exception_ptr error_;
  std::thread thread_;
};

}  // namespace ch5
