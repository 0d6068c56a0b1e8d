/// The estimator live: live_odometry [FOLDER]. Images and IMU come from threads of their own, as drivers deliver them, here
/// out of a recording or, without one, of a simulation; wheels are a further sensor, and poses come out at the IMU's rate.
#include <cstdio>
#include <thread>

#include "ch5_backend/files/recording_file.h"
#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/simulate/sensors/simulation.h"
#include "ch5_backend/window/live_estimator.h"

// The body's forward speed:  r = [R_W_Bᵀ v_W]_x − speed.
class EdgeWheels : public ch5::SizedEdge<1, ch5::VertexPose, ch5::VertexSpeedBias> {
 public:
  EdgeWheels(std::shared_ptr<ch5::VertexPose> pose, std::shared_ptr<ch5::VertexSpeedBias> speed_bias, double speed)
      : SizedEdge(std::move(pose), std::move(speed_bias)), speed_(speed) {
    SetInformation(InformationMatrix(1.0 / (0.05 * 0.05)));  // [s²/m²]
  }
  void ComputeResidual() override { r_[0] = (GetVertex<0>().R().transpose() * GetVertex<1>().v()).x() - speed_; }
  std::string TypeInfo() const override { return "EdgeWheels"; }

 private:
  double speed_;
};

int main(int argc, char** argv) {
  ch5::HandheldOptions path;
  path.standstill_seconds = 2.0;
  const ch5::Recording recording = argc > 1 ? ch5::ReadRecording(argv[1]) : ch5::SimulateInRoom(path, 1500);

  ch5::EstimatorOptions options;
  options.calibration = recording.calibration;
  options.own_edges = [&](const ch5::Window& window, ch5::Graph* graph) {
    for (const ch5::Frame& frame : window.frames) {
      const auto truth = ch5::StateAt(recording.truth, frame.t);  // in place of wheels
      if (!frame.speed_bias || !truth) continue;
      const double speed = (truth->T_W_B.q.conjugate() * truth->v_W).x();
      graph->AddEdge(std::make_shared<EdgeWheels>(frame.pose, frame.speed_bias, speed));
    }
  };
  ch5::LiveEstimator estimator(
      options, ch5::MakeVinsPolicy(), [](const ch5::FrameReport& report, const ch5::Estimator&) {
        if (!report.state) return (void)std::fprintf(stderr, "no estimate: %s\n", report.message.c_str());
        const ch5::Vec3& p = report.state->T_W_B.p;
        std::printf("%.3f s, segment %d: %7.3f %7.3f %7.3f\n", report.state->t, report.segment, p.x(), p.y(), p.z());
      });
  std::thread driver([&] {
    for (const ch5::ImuMeasurement& measurement : recording.imu) estimator.AddImu(measurement);
  });
  for (const ch5::Image& image : recording.images) estimator.AddFrame(image);
  driver.join();
  estimator.Finish();
  const auto last = estimator.PredictAt(recording.images.back().t);
  return last ? (void)std::printf("at the end: speed %.2f m/s\n", last->v_W.norm()), 0 : 1;
}
