#pragma once
/// problem.cc: stages 1.1, 1.2 and 2.

#include "ch5_homework/judge/remote/remote.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {
namespace problem {

/// Makes protected members reachable: `problem.*(&Access::b_)`.
struct Access : Problem {
  using Problem::b_;
  using Problem::b_pp_schur_;
  using Problem::H_pp_schur_;
  using Problem::Hessian_;
};

}  // namespace problem

template <>
struct ObjectOf<Problem> {
  static std::unique_ptr<Problem> Make(Scene* scene) { return Chosen().make_problem(&scene->GetGraph()); }
  static auto Members(Problem& p) {
    using Access = problem::Access;
    return std::tie(p.*(&Access::Hessian_), p.*(&Access::b_), p.*(&Access::H_pp_schur_), p.*(&Access::b_pp_schur_));
  }
};

inline auto Fields(MarginalizeResult& result, Wire) {
  return std::tie(result.H_moved, result.b_moved, result.H_prior, result.b_prior);
}

namespace problem {

struct MakeHessian {
  static constexpr char kName[] = "MakeHessian";
  static void Run(RemoteObject<Problem> problem) { problem.object->MakeHessian(); }
};
struct SolveLinearSystem {
  static constexpr char kName[] = "SolveLinearSystem";
  static bool Run(RemoteObject<Problem> problem, Damping damping, double lambda, VecX* delta_x) {
    problem.object->SetDamping(damping);
    return problem.object->SolveLinearSystem(lambda, delta_x);
  }
};
struct TestMarginalize {
  static constexpr char kName[] = "TestMarginalize";
  static MarginalizeResult Run(const MatXX& H, const VecX& b, int idx, int dim) {
    return Chosen().test_marginalize(H, b, idx, dim);
  }
};

/// A Problem whose two graded functions run in the worker.
class RemoteProblem : public Problem {
 public:
  explicit RemoteProblem(Graph* graph) : Problem(graph), remote_{NewHandle(), &Scene::Of(graph), this} {}

  void MakeHessian() override { Ask<problem::MakeHessian>(remote_); }
  bool SolveLinearSystem(double lambda, VecX* delta_x) override {
    return Ask<problem::SolveLinearSystem>(remote_, GetDamping(), lambda, delta_x);
  }

 private:
  RemoteObject<Problem> remote_;
};

inline void Remote(Submission* s) {
  s->make_problem = &Make<Problem, RemoteProblem>;
  s->test_marginalize = [](MatXX H, VecX b, int idx, int dim) { return Ask<TestMarginalize>(H, b, idx, dim); };
}
inline void Serve() { HandleAll<MakeHessian, SolveLinearSystem, TestMarginalize>(); }

}  // namespace problem
}  // namespace ch5::homework
