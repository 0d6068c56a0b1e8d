/// The estimators on simulated recordings, against the truth.
#include <gtest/gtest.h>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "ch5_backend/experiments/studies/window/wrapped_policy.h"
#include "ch5_backend/graph/auto_diff_edge.h"
#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/math/median.h"
#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/sparse/covariance.h"
#include "ch5_backend/types/plus_jacobian.h"
#include "tests/count_malloc.h"
#include "tests/window/simulations.h"

namespace ch5 {
namespace {

void ExpectSmallErrors(const Recording& recording, const OdometryRun& run, double most_meters) {
  SCOPED_TRACE(run.policy);
  ASSERT_TRUE(run.error);
  EXPECT_LT(run.error->position_rmse, most_meters);
  EXPECT_NEAR(run.error->scale, 1.0, 0.01);
  EXPECT_LT(run.error->yaw_rmse, 0.01);
  EXPECT_EQ(run.restarts, 0);
  EXPECT_GT(run.states.back().t, recording.images.back().t - 1e-6) << "it must answer to the end";
}

TEST(Estimator, BothPoliciesFollowAHandHeldCamera) {
  const Recording recording = SimulateRoom();
  OkvisOptions okvis;
  okvis.temporal_frames = 5;
  const EstimatorOptions options{recording.calibration};
  ExpectSmallErrors(recording, RunOdometry(recording, options, MakeVinsPolicy()), 0.05);
  ExpectSmallErrors(recording, RunOdometry(recording, options, MakeOkvisPolicy(okvis)), 0.10);
}

TEST(Estimator, TriesToStartTenTimesASecondHoweverFastTheCameraIs) {
  HandheldOptions path;  // it turns almost on the spot, so that no attempt succeeds, and each tells another parallax
  path.duration = 3.0;
  path.position_sigma = 0.005;
  SimulationOptions simulation;
  simulation.calibration.camera_rate = 50.0;
  const Recording recording = SimulateInRoom(path, 1500, simulation, 1);
  const OdometryRun run = RunOdometry(recording, {recording.calibration}, MakeVinsPolicy());
  ASSERT_TRUE(run.states.empty());
  int changes = 0;
  for (size_t k = 1; k < run.rows.size(); ++k) {
    changes += run.rows[k].report.message != run.rows[k - 1].report.message;
  }
  EXPECT_GT(changes, 15);
  EXPECT_LT(changes, 40) << "seven are of images that are too few";
}

// ---- what a product asks for ---------------------------------------------------------------------------------------

// The course of a policy on a machine so slow that each iteration takes a minute.
class OnASlowMachine : public WrappedPolicy {
 public:
  using WrappedPolicy::WrappedPolicy;
  SolveOptions Options() const override {
    SolveOptions options = WrappedPolicy::Options();
    options.callback = [inner = options.callback](IterationInfo info) {
      info.seconds += 60.0 * (info.iteration + 1);
      return !inner || inner(info);
    };
    return options;
  }
};

Recording SimulateSixSeconds() { return SimulateRoom({6.0, /*standstill_seconds=*/1.5}); }

TEST(Estimator, DoesNotDependOnTheClock) {
  const Recording recording = SimulateSixSeconds();
  const EstimatorOptions options{recording.calibration};
  for (size_t k = 0; k < AllPolicies().size(); ++k) {
    const OdometryRun fast = RunOdometry(recording, options, std::move(AllPolicies()[k]));
    const OdometryRun slow =
        RunOdometry(recording, options, std::make_unique<OnASlowMachine>(std::move(AllPolicies()[k])));
    EXPECT_GT(fast.states.size(), 60u);
    EXPECT_TRUE(AreSame(fast.states, slow.states)) << fast.policy;
  }
  VinsOptions hasty;
  hasty.max_solve_seconds = 0.04;  // VINS-Mono's
  const OdometryRun cut = RunOdometry(recording, options, std::make_unique<OnASlowMachine>(MakeVinsPolicy(hasty)));
  const OdometryRun whole = RunOdometry(recording, options, MakeVinsPolicy());
  EXPECT_FALSE(AreSame(cut.states, whole.states)) << "else the slow machine would be none";
}

#ifdef CH5_COUNTS_MALLOC
// What an image gives back serves the next, mostly without malloc; pages come from the system, which may take it long, only
// where a window is larger than all before.
TEST(Estimator, HardlyAnImageTakesMemoryFromTheSystem) {
  const auto from_the_system = [] {
    const struct mallinfo2 memory = mallinfo2();
    return memory.arena + memory.hblkhd;
  };
  const Recording recording = SimulateRoom();
  for (auto& policy : AllPolicies()) {
    Estimator estimator(EstimatorOptions{recording.calibration}, std::move(policy));
    SCOPED_TRACE(estimator.Policy().Name());
    size_t images = 0, most = 0;
    test::allocations = 0;
    int grown = 0;
    FeedRecording(recording, &estimator, [&](const Estimator&, const ImageResult& row) {
      ASSERT_TRUE(++images < 100 || row.report.state);
      const size_t now = from_the_system();
      if (images > 100) grown += now > most;
      test::counting = images >= 100;
      most = std::max(most, now);
    });
    test::counting = false;
    ASSERT_GT(images, 300u);
    EXPECT_LE(grown, 4);
    EXPECT_LT(test::allocations, 60 * (images - 100));
  }
}
#endif

// Before an image is added, the measurements alone tell where it will be found, up to what the image corrects.
TEST(Estimator, PredictsAtTheRateOfTheImu) {
  const Recording recording = SimulateSixSeconds();
  Estimator estimator(EstimatorOptions{recording.calibration}, MakeVinsPolicy());
  EXPECT_FALSE(estimator.PredictAt(0.0)) << "not before there is an estimate";
  auto measurement = recording.imu.begin();
  std::vector<double> meters, meters_a_second, radians;
  for (const Image& image : recording.images) {
    while (measurement != recording.imu.end() && measurement->t <= image.t) estimator.AddImu(*measurement++);
    const auto predicted = estimator.PredictAt(image.t);
    const auto state = estimator.AddFrame(image).state;
    EXPECT_FALSE(predicted && !state);
    if (!state) continue;
    EXPECT_EQ(estimator.PredictAt(state->t)->T_W_B.p, state->T_W_B.p);
    EXPECT_FALSE(estimator.PredictAt(state->t - 0.01)) << "into the past";
    EXPECT_FALSE(estimator.PredictAt(state->t + 0.2)) << "far beyond the measurements";
    if (!predicted) continue;
    EXPECT_EQ(predicted->t, state->t);
    meters.push_back((predicted->T_W_B.p - state->T_W_B.p).norm());
    meters_a_second.push_back((predicted->v_W - state->v_W).norm());
    radians.push_back(predicted->T_W_B.q.angularDistance(state->T_W_B.q));
  }
  ASSERT_GT(meters.size(), 60u);
  EXPECT_LT(Median(meters), 0.01);
  EXPECT_LT(Median(meters_a_second), 0.05);  // gravity forgotten: 0.5
  EXPECT_LT(Median(radians), 0.005);
}

TEST(Estimator, ReportsTheCovarianceOfTheWholeState) {
  const Recording recording = SimulateSixSeconds();
  EstimatorOptions options{recording.calibration};
  options.report_covariance = options.estimate_extrinsic = options.estimate_time_offset = true;
  for (auto&& policy : AllPolicies()) {
    SCOPED_TRACE(policy->Name());
    int reports = 0;
    RunOdometry(recording, options, std::move(policy), [&](const Estimator& now, const ImageResult& row) {
      if (!row.report.state) return;
      if (++reports % 20 != 0) return;
      const StateCovariance& covariance = *row.report.covariance;
      EXPECT_EQ(covariance.reference, StateCovariance::Reference::kOldestFrame);
      ASSERT_TRUE(covariance.extrinsic && covariance.time_offset_variance);
      EXPECT_LT((covariance.state - covariance.state.transpose()).norm(), 1e-6 * covariance.state.norm());
      EXPECT_GT(covariance.state.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0.0);
      EXPECT_LT(std::sqrt(covariance.state(6, 6)), 0.3) << "a speed is known";
      EXPECT_LT(std::sqrt(covariance.state(9, 9)), 1.01 * now.Options().start_bias_accelerometer);
      EXPECT_LT(std::sqrt(covariance.state(12, 12)), 1.01 * now.Options().start_bias_gyroscope);
      EXPECT_LT(std::sqrt((*covariance.extrinsic)(3, 3)), now.Options().start_extrinsic_rotation);
      EXPECT_LT(std::sqrt(*covariance.time_offset_variance), now.Options().start_time_offset);
    });
    EXPECT_GT(reports, 40);
  }
}

// The force of 1.3 m/s² is known to the bias's 0.1 m/s², and so is the scale.
TEST(Estimator, SaysOnceHowWellItKnowsTheScale) {
  const auto sigmas_of = [](const Recording& recording, std::unique_ptr<WindowPolicy> policy) {
    const OdometryRun run = RunOdometry(recording, EstimatorOptions{recording.calibration}, std::move(policy));
    std::vector<double> sigmas;
    for (const ImageResult& row : run.rows) {
      if (!row.report.scale_sigma) continue;
      sigmas.push_back(*row.report.scale_sigma);
      EXPECT_NEAR(row.t, run.states.front().t + 1.0, 0.06);
    }
    return sigmas;
  };
  for (auto&& policy : AllPolicies()) {
    const auto sigmas = sigmas_of(SimulateCircle(10.0), std::move(policy));
    ASSERT_EQ(sigmas.size(), 1u);
    EXPECT_NEAR(sigmas[0], 0.1 / (2.0 * 2.0 / 3.0), 0.015);
  }
  for (auto&& policy : AllPolicies()) {
    const auto sigmas = sigmas_of(SimulateRoom(), std::move(policy));
    ASSERT_EQ(sigmas.size(), 1u);
    EXPECT_LT(sigmas[0], 0.05);
  }
}

// A window's covariance is a block of the inverse of its H, which an optimizer's Covariance finds in another way.
TEST(Estimator, ItsCovarianceIsABlockOfTheInverse) {
  const Recording recording = SimulateSixSeconds();
  EstimatorOptions options{recording.calibration};
  options.report_covariance = true;
  class ChecksCovariance : public OnASlowMachine {  // looks at the solved window, before it slides
   public:
    using OnASlowMachine::OnASlowMachine;
    void AfterSolve(Window* window) override {
      OnASlowMachine::AfterSolve(window);
      const Frame& newest = window->frames.back();
      const StateCovariance ours = CovarianceOf(*window, newest);
      Covariance theirs(&window->graph);
      const MatXX P_pp = theirs.Block(*newest.pose, *newest.pose),
                  P_vp = theirs.Block(*newest.speed_bias, *newest.pose);
      const MatXX P_vv = theirs.Block(*newest.speed_bias, *newest.speed_bias);
      EXPECT_LT((ours.state.topLeftCorner<6, 6>() - P_pp).norm(), 1e-4 * P_pp.norm());
      EXPECT_LT((ours.state.bottomLeftCorner<9, 6>() - P_vp).norm(), 1e-4 * P_vp.norm());
      EXPECT_LT((ours.state.bottomRightCorner<9, 9>() - P_vv).norm(), 1e-4 * P_vv.norm());
    }
  };
  OkvisOptions okvis;
  okvis.temporal_frames = 5;
  RunOdometry(recording, options, std::make_unique<ChecksCovariance>(MakeOkvisPolicy(okvis)));
}

TEST(Estimator, ASnapshotStaysAsItWas) {
  const Recording recording = SimulateSixSeconds();
  Estimator estimator(EstimatorOptions{recording.calibration}, MakeVinsPolicy());
  std::optional<Snapshot> first, last;
  std::optional<StampedState> at_first;
  FeedRecording(recording, &estimator, [&](const Estimator& now, const ImageResult& row) {
    if (!row.report.state) return;
    last = now.TakeSnapshot();
    if (first) return;
    first = last;
    at_first = row.report.state;
  });
  ASSERT_TRUE(first && last);
  EXPECT_EQ(first->frames.back().state.T_W_B.p, at_first->T_W_B.p) << "150 images later";
  EXPECT_NE(last->frames.back().state.T_W_B.p, at_first->T_W_B.p);
  EXPECT_GT(last->landmarks.size(), 10u);
  EXPECT_EQ(last->segment, 0);
}

// A position in the frame G of a satellite receiver:  r = R_z(ψ) p_W_B + t − z,  [t; ψ] being W in G.
class EdgeGps : public AutoDiffEdge<EdgeGps, 3, VertexPose, VertexVector<4>> {
 public:
  EdgeGps(std::shared_ptr<VertexPose> pose, std::shared_ptr<VertexVector<4>> T_G_W, const Vec3& z)
      : AutoDiffEdge(std::move(pose), std::move(T_G_W)), z_(z) {}
  template <typename T>
  Eigen::Matrix<T, 3, 1> Evaluate(const Eigen::Matrix<T, 7, 1>& pose, const Eigen::Matrix<T, 4, 1>& T_G_W) const {
    using std::cos;
    using std::sin;
    const T c = cos(T_G_W[3]), s = sin(T_G_W[3]);
    return {c * pose[0] - s * pose[1] + T_G_W[0] - z_.x(), s * pose[0] + c * pose[1] + T_G_W[1] - z_.y(),
            pose[2] + T_G_W[2] - z_.z()};
  }
  std::string TypeInfo() const override { return "EdgeGps"; }

