#pragma once
/// What a slip in a formula gives: each rule changes one node of it, as students do, and says so in a sentence.
///
/// In another course, about another formula, say y = A⁻¹ (b − C x):
///
///   const Source A("A", …), b("b", …);                          1  what is read, and where
///   const Formula y{Inverse(A.Block("A", 0, 0, n, n)) *         2  the right formula: its value is the right answer
///                       (b.Segment("b", 0, n) - Matrix("C", …) * Matrix("x", …)),
///                   {Matrix("z", …)}};                             and what else the student has at hand
///   FindSlip(y, got, is_it)                                     3  {"formula.missing_in", this: "C", product: "C x"}
///
/// The cause is an id and words; the sentence is the course's ("{this} is missing in {product}"). What may be read from a
/// wrong matrix instead (undamped, before rows were moved) belongs to its Source, with a name; a sum that a loop adds up,
/// edge by edge, is an Assembly, whose shares of one name change together, as one statement of the loop does.
///
/// How rules are made, and one more added: rules.h. The search puts what a rule reports in its place, once and wherever else the
/// same node is used, evaluates what comes out, and compares.
///
/// One slip at a time, or the same one wherever a block is used; and of a sum, terms with other whole or half factors, as
/// long as it has many more numbers than terms. Two independent slips would explain too much.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/formula/expression.h"

namespace ch5::homework::formula {

/// What a student has to compute.
struct Formula {
  Expression right;                      ///< its value is the right answer
  std::vector<Expression> beside = {};   ///< what else is at hand, and may be taken by mistake
  std::vector<Expression> as_well = {};  ///< other ways to the right answer
  std::vector<Part> rows = {};           ///< parts of the answer
  bool listed_alone = false;             ///< no rule knows slips in it, only its own MistakenFor
};

/// The likeliest slip whose answer is `got`.
/// @param is       whether an answer is what the student has
/// @param earlier  formulas of earlier calls, whose answers were right: a slip that would have shown there is none, and from the
///                 first one a static variable may have its value
/// @param is_asked no slip but those with such a cause, unless it is empty
std::optional<Mistake> FindSlip(const Formula& formula, const MatXX& got,
                                const std::function<bool(const MatXX& answer)>& is,
                                const std::vector<Formula>& earlier = {},
                                const std::function<bool(const Text& cause)>& is_asked = {});

/// "(3, 4): H_pp gives 2.5, −H_pm H_mm⁻¹ H_mp gives −1": what the terms of a sum give to an entry; nothing of other formulas.
Text TermsOf(const Expression& x, Eigen::Index row, Eigen::Index column);

}  // namespace ch5::homework::formula
