#pragma once
/// Whose homework is under test. The stage tests call the graded functions through a Submission, so that the same
/// tests judge the student's file, the reference, and a whole corpus of right and wrong samples in one executable.

#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "ch5_backend/consistency/gauge_freedom.h"
#include "ch5_backend/dense/blocks/plain_block_solver.h"
#include "ch5_backend/dense/problem.h"
#include "ch5_backend/marginalize/marginalization_error.h"
#include "ch5_backend/marginalize/marginalization_info.h"
#include "ch5_backend/open_tasks/open_tasks.h"
#include "ch5_backend/simulate/mono_ba.h"
#include "ch5_backend/window/vins_window.h"

namespace ch5::homework {

/// A MarginalizationError whose four graded functions are called one by one, on matrices that the test puts there.
class OkvisTerm {
 public:
  struct Members {
    MatXX *H, *J;
    VecX *b0, *e0;
    int* dense_size;
  };
  struct Remainder {
    MatXX H;
    VecX b0;
    MatXX J;
  };

  virtual ~OkvisTerm() = default;
  virtual Members Inside() = 0;
  virtual int InsertBlock(int dim, bool is_landmark) = 0;
  virtual void SchurComplement(const MatXX& V, const MatXX& W, const VecX& b_b, MatXX* U, VecX* b_a) = 0;
  virtual void UpdateErrorComputation() = 0;
  virtual VecX Residual(const VecX& delta_chi) = 0;
  /// All of it: takes the edges, marginalizes the vertices `drop`.
  /// @return what is left, its rows and columns in the order of `keep`
  virtual Remainder Marginalize(const std::vector<std::shared_ptr<Edge>>& edges,
                                const std::vector<std::shared_ptr<Vertex>>& drop,
                                const std::vector<std::shared_ptr<Vertex>>& keep) = 0;
};

/// A MarginalizationInfo whose five graded functions are called one by one, on numbers that the test puts there.
class VinsTerm {
 public:
  struct Block {
    std::shared_ptr<Vertex> vertex;
    VecX x0;
    int idx;
  };
  struct KeptSystem {
    MatXX A;
    VecX b;
  };
  struct Members {
    MatXX *A, *J;
    VecX *b, *r0;
    int *m, *n;
    std::vector<int>* keep;
  };

  virtual ~VinsTerm() = default;
  virtual Members Inside() = 0;
  virtual std::map<int, Block> Blocks() const = 0;
  virtual void AddResidualBlockInfo(const ResidualBlockInfo& info) = 0;
  virtual void PreMarginalize() = 0;
  virtual void ConstructA() = 0;
  virtual KeptSystem SchurComplement() const = 0;
  virtual void Factor(const KeptSystem& kept) = 0;
  virtual Prior GetParameterBlocks(const std::map<int, std::shared_ptr<Vertex>>& shift) const = 0;
};

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
  GaugeFreedom gauge_freedom;                       // stage 4
  std::unique_ptr<OkvisTerm> (*make_okvis_term)();  // stage 5
  std::unique_ptr<VinsTerm> (*make_vins_term)();    // stage 6
  VinsWindow vins_window;
  std::unique_ptr<PlainBlockSolver> (*make_block_solver)(Graph* graph);  // stage 7
  OpenTasks open_tasks;                                                  // stage 8
};

/// For make_problem and make_block_solver: `P` is what they return, or a class derived from it. Not make_unique, here and
/// below: it would compile a unique_ptr<P> for each of hundreds of samples.
template <typename P>
std::unique_ptr<Problem> Make(Graph* graph) {
  return std::unique_ptr<Problem>(new P(graph));
}
template <typename P>
std::unique_ptr<PlainBlockSolver> MakeBlockSolver(Graph* graph) {
  return std::unique_ptr<PlainBlockSolver>(new P(graph));
}

