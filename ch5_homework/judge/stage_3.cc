/// Stage 3: exactly one prior on each of the first two frames, and the gauge obeys it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_homework/judge/ask.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/fingerprint.h"
#include "ch5_homework/judge/scenes/bundle.h"

namespace ch5::homework {
namespace {

/// A prior of the submission's.
struct Prior {
  MatXX W;
  bool has_loss;
  int level;
  Transform asked;  ///< the pose that it asks for
};

/// What the submission has added to a scene whose vertices are at their start.
struct Built {
  StartScene start;
  std::vector<std::vector<Prior>> priors;  ///< on each frame
  std::vector<bool> fixed;                 ///< each frame
  MatXX measurements;                      ///< W of the reprojection edges, a column each
  int moved = -1;                          ///< a frame that the submission has moved

  Built(double pixel_information, double prior_weight) {
    const Answer added =
        Ask("AddMonoBaEdges", start, {{"pixel_information", pixel_information}, {"prior_weight", prior_weight}});
    const MatXX poses = added.Sized("poses", 7, StartScene::kFrames),
                is_fixed = added.Sized("fixed", StartScene::kFrames, 1);
    if (!poses.allFinite()) throw WireError("a vertex holds a number that is not finite");
    for (size_t i = 0; i < start.ba.poses.size(); ++i) {  // a vertex moved to the truth needs no priors
      const auto column = static_cast<Eigen::Index>(i);
      if (!Equal(poses.col(column), start.ba.poses[i]->Parameters(), 1e-12)) moved = static_cast<int>(i);
      fixed.push_back(is_fixed(column) != 0.0);
    }
    TakePriors(added, poses);
    measurements = added.Sized("measurements", 4, added["measurements"].cols());
  }

