#pragma once
/// An estimator that runs beside the program: measurements come from any threads, none of which waits for a solve.
///
///   driver of the IMU ── AddImu ───►┐                                 ┌─► callback, once an image
///                                   ├─► in order of time ─► Estimator ┤
///   tracker of images ── AddFrame ─►┘                                 └─► PredictAt, at the IMU's rate
///
/// An image waits until a measurement has come from its time or later. So the estimates are those of a single thread that
/// feeds the recording in order of time, to the bit, whenever what arrives, also if a replay is faster than life; only how
/// late they come depends on the machine. LiveOptions::max_lag trades this for estimates that are never late.

#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>

#include "ch5_backend/window/estimator.h"

namespace ch5 {

/// What a program that must keep up asks for. [s]
struct LiveOptions {
  /// If the solver cannot keep up with the camera: images that are more than this older than the newest one are dropped, so
  /// that no estimate comes later than this plus a solve. Infinite: none is dropped, and what waits may grow without bound.
  double max_lag = std::numeric_limits<double>::infinity();
  /// By the machine's clock: if images wait and no measurement has come for so long, the IMU counts as silent, and the
  /// images are answered without it.
  double patience = 10.0;

  /// @throws OptionError
  void Validate() const;
};

/// How far the estimates are behind the camera.
struct Backlog {
  size_t waiting = 0;    ///< images fed and not yet answered, but for one that is being solved
  double seconds = 0.0;  ///< from the newest image that was answered, or else the first one fed, to the newest fed
  size_t dropped = 0;    ///< images so far, by LiveOptions::max_lag; they get no report
};

class LiveEstimator {
 public:
  /// Called in the estimator's thread, for each image in the order of time; `report` says what became of it, and why. It may
  /// read the estimator (TakeSnapshot), and call this object's functions, but not Finish; nor may it destroy it.
  using Callback = std::function<void(const FrameReport& report, const Estimator& estimator)>;

  /// @throws OptionError if an option is out of its range
  /// @throws std::invalid_argument if the policy is null
  LiveEstimator(const EstimatorOptions& options, std::unique_ptr<WindowPolicy> policy, Callback callback,
                const LiveOptions& live = {});
  /// Ends after the image that is being solved. What still waits is lost, unless Finish was called.
  ~LiveEstimator();

  /// May be called by any threads at once, but the measurements must come in order of time, and so must the images.
  /// Measurements wait for the image that needs them: without images they take 40 MB an hour at 200 Hz.
  /// @throws MeasurementError and leaves everything as it was
  /// @throws std::exception of the callback or of the policy, which has ended the estimator's thread
  void AddImu(const ImuMeasurement& measurement);
  void AddFrame(Image image);
  /// Drops what waits; from the next image on as Estimator::Restart: clocks may read anything afterwards.
  /// @throws std::exception as AddImu
  void Restart();

  /// Waits until all images have been answered, with the measurements that there are.
  /// @throws std::exception as AddImu
  /// @throws std::logic_error in the callback, which would wait for its own end
  void Finish();

  /// The newest estimate, carried on by the measurements fed since: Estimator::PredictAt, by any thread at any time. How
  /// old that estimate is, GetBacklog tells.
  std::optional<StampedState> PredictAt(double t) const;
  /// By any thread at any time.
  Backlog GetBacklog() const;

 private:
  using Clock = std::chrono::steady_clock;

  void Run();
  bool WaitForImage(std::unique_lock<std::mutex>* lock);
  void DropLateImages();
  void NoteAnswer(double t, const std::optional<StampedState>& state);
  bool IsReady(const Image& image) const;
  void TakeMeasurements(double until, std::vector<ImuMeasurement>* taken);
  void RethrowError() const;

  Estimator estimator_;  // of the thread alone
  Callback callback_;
  LiveOptions live_;
  mutable std::mutex mutex_;  // of all below
  std::condition_variable changed_;
  std::deque<ImuMeasurement> measurements_;  // not yet taken
  std::deque<Image> images_;                 // likewise
  std::vector<ImuMeasurement> recent_;       // from shortly before the newest estimate on
  std::optional<StampedState> newest_;
  double time_offset_;
  double last_taken_ = -std::numeric_limits<double>::infinity();
  double last_image_ = -std::numeric_limits<double>::infinity();
  std::optional<double> answered_;  // time of the newest image that was, or of the first
  size_t dropped_ = 0;
  Clock::time_point waits_since_;  // the later of the last measurement's coming and of the first image's that waits
  bool imu_is_silent_ = false;
  bool finishing_ = false, stopping_ = false, working_ = false, restarting_ = false;
  std::exception_ptr error_;
  std::thread thread_;
};

}  // namespace ch5