/// What is left in a term, in the order of these vertices.
inline OkvisTerm::Remainder RemainderOf(const MarginalizationError& term,
                                        const std::vector<std::shared_ptr<Vertex>>& vertices) {
  std::vector<int> rows;
  for (const auto& vertex : vertices) {
    for (int k = 0; k < vertex->LocalDimension(); ++k) rows.push_back(term.OrderingIdx(*vertex) + k);
  }
  if (term.H().rows() != static_cast<int>(rows.size())) {
    throw std::logic_error("MarginalizeOut leaves " + std::to_string(term.H().rows()) + " rows, not " +
                           std::to_string(rows.size()));
  }
  return {term.H()(rows, rows), term.b0()(rows), term.GetPrior().J(Eigen::all, rows)};
}

/// For make_okvis_term: `M` is MarginalizationError or a class derived from it.
template <typename M>
class OkvisTermOf : public OkvisTerm, private M {
 public:
  Members Inside() override { return {&this->H_, &this->J_, &this->b0_, &this->e0_, &this->dense_size_}; }
  int InsertBlock(int dim, bool is_landmark) override { return M::InsertBlock(dim, is_landmark); }
  void SchurComplement(const MatXX& V, const MatXX& W, const VecX& b_b, MatXX* U, VecX* b_a) override {
    M::SchurComplement(V, W, b_b, U, b_a);
  }
  void UpdateErrorComputation() override { M::UpdateErrorComputation(); }
  VecX Residual(const VecX& delta_chi) override { return M::Residual(delta_chi); }
  Remainder Marginalize(const std::vector<std::shared_ptr<Edge>>& edges,
                        const std::vector<std::shared_ptr<Vertex>>& drop,
                        const std::vector<std::shared_ptr<Vertex>>& keep) override {
    for (const auto& edge : edges) M::AddResidualBlock(edge);
    M::MarginalizeOut(drop);
    M::UpdateErrorComputation();
    return RemainderOf(*this, keep);
  }
};
template <typename M>
std::unique_ptr<OkvisTerm> MakeOkvisTerm() {
  return std::unique_ptr<OkvisTerm>(new OkvisTermOf<M>);
}

/// For make_vins_term: `M` is MarginalizationInfo or a class derived from it.
template <typename M>
class VinsTermOf : public VinsTerm, private M {
 public:
  Members Inside() override {
    return {&this->A_,   &this->linearized_jacobians_, &this->b_, &this->linearized_residuals_, &this->m_, &this->n_,
            &this->keep_};
  }
  std::map<int, Block> Blocks() const override {
    std::map<int, Block> blocks;
    for (const auto& [id, block] : this->blocks_) blocks[id] = {block.vertex, block.x0, block.idx};
    return blocks;
  }
  void AddResidualBlockInfo(const ResidualBlockInfo& info) override { M::AddResidualBlockInfo(info); }
  void PreMarginalize() override { M::PreMarginalize(); }
  void ConstructA() override { M::ConstructA(); }
  KeptSystem SchurComplement() const override {
    const auto kept = M::SchurComplement();
    return {kept.A, kept.b};
  }
  void Factor(const KeptSystem& kept) override { M::Factor({kept.A, kept.b}); }
  Prior GetParameterBlocks(const std::map<int, std::shared_ptr<Vertex>>& shift) const override {
    return M::GetParameterBlocks(shift);
  }
};
template <typename M>
std::unique_ptr<VinsTerm> MakeVinsTerm() {
  return std::unique_ptr<VinsTerm>(new VinsTermOf<M>);
}

/// The one under test: the functions that are linked in, unless Choose has named another.
const Submission& Chosen();
/// @return false if no submission has this name
bool Choose(const std::string& name);
/// The linked functions, to which each linked_NAME.cc adds those of NAME.cc before main; a check links only its own.
Submission* Linked();
/// Before main.
bool Register(const std::string& name, const Submission& submission);

}  // namespace ch5::homework
