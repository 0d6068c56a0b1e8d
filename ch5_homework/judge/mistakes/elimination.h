#pragma once
/// What goes wrong wherever a part of a system is eliminated: stages 1.2, 2, 5, 6 and 7.

#include <functional>
#include <string>
#include <vector>

#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/mistakes/formula.h"

namespace ch5::homework {

/// rest − product, where the product holds the inverse of what goes, in the stage's letters.
struct Elimination {
  const char *todo, *todo_of_inverse;
  const char *rest, *product;    ///< "H_pp", "H_pm H_mm⁻¹ H_mp"
  const char *inverse, *matrix;  ///< "H_mm⁻¹", "H_mm"
};

/// @param with  the answer with something else in place of M⁻¹
inline std::vector<Mistake> EliminationMistakes(const Elimination& of, const MatXX& rest, const MatXX& M,
                                                const MatXX& M_inverse,
                                                const std::function<MatXX(const MatXX& middle)>& with) {
  const MatXX product = rest - with(M_inverse);
  const auto alone = [&](const std::string& sign) {
    return Text("formula.rest_missing", {{"rest", Word(of.rest)}, {"that", Word(sign + of.product)}});
  };
  const char* const of_inverse = of.todo_of_inverse;
  return {{of.todo, {"formula.nothing_subtracted", {{"rest", Word(of.rest)}, {"that", Word(of.product)}}}, rest},
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
      {of.todo, "formula.landmarks_not_move", all(VecX::Zero(b.size()))},
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