 private:
  Vec3 z_;
};

// Positions with 2 cm of noise tell where G lies in W, and take away the drift. What left the window has left its
// knowledge of G in the prior.
TEST(Estimator, AnOwnVertexStaysKnownWhenItsFramesHaveLeft) {
  const Recording recording = SimulateSixSeconds();
  const Qd q_G_W(Eigen::AngleAxisd(0.8, Vec3::UnitZ()));
  const Vec3 p_G_W(100, -50, 20);
  for (size_t k = 0; k < AllPolicies().size(); ++k) {
    const auto T_G_W = std::make_shared<VertexVector<4>>(VertexVector<4>::Estimate::Zero());
    EstimatorOptions options{recording.calibration};
    options.own_edges = [&](const Window& window, Graph* graph) {
      graph->AddVertex(T_G_W);
      for (const Frame& frame : window.frames) {
        Random random(static_cast<uint64_t>(frame.id + 1));
        const Vec3 z = q_G_W * StateAt(recording.truth, frame.t)->T_W_B.p + p_G_W + NormalVector(&random, 0.02);
        const auto edge = std::make_shared<EdgeGps>(frame.pose, T_G_W, z);
        edge->SetInformation(Mat33::Identity() / (0.02 * 0.02));
        graph->AddEdge(edge);
      }
    };
    const OdometryRun run = RunOdometry(recording, options, std::move(AllPolicies()[k]));
    SCOPED_TRACE(run.policy);
    EXPECT_EQ(run.restarts, 0);
    double worst = 0.0;
    for (const StampedState& state : run.states) {
      if (state.t < 4.0) continue;
      const Eigen::AngleAxisd turn(T_G_W->GetEstimate()[3], Vec3::UnitZ());
      const Vec3 p_G = turn * state.T_W_B.p + Vec3(T_G_W->GetEstimate().head(3));
      worst = std::max(worst, (p_G - q_G_W * StateAt(recording.truth, state.t)->T_W_B.p - p_G_W).norm());
    }
    EXPECT_LT(worst, 0.04);
  }
}

// Every second image has a position. VINS leaves most images out as they come: what was measured there stays known.
TEST(Estimator, NoOwnEdgeLeavesTheWindowButIntoThePrior) {
  const Recording recording = SimulateSixSeconds();
  for (size_t k = 0; k < AllPolicies().size(); ++k) {
    const auto T_G_W = std::make_shared<VertexVector<4>>(VertexVector<4>::Estimate::Zero());
    std::set<int> used, in_window, in_prior;
    std::map<const Edge*, int> frame_of;
    EstimatorOptions options{recording.calibration};
    options.own_edges = [&](const Window& window, Graph* graph) {
      in_window.clear();
      frame_of.clear();
      graph->AddVertex(T_G_W);
      for (const Frame& frame : window.frames) {
        if (frame.id % 2 == 1) continue;
        const auto edge = std::make_shared<EdgeGps>(frame.pose, T_G_W, StateAt(recording.truth, frame.t)->T_W_B.p);
        graph->AddEdge(edge);
        frame_of[edge.get()] = frame.id;
        used.insert(frame.id);
        in_window.insert(frame.id);
      }
    };
    options.marginalizer = [&](const auto& edges, const auto& drop) {
      for (const auto& edge : edges)
        if (const auto at = frame_of.find(edge.get()); at != frame_of.end()) in_prior.insert(at->second);
      return std::make_shared<EdgePrior>(Marginalize(edges, drop));
    };
    const OdometryRun run = RunOdometry(recording, options, std::move(AllPolicies()[k]));
    SCOPED_TRACE(run.policy);
    EXPECT_EQ(run.restarts, 0);
    EXPECT_GT(used.size(), run.states.size() / 3);
    for (const int frame : used) EXPECT_TRUE(in_prior.count(frame) || in_window.count(frame)) << "frame " << frame;
  }
}

// The body's forward speed:  r = [R_W_Bᵀ v_W]_x − speed.
class EdgeWheels : public SizedEdge<1, VertexPose, VertexSpeedBias> {
 public:
  EdgeWheels(std::shared_ptr<VertexPose> pose, std::shared_ptr<VertexSpeedBias> speed_bias, double speed)
      : SizedEdge(std::move(pose), std::move(speed_bias)), speed_(speed) {
    SetIsotropicInformation(1.0 / (0.05 * 0.05));
  }
  void ComputeResidual() override { r_[0] = (GetVertex<0>().R().transpose() * GetVertex<1>().v()).x() - speed_; }
  std::string TypeInfo() const override { return "EdgeWheels"; }

