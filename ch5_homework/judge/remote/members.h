#pragma once
/// The protected members that the graded functions read and write: they travel with each call.

#include <vector>

#include "ch5_homework/judge/remote/wire.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {

// ---- stages 1.1 and 1.2 ----------------------------------------------------------------------------------------------

/// Makes them reachable: `problem.*(&ProblemMembers::b_)`.
struct ProblemMembers : Problem {
  using Problem::b_;
  using Problem::b_pp_schur_;
  using Problem::H_pp_schur_;
  using Problem::Hessian_;
};

inline Writer& operator<<(Writer& out, const Problem& problem) {
  return out << problem.*(&ProblemMembers::Hessian_) << problem.*(&ProblemMembers::b_)
             << problem.*(&ProblemMembers::H_pp_schur_) << problem.*(&ProblemMembers::b_pp_schur_);
}
inline Reader& operator>>(Reader& in, Problem& problem) {
  return in >> problem.*(&ProblemMembers::Hessian_) >> problem.*(&ProblemMembers::b_) >>
         problem.*(&ProblemMembers::H_pp_schur_) >> problem.*(&ProblemMembers::b_pp_schur_);
}

// ---- stage 7 ---------------------------------------------------------------------------------------------------------

struct SolverMembers : PlainBlockSolver {
  using PlainBlockSolver::b_;
  using PlainBlockSolver::b_schur_;
  using PlainBlockSolver::H_ll_;
  using PlainBlockSolver::H_pl_;
  using PlainBlockSolver::H_pp_;
  using PlainBlockSolver::S_;
};

using Blocks = std::vector<std::pair<std::pair<int, int>, MatXX>>;

/// What is in a PlainBlockSolver.
struct SolverNumbers {
  Blocks H_pp, H_pl, H_ll, S;
  VecX b, b_schur;
};
inline Writer& operator<<(Writer& out, const SolverNumbers& n) {
  return out << n.H_pp << n.H_pl << n.H_ll << n.S << n.b << n.b_schur;
}
inline Reader& operator>>(Reader& in, SolverNumbers& n) {
  return in >> n.H_pp >> n.H_pl >> n.H_ll >> n.S >> n.b >> n.b_schur;
}

// ---- stages 5 and 6 --------------------------------------------------------------------------------------------------

inline Writer& operator<<(Writer& out, const OkvisTerm::Members& m) {
  return out << *m.H << *m.J << *m.b0 << *m.e0 << *m.dense_size;
}
inline Reader& operator>>(Reader& in, const OkvisTerm::Members& m) {
  return in >> *m.H >> *m.J >> *m.b0 >> *m.e0 >> *m.dense_size;
}
inline Writer& operator<<(Writer& out, const VinsTerm::Members& m) {
  return out << *m.A << *m.J << *m.b << *m.r0 << *m.m << *m.n << *m.keep;
}
inline Reader& operator>>(Reader& in, const VinsTerm::Members& m) {
  return in >> *m.A >> *m.J >> *m.b >> *m.r0 >> *m.m >> *m.n >> *m.keep;
}

}  // namespace ch5::homework