 private:
  // r = [Log(q₀⁻¹q); p − p₀] at the pose where the submission has left its frame.
  void TakePriors(const Answer& added, const MatXX& poses) {
    priors.resize(StartScene::kFrames);
    const MatXX numbers = added.Sized("priors", 9, added["priors"].cols());
    for (int k = 0; k < numbers.cols(); ++k) {
      const VecX one = numbers.col(k);
      const MatXX& W = added["W " + std::to_string(k)];
      if (!(one[0] >= 0.0 && one[0] < StartScene::kFrames)) continue;
      const auto frame = static_cast<Eigen::Index>(one[0]);
      const Eigen::Vector4d coefficients = poses.col(frame).tail<4>();
      const Qd q(coefficients);
      const Vec3 r_R = one.segment<3>(3), r_p = one.tail<3>();
      priors[static_cast<size_t>(frame)].push_back(
          {W, one[1] != 0.0, one[2] != 0.0, {q * ExpSO3(-r_R), poses.col(frame).head<3>() - r_p}});
    }
  }
};

// The counts of priors per frame that typical mistakes give.
Text CauseOfCounts(const std::vector<int>& counts) {
  static const std::map<std::vector<int>, Text> causes{
      {{0, 0, 0, 0}, "3.no_prior_reached_graph"},
      {{1, 0, 0, 0}, "3.only_frame_0_prior"},
      {{0, 1, 0, 0}, "3.only_frame_1_prior"},
      {{2, 0, 0, 0}, Text("3.both_priors_frame", {{"n", Word("0")}})},
      {{0, 2, 0, 0}, Text("3.both_priors_frame", {{"n", Word("1")}})},
      {{0, 1, 1, 0}, "3.count_begins_0"},
      {{1, 1, 1, 0}, "3.one_frame_many"},
      {{1, 1, 1, 1}, "3.every_frame_prior"},
      {{2, 2, 0, 0}, "3.each_prior_added_twice"},
  };
  if (const auto it = causes.find(counts); it != causes.end()) return it->second;
  const bool often = *std::max_element(counts.begin(), counts.end()) >= StartScene::kPoints;
  return often ? "3.priors_in_landmark_loop" : "3.loop_over_other_frames";
}

TEST(Stage3, OnePriorOnEachOfTheFirstTwoFrames) {
  const Built built(1.0, 100.0);
  std::vector<int> counts;
  for (const auto& priors : built.priors) counts.push_back(static_cast<int>(priors.size()));
  const std::vector<int> right{1, 1, 0, 0};
  if (counts != right) {
    const auto fixed_instead = [&](size_t i) { return counts[i] == 0 && built.fixed[i]; };
    Fail({"3.number_of_priors", Word(Join(right)), Word(Join(counts)),
          fixed_instead(0) || fixed_instead(1) ? "3.fixed_for_a_prior" : CauseOfCounts(counts), "3"});
  }
}

// The information of a frame's prior at a weight.
struct Weighted {
  double weight;
  MatXX W;
};

// What all of them are instead of w·I, in words: at one weight alone a limit or a threshold looks like another mistake.
Text CauseOfInformation(const std::vector<Weighted>& all, double pixel_information) {
  const auto are = [&](const auto& mistaken) {
    return std::all_of(all.begin(), all.end(),
                       [&](const Weighted& one) { return Equal(one.W, mistaken(one.weight), 1e-9); });
  };
  const auto are_times_identity = [&](const auto& mistaken) {
    return are([&](double w) { return MatXX(mistaken(w) * MatXX::Identity(6, 6)); });
  };
  const auto are_halves = [&](const auto& rotation, const auto& position) {
    return are([&](double w) {
      return MatXX((VecX(6) << Vec3::Constant(rotation(w)), Vec3::Constant(position(w))).finished().asDiagonal());
    });
  };
  const auto weight = [](double w) { return w; };
  const auto zero = [](double) { return 0.0; };
  const auto one = [](double) { return 1.0; };
  if (std::any_of(all.begin(), all.end(), [](const Weighted& at) { return at.W.rows() != 6 || at.W.cols() != 6; })) {
    return "3.prior_pose_six_rows";
  }
  if (are_times_identity([](double w) { return std::trunc(w); })) return "3.weight_truncated_integer";
  if (are_times_identity([](double w) { return std::round(w); })) return "3.weight_truncated_integer";
  if (are_times_identity(zero)) return "3.information_zero";
  if (are_times_identity(one)) return "3.information_identity";
  if (are_times_identity([](double w) { return w * w; })) return "3.weight_squared";
  if (are_times_identity([](double w) { return std::sqrt(w); })) return "3.root_weight";
  if (are_times_identity([](double w) { return 1.0 / w; })) return "3.inverse_weight";
  if (are_times_identity([](double w) { return 1.0 / (w * w); })) return "3.weight_as_standard_deviation";
  if (are_times_identity([=](double) { return pixel_information; })) return "3.pixels_information";
  if (are_times_identity([=](double w) { return pixel_information * w; })) return "3.pixels_information_multiplied";
  if (are_times_identity([](double w) { return 0.5 * w; })) return "3.half_weight";
  if (are_halves(weight, zero)) return "3.rotations_only";
  if (are_halves(zero, weight)) return "3.positions_only";
  if (are_halves(weight, one) || are_halves(one, weight)) return "3.half_of_residual_weighted";
  if (are([](double w) { return MatXX(MatXX::Constant(6, 6, w)); })) return "3.every_entry_weight";
  return "3.information_is_weight_times_identity";
}

// Known by all of them, however far apart the weights are.
std::string FingerprintOf(const std::vector<Weighted>& all) {
  const auto n = static_cast<Eigen::Index>(all.size());
  MatXX expected(6 * n, 6), got(6 * n, 6);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto& [weight, W] = all[static_cast<size_t>(k)];
    if (W.rows() != 6 || W.cols() != 6) return {};
    expected.middleRows(6 * k, 6).setIdentity();
    got.middleRows(6 * k, 6) = W / weight;
  }
  return Fingerprint(expected.array().asinh(), got.array().asinh());
}

// Of W, the entry that is farthest from w·I₆.
Text WorstEntry(const MatXX& W, double weight) {
  int row = 0, column = 0;
  if (W.rows() != 6 || W.cols() != 6) {
    return {"3.entries", {{"size", Word(std::to_string(W.rows()) + "×" + std::to_string(W.cols()))}}};
  }
  (W - weight * MatXX::Identity(6, 6)).cwiseAbs().maxCoeff(&row, &column);
  return Word("W(" + std::to_string(row) + ", " + std::to_string(column) + ") = " + Number(W(row, column)));
}

TEST(Stage3, InformationIsTheWeight) {
  Random random(Seed(34));
  const double pixel_information = 7.0;
  std::vector<Weighted> of_frame[2];
  const auto ask = [&](double weight) {
    const Built built(pixel_information, weight);
    for (size_t i = 0; i < 2; ++i) {
      const auto of_prior = [&](const char* what) { return Text(what, {{"n", Word(i)}, {"w", Word(weight)}}); };
      if (built.priors[i].size() != 1) {
        Fail({of_prior("3.prior_frame"), "3.one", Word(built.priors[i].size()), "3.every_weight_above_0_priors", "3"});
      }
      if (built.priors[i][0].has_loss) {
        Fail({of_prior("3.loss_function_prior_frame"), "3.no_loss", "3.loss", "3.prior_no_loss_function", "3"});
      }
      of_frame[i].push_back({weight, built.priors[i][0].W});
    }
  };
  const auto judge = [&] {
    for (size_t k = 0; k < of_frame[0].size(); ++k) {
      for (size_t i = 0; i < 2; ++i) {
        const auto& [weight, W] = of_frame[i][k];
        if (Equal(W, weight * MatXX::Identity(6, 6), 1e-6)) continue;  // a float will do
        Fail({{"3.information_prior_frame", {{"n", Word(i)}, {"w", Word(weight)}}},
              Word(Number(weight) + "·I₆"),
              WorstEntry(W, weight),
              CauseOfInformation(of_frame[i], pixel_information),
              "3",
              {},
              FingerprintOf(of_frame[i])});
      }
    }
  };
  // Weights are no integers; the handout's sweep begins at 1e-3, and the drift is tested up to 1e11, which an integer is not.
  for (const double weight : {100.0, 0.25, 1e-9, std::pow(10.0, random.Uniform(-3.0, 4.0))}) ask(weight);
  judge();
  ask(1e11);
  judge();
}

// The prior's residual at a pose: zero if that is the pose that it asks for.
double ResidualAt(const Transform& T_W_C, const Transform& asked) {
  return std::hypot(LogSO3(asked.q.conjugate() * T_W_C.q).norm(), (T_W_C.p - asked.p).norm());
}

// Which pose a prior on frame i asks for, if not for the true one.
Text CauseOfPose(const MonoBaScene& scene, size_t i, const Transform& asked) {
  const auto asks_for = [&](const Qd& q, const Vec3& p) { return ResidualAt({q, p}, asked) < 1e-9; };
  const Transform &T = scene.frames[i], &start = scene.initial_frames[i];
  if (asks_for(start.q, start.p)) return "3.asks_for_initial_pose";
  if (asks_for(start.q, T.p)) return "3.asks_for_initial_rotation";
  if (asks_for(T.q, start.p)) return "3.asks_for_initial_position";
  for (size_t k = 0; k < scene.frames.size(); ++k) {
    if (k == i || !asks_for(scene.frames[k].q, scene.frames[k].p)) continue;
    return {"3.asks_for_pose_of_other_frame", {{"k", Word(k)}}};
  }
  const Qd inverse = T.q.conjugate(), identity = Qd::Identity();
  if (asks_for(inverse, T.p)) return "3.quaternion_conjugated";
  if (asks_for(inverse, -(inverse * T.p))) return "3.inverse_pose";
  const Transform& first = scene.frames[0];
  const Qd to_first = first.q.conjugate();
  if (i > 0 && asks_for(to_first * T.q, to_first * (T.p - first.p))) return "3.relative_to_frame_0";
  const Qd reordered = Qd(T.q.x(), T.q.y(), T.q.z(), T.q.w());  // read as w, x, y, z
  if (asks_for(reordered, T.p)) return "formula.quaternion_order";
  if (asks_for(identity, T.p)) return "3.asks_for_no_rotation";
  if (asks_for(T.q, Vec3::Zero())) return "3.asks_for_origin";
  if (asks_for(identity, Vec3::Zero())) return "3.asks_for_identity";
  if (asks_for(T.q, -T.p)) return "3.sign_position";
  for (size_t k = 0; k < scene.frames.size(); ++k) {
    if (k == i) continue;
    if (asks_for(scene.frames[k].q, T.p)) return {"3.asks_for_rotation_of_other_frame", {{"k", Word(k)}}};
    if (asks_for(T.q, scene.frames[k].p)) return {"3.asks_for_position_of_other_frame", {{"k", Word(k)}}};
  }
  return "3.asks_for_another_pose";
}

TEST(Stage3, PriorAsksForTheTruePose) {
  const Built built(1.0, 100.0);
  const MonoBaScene& scene = built.start.scene;
  const auto& all_priors = built.priors;
  for (const size_t i : {1u, 0u}) {  // a pose relative to frame 0 shows at frame 1
    ASSERT_EQ(all_priors[i].size(), 1u);
    const Transform& asked = all_priors[i][0].asked;
    const double residual = ResidualAt(scene.frames[i], asked);
    if (residual < 1e-9) continue;
    const auto numbers = [](const Transform& T) { return MatXX((VecX(7) << T.p, T.q.coeffs()).finished()); };
    Fail({Text("3.residual_at_true_pose", {{"n", Word(i)}}),
          Word(0),
          Word(residual),
          CauseOfPose(scene, i, asked),
          "3",
          {},
          Fingerprint(numbers(scene.frames[i]), numbers(asked))});
  }
}

TEST(Stage3, NoneAtWeightZero) {
  const Built with_priors(1.0, 100.0);
  if (with_priors.priors[0].empty()) Fail({"3.no_prior_weight_100"});  // otherwise nothing is shown
  const Built built(1.0, 0.0);
  for (const auto& priors : built.priors) {
    for (const Prior& prior : priors) {
      if (prior.W.isZero(0.0)) continue;
      Fail({"3.prior_at_weight_zero", "3.none_or_one_zero_information", "3.one_information", "3.zero_weight_means_free",
            "3"});
    }
  }
}

TEST(Stage3, NoFrameIsFixed) {
  const Built built(1.0, 100.0);
  if (built.priors[0].empty()) Fail({"3.no_prior_weight_100"});  // otherwise nothing is shown
  for (size_t i = 0; i < built.fixed.size(); ++i) {
    if (!built.fixed[i]) continue;
    Fail({Text("3.frame", {{"n", Word(i)}}), "3.free_held_prior_alone", "3.fixed", "3.prior_and_fixed", "3"});
  }
  if (built.moved < 0) return;
  Fail({Text("3.frame", {{"n", Word(built.moved)}}), "3.at_its_start", "3.elsewhere", "3.frame_moved", "3"});
}

TEST(Stage3, MeasurementsAreUntouched) {
  const Built built(7.0, 100.0);
  if (built.priors[0].empty()) Fail({"3.no_prior_weight_100"});  // otherwise nothing is shown
  const auto measurements = built.measurements.cols();
  for (Eigen::Index k = 0; k < measurements; ++k) {
    if (built.measurements.col(k).isApprox(7.0 * Eigen::Vector4d(1, 0, 0, 1))) continue;
    Fail({"3.information_reprojection_edge", Word("7·I₂"), "3.another", "3.measurements_changed", ""});
  }
  if (measurements != StartScene::kPoints * (StartScene::kFrames - 1)) {
    const char* cause = measurements == 0 ? "3.measurements_not_reached" : "3.measurements_changed";
    Fail({"3.number_of_reprojection_edges", Word(18), Word(measurements), cause, ""});
  }
}

// At a smaller weight the pixels pull too, and how far is a matter of the seed. The scene is solved here, with the
// submission's priors.
TEST(Stage3, DriftOfTheFirstFrameGoesToZero) {
  const double pixel_information = 1e6;
  Built built(pixel_information, 1e11);
  MonoBa& ba = built.start.ba;
  built.start.AddReprojections();
  for (const auto& edge : ba.graph.Edges()) edge->SetInformation(pixel_information * Mat22::Identity());
  for (size_t i = 0; i < ba.poses.size(); ++i) {
    ba.poses[i]->SetFixed(built.fixed[i]);
    for (const Prior& prior : built.priors[i]) {
      auto edge = std::make_shared<EdgeSE3Prior>(ba.poses[i], prior.asked.q, prior.asked.p);
      edge->SetInformation(prior.W);
      edge->SetLevel(prior.level);
      if (prior.has_loss) edge->SetLossFunction(std::make_shared<CauchyLoss>(1.0));  // no check asks which one
      ba.graph.AddEdge(edge);
    }
  }
  SolveOptions options;
  options.max_iterations = 50;
  Problem(&ba.graph).Solve(options);
  const double drift = (ba.poses[0]->p() - built.start.scene.frames[0].p).norm();
  if (drift < 1e-6) return;
  Fail({Text("3.drift_after_solving", {{"w", Word("1e11")}}), "3.less_than_a_millionth", Word(drift),
        "3.frame_not_held", "3"});
}

}  // namespace
}  // namespace ch5::homework
