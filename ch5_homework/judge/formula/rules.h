#pragma once
/// The rules by which slips are made. A rule is a function: it sees one node of the right formula, and reports what a student
/// may have written there instead, with a sentence. The search (slips.cc) puts it there and compares what comes out.
///
/// To add one:
///   1  the function, in the file of its kind: rules.cc (sums, products, inverses, the whole), rules_of_blocks.cc (the parts
///      of a formula, and where they are read), rules_of_loops.cc (what edges or landmarks add up to)
///   2  its declaration below, and its row in the table of rules.cc, the likelier ones above
///   3  its sentence in ch5_backend/course/base/language/{en,zh}.json, under "formula"
///   4  a line in tests/homework/formula_test.cc: the wrong answer, and the sentence that it must get
/// A rule knows no course: whatever is particular to one (what may be taken for a matrix, where a block may land) belongs to
/// the expression.

#include <functional>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "ch5_homework/judge/formula/slips.h"

namespace ch5::homework::formula {

using Index = Eigen::Index;

/// What a rule sees, and reports.
struct View {
  const Expression& x;
  bool is_whole;  ///< x is the formula
  const Formula& formula;
  const MatXX& got;
  const std::vector<Expression>& named;  ///< all that has a name: blocks, and what is beside
  const std::vector<Formula>& earlier;   ///< of calls whose answers were right
  std::function<void(const Text& cause, const Expression& instead)> report;
};
using Rule = void (*)(const View& v);

/// The likelier ones first.  @param unlikely  those that explain much by what happens to be at hand, after all others
const std::vector<Rule>& Rules(bool unlikely);

// rules.cc
void TermMissing(const View& v);
void TermOfOtherSign(const View& v);
void BracketsMissing(const View& v);
void BracketsTooMany(const View& v);
void FactorMissing(const View& v);
void FactorTwice(const View& v);
void FactorTooMany(const View& v);
void ProductForIt(const View& v);
void TermTooMany(const View& v);
void FactorsInAnotherOrder(const View& v);
void FactorsTransposed(const View& v);
void InverseForgotten(const View& v);
void InverseOfOneKindOnly(const View& v);
void RootOfInverse(const View& v);
void DirectionsCut(const View& v);
void MultipleOfIAdded(const View& v);
void InverseOfAnother(const View& v);
void InverseOfSingular(const View& v);
void InverseOfOneBlock(const View& v);
void BlockOfTheInverse(const View& v);
void TermsOfOtherCounts(const View& v);
// rules_of_blocks.cc
void AnotherForIt(const View& v);
void TransposeForgotten(const View& v);
void Transposed(const View& v);
void Inverted(const View& v);
void OnlyDiagonal(const View& v);
void OnlyTriangle(const View& v);
void Converted(const View& v);
void PartsOfABlock(const View& v);
void PartsOfATerm(const View& v);
void PartZero(const View& v);
void AnotherSource(const View& v);
void AnotherPlace(const View& v);
// rules_of_loops.cc
void TurnsOfALoop(const View& v);
void SharesOfAKind(const View& v);
void SharesElsewhere(const View& v);
void SharesOffByOne(const View& v);
void ShareTooMany(const View& v);
void ShareAtAnotherPlace(const View& v);

// ---- what rules and the search have in common ------------------------------------------------------------------------

/// A sentence about names.
Text Say(const char* id, std::initializer_list<std::pair<const char*, std::string>> words);

/// The value of x if it is square and finite, else null.
const MatXX* Square(const Expression& x);

/// As much of another matrix as `block` is of its own.
Expression ElsewhereIn(const MatXX& A, const Node& block, Index row, Index column);

struct Term {
  double factor;
  Expression x;
};
/// The terms of a sum, also behind a factor: A (b − c) has A b and A c.
std::vector<Term> TermsOfSum(const Expression& x);

bool IsOfKind(const Share& share, const Text& kind);
/// All kinds of an assembly's shares.
std::vector<Text> KindsOf(const Expression& assembly);
/// Where a student writes all shares of a kind; "" if at no place of their own.
std::string TodoOf(const std::vector<Share>& shares, const Text& kind);

}  // namespace ch5::homework::formula