 private:
  double speed_;
};

// Images and IMU leave the scale to what wheels measure, or a satellite receiver with 5 cm of noise.
TEST(Estimator, OwnEdgesStartAVehicleAtSteadySpeed) {
  const Recording recording = SimulateSteadyDrive(6.0);
  const auto T_G_W = std::make_shared<VertexVector<4>>(VertexVector<4>::Estimate::Zero());
  const auto wheels = [&](const Window& window, Graph* graph) {
    for (const Frame& frame : window.frames) {
      if (frame.speed_bias) graph->AddEdge(std::make_shared<EdgeWheels>(frame.pose, frame.speed_bias, 5.0));
    }
  };
  const auto receiver = [&](const Window& window, Graph* graph) {
    graph->AddVertex(T_G_W);
    for (const Frame& frame : window.frames) {
      Random random(static_cast<uint64_t>(frame.id + 1));
      const Vec3 p_W = StateAt(recording.truth, frame.t)->T_W_B.p + NormalVector(&random, 0.05);
      const auto edge = std::make_shared<EdgeGps>(frame.pose, T_G_W, Vec3(30.0 - p_W.y(), p_W.x() - 20.0, p_W.z()));
      edge->SetIsotropicInformation(1.0 / (0.05 * 0.05));
      graph->AddEdge(edge);
    }
  };
  for (const OwnEdges& own_edges : {OwnEdges(), OwnEdges(wheels), OwnEdges(receiver)}) {
    for (auto& policy : AllPolicies()) {
      EstimatorOptions options{recording.calibration};
      options.own_edges = own_edges;
      const OdometryRun run = RunOdometry(recording, options, std::move(policy));
      SCOPED_TRACE(run.policy);
      EXPECT_EQ(run.restarts, 0);
      ASSERT_EQ(run.states.empty(), !own_edges);
      if (!own_edges) continue;
      EXPECT_LT(run.states.front().t, 2.5);
      for (const StampedState& state : run.states) EXPECT_NEAR(state.v_W.norm(), 5.0, 0.25) << state.t;
    }
  }
}

TEST(Estimator, OwnEdgesThatAddNothingChangeNoBit) {
  const Recording recording = SimulateSixSeconds();
  EstimatorOptions plain{recording.calibration}, empty = plain;
  empty.own_edges = [](const Window&, Graph*) {};
  for (size_t k = 0; k < AllPolicies().size(); ++k) {
    const OdometryRun without = RunOdometry(recording, plain, std::move(AllPolicies()[k]));
    const OdometryRun with = RunOdometry(recording, empty, std::move(AllPolicies()[k]));
    EXPECT_TRUE(AreSame(without.states, with.states)) << with.policy;
  }
}

TEST(Estimator, ThresholdsOfFailuresAreOptions) {
  const Recording recording = SimulateSixSeconds();
  EstimatorOptions options{recording.calibration};
  options.detect_failure = DetectFailuresBeyond({2.5, 1.0, 5.0, 1e-6});  // no step may climb
  EXPECT_GT(RunOdometry(recording, options, MakeVinsPolicy()).restarts, 0);
  options.detect_failure = nullptr;
  EXPECT_THROW(Estimator(options, MakeVinsPolicy()), std::invalid_argument);
  EXPECT_THROW(DetectFailuresBeyond({-1.0}), OptionError);
}

// The room is walked through at about 1 m/s: 0.3 m from image to image, 0.1 m in a tenth of a second.
TEST(Estimator, LimitsOfAStepHoldForATenthOfASecond) {
  Recording recording = SimulateSixSeconds();
  std::vector<Image> images;
  for (size_t k = 0; k < recording.images.size(); k += 6) images.push_back(recording.images[k]);
  recording.images = images;
  EstimatorOptions options{recording.calibration};
  options.detect_failure = DetectFailuresBeyond({2.5, 1.0, 0.2, 0.2});
  for (auto& policy : AllPolicies()) {
    const OdometryRun run = RunOdometry(recording, options, std::move(policy));
    EXPECT_GT(run.states.size(), 5u);
    EXPECT_EQ(run.restarts, 0);
  }
}

TEST(Estimator, RefusesTimesThatDoNotIncrease) {
  Estimator estimator(EstimatorOptions{}, MakeVinsPolicy());
  estimator.AddImu({1.0, Vec3(0, 0, 9.81), Vec3::Zero()});
  EXPECT_THROW(estimator.AddImu({1.0, Vec3(0, 0, 9.81), Vec3::Zero()}), MeasurementError);
  EXPECT_THROW(estimator.AddImu({0.5, Vec3(0, 0, 9.81), Vec3::Zero()}), MeasurementError);
  EXPECT_THROW(estimator.AddImu({2.0, Vec3(0, 0, NAN), Vec3::Zero()}), MeasurementError);
  estimator.AddFrame({1.0, {}});
  EXPECT_THROW(estimator.AddFrame({1.0, {}}), MeasurementError);
  EXPECT_THROW(estimator.AddFrame({0.9, {}}), MeasurementError);
  estimator.AddImu({1.1, Vec3(0, 0, 9.81), Vec3::Zero()});
  EXPECT_NO_THROW(estimator.AddFrame({1.05, {}}));
}

TEST(MeasurementChecks, GapsBeforeBetweenAndAfterReadingsCount) {
  const auto at = [](std::initializer_list<double> times) {
    std::vector<ImuMeasurement> imu;
    for (const double t : times) imu.push_back({t, Vec3(0, 0, 9.81), Vec3::Zero()});
    return imu;
  };
  EXPECT_EQ(LongestImuGap({}, 0.0, 0.05), INFINITY);
  EXPECT_DOUBLE_EQ(LongestImuGap(at({0.0, 0.1, 0.2}), 0.0, 0.25), 0.1);
  EXPECT_DOUBLE_EQ(LongestImuGap(at({0.15, 0.2}), 0.0, 0.2), 0.15) << "before";
  EXPECT_DOUBLE_EQ(LongestImuGap(at({0.0, 0.2}), 0.0, 0.2), 0.2) << "between";
  EXPECT_DOUBLE_EQ(LongestImuGap(at({0.0, 0.1}), 0.0, 0.25), 0.15) << "after";
  EXPECT_DOUBLE_EQ(LongestImuGap(at({0.0, 0.1, 0.5}), 0.0, 0.15), 0.4) << "around the end";
}

}  // namespace
}  // namespace ch5
