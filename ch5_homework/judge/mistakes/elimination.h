#pragma once
/// What goes wrong wherever a part of a system is eliminated: stages 1.2, 2, 5, 6 and 7.

#include <functional>
#include <string>
#include <vector>

#include "ch5_backend/math/psd.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/mistakes/formula.h"

namespace ch5::homework {

/// A system of which r remains and m, behind it, goes.
struct PartedSystem {
  MatXX A_rr, A_rm, A_mm, A_mm_inverse;
  VecX b_r, b_m;

  PartedSystem(const MatXX& A, const VecX& b, Eigen::Index r)
      : A_rr(A.topLeftCorner(r, r)),
        A_rm(A.topRightCorner(r, A.cols() - r)),
        A_mm(A.bottomRightCorner(A.rows() - r, A.cols() - r)),
        A_mm_inverse(PseudoInversePsd(A_mm)),
        b_r(b.head(r)),
        b_m(b.tail(b.size() - r)) {}
  MatXX Schur() const { return Schur(A_mm_inverse); }
  VecX Reduced() const { return Reduced(A_mm_inverse); }
  /// With something else in place of A_mm⁻¹.
  MatXX Schur(const MatXX& middle) const { return A_rr - A_rm * middle * A_rm.transpose(); }
  VecX Reduced(const MatXX& middle) const { return b_r - A_rm * middle * b_m; }
};

/// rest − product, where the product holds the inverse of what goes, in the stage's letters.
struct Elimination {
  const char *todo, *todo_of_inverse;
  const char *rest, *product;    ///< "H_pp", "H_pm H_mm⁻¹ H_mp"
  const char *inverse, *matrix;  ///< "H_mm⁻¹", "H_mm"
};

/// The symmetric root of a symmetric positive semi-definite matrix.
inline MatXX RootOf(const MatXX& A) {
  if (A.size() == 0) return A;
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(A);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
         eigen.eigenvectors().transpose();
}

/// The inverse without directions that were measured, as of too high a threshold: without the weakest or, where M is
/// singular or small, without any.
inline std::vector<Mistake> CutMistakes(const char* todo, const char* matrix, const MatXX& M,
                                        const std::function<MatXX(const MatXX& middle)>& with) {
  const auto m = static_cast<int>(M.rows());
  const bool all = M.norm() < 1e-3 || !(M * PseudoInversePsd(M)).isIdentity(1e-6);
  std::vector<Mistake> mistakes;
  for (int cut = all ? m : m - 1; cut > 0; --cut) {
    mistakes.push_back({todo, DirectionCut(matrix), with(PseudoInversePsd(M, cut))});
  }
  return mistakes;
}

/// @param with  the answer with something else in place of M⁻¹
inline std::vector<Mistake> EliminationMistakes(const Elimination& of, const MatXX& rest, const MatXX& M,
                                                const MatXX& M_inverse,
                                                const std::function<MatXX(const MatXX& middle)>& with) {
  const MatXX product = rest - with(M_inverse);
  const auto alone = [&](const std::string& sign) {
    return Text("formula.rest_missing", {{"rest", Word(of.rest)}, {"that", Word(sign + of.product)}});
  };
  const char* const of_inverse = of.todo_of_inverse;
  const std::string root = of.matrix + std::string("^-½");
  return {{of_inverse, StandsFor(root.c_str(), of.inverse), with(RootOf(M_inverse))},
          {of.todo, {"formula.nothing_subtracted", {{"rest", Word(of.rest)}, {"that", Word(of.product)}}}, rest},
          {of.todo, SignAdded(of.product), rest + product, kOfSign},
          {of_inverse, MissingIn(of.inverse, of.product), with(MatXX::Identity(M.rows(), M.cols()))},
          {of_inverse, InverseMeant(of.matrix), with(M)},
          {of.todo, {"formula.inverse_twice", {{"inverse", Word(of.inverse)}}}, with(M_inverse * M_inverse)},
          {of.todo, alone("−"), -product},
          {of.todo, alone(""), product},
          {of_inverse,
           {"formula.only_diagonal_inverted", {{"matrix", Word(of.matrix)}}},
           with(M.diagonal().cwiseInverse().asDiagonal())},
          {of.todo,
           {"formula.only_diagonal_reduced", {{"rest", Word(of.rest)}}},
           rest.cols() > 1 ? MatXX(rest - MatXX(product.diagonal().asDiagonal())) : MatXX()}};
}

inline std::vector<Mistake> EliminationMistakesInSchur(const Elimination& of, const PartedSystem& s) {
  return EliminationMistakes(of, s.A_rr, s.A_mm, s.A_mm_inverse, [&](const MatXX& middle) { return s.Schur(middle); });
}
inline std::vector<Mistake> EliminationMistakesInReduced(const Elimination& of, const PartedSystem& s) {
  return EliminationMistakes(of, s.b_r, s.A_mm, s.A_mm_inverse, [&](const MatXX& middle) { return s.Reduced(middle); });
}

/// M⁻¹ (b − sum), the landmarks' step, in the stage's letters.
struct LandmarkStep {
  const char *todo, *inverse, *matrix;  ///< "1.2c", "H_mm⁻¹", "H_mm"
  const char *b, *sum, *step;           ///< "b_m", "H_mp Δx_p", "Δx_p"
  const char* multiplier;               ///< "tempHᵀ", which is H_mm⁻¹ H_mp
};

/// @param times  H_mp times something in place of Δx_p;  @param all  the whole step, out of the landmarks'
inline std::vector<Mistake> LandmarkStepMistakes(const LandmarkStep& of, const MatXX& M, const MatXX& M_inverse,
                                                 const VecX& b, const VecX& x_p, const std::vector<VecX>& for_x_p,
                                                 const std::function<VecX(const VecX& x)>& times,
                                                 const std::function<VecX(const VecX& of_landmarks)>& all) {
  const VecX sum = times(x_p), rest = b - sum;
  const std::string difference = std::string(of.b) + " − " + of.sum;
  const auto left = [&](const std::string& sign) {
    return Text("formula.rest_missing",
                {{"rest", Word(of.b)}, {"that", Word(sign + of.inverse + " " + std::string(of.sum))}});
  };
  const Text one_term("formula.inverse_on_one_term", {{"inverse", Word(of.inverse)}, {"that", Word(difference)}});
  std::vector<Mistake> mistakes{
      {of.todo, "formula.landmarks_not_move", all(VecX::Zero(b.size()))},
      {of.todo,
       {"formula.nothing_subtracted", {{"rest", Word(of.inverse + std::string(" ") + of.b)}, {"that", Word(of.sum)}}},
       all(M_inverse * b)},
      {of.todo, SignAdded(of.sum), all(M_inverse * (b + sum)), kOfSign},
      {of.todo, SignAdded(of.sum), all(b + sum)},
      {of.todo, "formula.sign_of_landmark_step", all(-M_inverse * rest)},
      {of.todo, Missing(of.inverse, difference.c_str()), all(rest)},
      {of.todo, InverseMeant(of.matrix), all(M * rest)},
      {of.todo, left("−"), all(-M_inverse * sum)},
      {of.todo, left(""), all(M_inverse * sum)},
      {of.todo, ActsTwice(of.inverse, of.multiplier), all(M_inverse * (b - M_inverse * sum))},
      {of.todo, one_term, all(M_inverse * b - sum)},
      {of.todo, one_term, all(b - M_inverse * sum)},
      {of.todo,
       {"formula.sign_of_term", {{"this", Word(of.b)}, {"that", Word(difference)}}},
       all(M_inverse * (-b - sum))},
      {of.todo, {"formula.inverse_twice", {{"inverse", Word(of.inverse)}}}, all(M_inverse * (M_inverse * rest))},
      {of.todo,
       {"formula.only_diagonal_inverted", {{"matrix", Word(of.matrix)}}},
       all(M.diagonal().cwiseInverse().cwiseProduct(rest))}};
  for (const VecX& x : for_x_p) mistakes.push_back({of.todo, StepMeant(of.step), all(M_inverse * (b - times(x)))});
  return mistakes;
}

inline void Append(const std::vector<Mistake>& more, std::vector<Mistake>* mistakes) {
  mistakes->insert(mistakes->end(), more.begin(), more.end());
}

}  // namespace ch5::homework
