#pragma once
/// Whose homework is under test. The stage tests call the graded functions through a Submission, so that the same
/// tests judge the student's file, the reference, and a whole corpus of right and wrong samples in one executable.

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "ch5_backend/math/eigen_types.h"

// Names alone: who calls the functions of a stage includes its header.
namespace ch5 {
class Graph;
class MarginalizationError;
class MarginalizationInfo;
class PlainBlockSolver;
class Problem;
class Vertex;
enum class Failure;
enum class GaugeGroup;
enum class MarginalizationFlag;
struct DampingUpdate;
struct DropSet;
struct ImuIncrement;
struct MarginalizeResult;
struct MonoBa;
struct MonoBaScene;
struct ProjectionJacobians;
struct RangeTerm;
struct Transform;
struct Window;
using Vertices = std::vector<std::shared_ptr<Vertex>>;
}  // namespace ch5

namespace ch5::homework {

/// The functions of stage 4.
struct GaugeFreedom {
  MatXX (*null_space)(const Vertices& vertices, GaugeGroup group);
  MatXX (*projection)(const MatXX& U, const MatXX& V);
  MatXX (*motion_jacobian)(const Vertices& vertices, double yaw);
  MatXX (*transform_covariance)(const MatXX& covariance, const MatXX& motion, const MatXX& Q, const MatXX& Q_C);
};

/// The free functions of stage 6.
struct VinsWindow {
  DropSet (*margin_old)(const Window& window);
  DropSet (*margin_second_new)(const Window& window);
  void (*slide)(MarginalizationFlag flag, Window* window);
  Failure (*detect_failure)(const Window& window, const Vec3& last_p);
};

/// The functions of stage 8.
struct OpenTasks {
  DampingUpdate (*update_damping)(double cost, double trial_cost, double predicted_decrease, double lambda, double nu);
  ProjectionJacobians (*linearize_projection)(const Transform& T_W_B, const Transform& T_B_C, const Vec3& p_W);
  ImuIncrement (*integrate_imu)(const ImuIncrement& before, const Vec3& acceleration, const Vec3& gyroscope, double dt,
                                double sigma_a, double sigma_g);
  RangeTerm (*linearize_range)(const Transform& T_W_B, const Vec3& antenna, const Vec3& beacon, double range);
};

struct Submission {
  std::unique_ptr<Problem> (*make_problem)(Graph* graph);                        // stages 1.1 and 1.2
  MarginalizeResult (*test_marginalize)(MatXX H, VecX b, int idx, int dim);      // stage 2
  void (*add_mono_ba_edges)(const MonoBaScene& scene, double pixel_information,  // stage 3
                            double prior_weight, MonoBa* problem);
  GaugeFreedom gauge_freedom;                                             // stage 4
  std::unique_ptr<MarginalizationError> (*make_marginalization_error)();  // stage 5
  std::unique_ptr<MarginalizationInfo> (*make_marginalization_info)();    // stage 6
  VinsWindow vins_window;
  std::unique_ptr<PlainBlockSolver> (*make_block_solver)(Graph* graph);  // stage 7
  OpenTasks open_tasks;                                                  // stage 8
};

/// For the functions make_…: a T, as the class that it is or is derived from. Not make_unique: it would compile a
/// unique_ptr<T> for each of hundreds of samples.
template <typename Class, typename T, typename... A>
std::unique_ptr<Class> Make(A... arguments) {
  return std::unique_ptr<Class>(new T(arguments...));
}

/// The one under test: the functions that are linked in, unless an option has named another.
const Submission& Chosen();
/// Whether this is the option "--submission=NAME", NAME that of a submission; then it is taken.
bool TakeSubmission(const std::string& option);
/// The linked functions, to which each linked_NAME.cc adds those of NAME.cc before main; a check links only its own.
Submission* Linked();
/// Before main.
bool Register(const std::string& name, const Submission& submission);

}  // namespace ch5::homework
