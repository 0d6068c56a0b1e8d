#pragma once
/// In words: what goes wrong in any formula, and which damped system it is of.

#include "ch5_backend/solve/normal_equations.h"
#include "ch5_homework/judge/diagnosis.h"

namespace ch5::homework {

inline Text SignAdded(const char* term) { return {"formula.sign_added", {{"term", Word(term)}}}; }
inline Text InverseMeant(const char* matrix) { return {"formula.inverse_meant", {{"matrix", Word(matrix)}}}; }
inline Text DiagonalAlone(const char* matrix) { return {"formula.diagonal_alone", {{"matrix", Word(matrix)}}}; }
inline Text DirectionCut(const char* matrix) { return {"formula.known_direction_cut", {{"matrix", Word(matrix)}}}; }
inline Text NothingWritten(const char* matrix) { return {"formula.nothing_written", {{"matrix", Word(matrix)}}}; }
inline Text StandsFor(const char* it, const char* meant) {
  return {"formula.stands_for", {{"this", Word(it)}, {"that", Word(meant)}}};
}
inline Text StandsFor(const char* it, const char* meant, const char* formula) {
  return {"formula.stands_for_in", {{"this", Word(it)}, {"that", Word(meant)}, {"formula", Word(formula)}}};
}
inline Text ActsTwice(const char* it, const char* where) {
  return {"formula.acts_twice", {{"this", Word(it)}, {"that", Word(where)}}};
}

/// "b_" changed, in place of "b_schur_".
inline Text ChangedInPlace(const char* it, const char* meant) {
  return {"formula.changed_in_place", {{"this", Word(it)}, {"that", Word(meant)}}};
}

/// "Δx of the scene, λ = 0.5, D = diag(H)"
inline Text With(const Text& quantity, const Text& scene, double lambda, Damping damping) {
  return {damping == Damping::kIdentity ? "scene.with_lambda" : "scene.with_lambda_and_D",
          {{"quantity", quantity}, {"scene", scene}, {"l", Word(lambda)}}};
}

}  // namespace ch5::homework
