#include "ch5_homework/judge/formula/rules.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "ch5_backend/math/psd.h"

namespace ch5::homework::formula {

Text Say(const char* id, std::initializer_list<std::pair<const char*, std::string>> words) {
  std::vector<Text::Argument> arguments;
  for (const auto& [name, word] : words) arguments.push_back({name, Word(word)});
  return {id, arguments};
}

const MatXX* Square(const Expression& x) {
  const auto& A = TryValue(x);
  return A && A->rows() == A->cols() && A->size() > 0 && A->allFinite() ? &*A : nullptr;
}

static const MatXX* Symmetric(const Expression& x) {
  const MatXX* const A = Square(x);
  return A != nullptr && A->isApprox(A->transpose(), 1e-9) ? A : nullptr;
}

/// The parts with others in place of `count` of them from k on.
static std::vector<Expression> Replaced(std::vector<Expression> parts, size_t k, size_t count,
                                        const std::vector<Expression>& by = {}) {
  const auto at = parts.begin() + static_cast<ptrdiff_t>(k);
  parts.insert(parts.erase(at, at + static_cast<ptrdiff_t>(count)), by.begin(), by.end());
  return parts;
}

/// The product of some of the factors.
static Expression Run(const Expression& product, size_t k, size_t length) {
  const auto at = product->parts.begin() + static_cast<ptrdiff_t>(k);
  return Product({at, at + static_cast<ptrdiff_t>(length)});
}

std::vector<Term> TermsOfSum(const Expression& x) {
  std::vector<Term> terms;
  if (x->kind == Kind::kSum) {
    for (size_t k = 0; k < x->parts.size(); ++k) {
      for (const Term& term : TermsOfSum(x->parts[k])) terms.push_back({x->factors[k] * term.factor, term.x});
    }
    return terms;
  }
  for (size_t k = 0; x->kind == Kind::kProduct && terms.empty() && k < x->parts.size(); ++k) {
    if (x->parts[k]->kind != Kind::kSum) continue;
    for (const Term& term : TermsOfSum(x->parts[k])) {
      terms.push_back({term.factor, Product(Replaced(x->parts, k, 1, {term.x}))});
    }
  }
  return terms.empty() ? std::vector<Term>{{1.0, x}} : terms;
}

// ---- sums ------------------------------------------------------------------------------------------------------------

static Expression Without(const Expression& sum, size_t k) {
  auto factors = sum->factors;
  factors.erase(factors.begin() + static_cast<ptrdiff_t>(k));
  return Sum(Replaced(sum->parts, k, 1), factors);
}

void TermMissing(const View& v) {
  if (v.x->kind != Kind::kSum || v.x->parts.size() < 2) return;
  for (size_t k = 0; k < v.x->parts.size(); ++k) {
    const Expression rest = Without(v.x, k);
    const std::string term = NameOf(v.x->parts[k]);
    if (v.x->factors[k] < 0.0) {
      v.report(Say("formula.nothing_subtracted", {{"rest", NameOf(rest)}, {"that", term}}), rest);
    } else {
      v.report(Say("formula.rest_missing", {{"rest", term}, {"that", NameOf(rest)}}), rest);
      if (v.x->parts.size() == 2)
        v.report(Say("formula.rest_missing", {{"rest", term}, {"that", NameOf(-rest)}}), -rest);
    }
  }
}

void TermOfOtherSign(const View& v) {
  if (v.x->kind != Kind::kSum || v.x->parts.size() < 2) return;
  for (size_t k = v.x->parts.size(); k-- > 0;) {
    auto factors = v.x->factors;
    factors[k] = -factors[k];
    const std::string term = NameOf(v.x->parts[k]);
    const Text cause = v.x->factors[k] < 0.0 ? Say("formula.sign_added", {{"term", term}})
                                             : Say("formula.sign_of_term", {{"this", term}, {"that", NameOf(v.x)}});
    v.report(cause, Sum(v.x->parts, factors));
  }
}

/// A (b − c) with A on one term only.
void BracketsMissing(const View& v) {
  if (v.x->kind != Kind::kProduct) return;
  for (size_t k = 0; k < v.x->parts.size(); ++k) {
    const Expression& sum = v.x->parts[k];
    if (sum->kind != Kind::kSum) continue;
    const std::string others = NameOf(Product(Replaced(v.x->parts, k, 1)));
    for (size_t only = 0; only < sum->parts.size(); ++only) {
      const Expression term = Product(Replaced(v.x->parts, k, 1, {sum->parts[only]}));
      v.report(Say("formula.inverse_on_one_term", {{"inverse", others}, {"that", NameOf(sum)}}),
               Sum(Replaced(sum->parts, only, 1, {term}), sum->factors));
    }
  }
}

/// A (a + c) or (a + A) c for a + A c.
void BracketsTooMany(const View& v) {
  if (v.x->kind != Kind::kSum || v.x->parts.size() < 2) return;
  for (size_t k = 0; k < v.x->parts.size(); ++k) {
    const Expression& term = v.x->parts[k];
    for (size_t first = 1; term->kind == Kind::kProduct && first < term->parts.size(); ++first) {
      const Expression before = Run(term, 0, first), behind = Run(term, first, term->parts.size() - first);
      const auto bracket = [&](const Expression& own) { return Sum(Replaced(v.x->parts, k, 1, {own}), v.x->factors); };
      const auto report = [&](const Expression& outside, const Expression& instead) {
        v.report(Say("formula.multiplies_all", {{"this", NameOf(outside)}, {"that", NameOf(v.x)}}), instead);
      };
      report(before, Product({before, bracket(behind)}));
      report(behind, Product({bracket(before), behind}));
    }
  }
}

// ---- products --------------------------------------------------------------------------------------------------------

/// One factor, or several in a row.
void FactorMissing(const View& v) {
  if (v.x->kind != Kind::kProduct) return;
  const size_t n = v.x->parts.size();
  for (size_t length = 1; length < n; ++length) {
    for (size_t k = 0; k + length <= n; ++k) {
      v.report(Say("formula.missing_in", {{"this", NameOf(Run(v.x, k, length))}, {"product", NameOf(v.x)}}),
               Product(Replaced(v.x->parts, k, length)));
    }
  }
}

void FactorTwice(const View& v) {
  if (v.x->kind != Kind::kProduct) return;
  for (size_t k = 0; k < v.x->parts.size(); ++k) {
    v.report(Say("formula.inverse_twice", {{"inverse", FactorName(v.x->parts[k])}}),
             Product(Replaced(v.x->parts, k, 0, {v.x->parts[k]})));
  }
}

/// The factors in any other order.
void FactorsInAnotherOrder(const View& v) {
  if (v.x->kind != Kind::kProduct || v.x->parts.size() > 4) return;
  std::vector<size_t> order(v.x->parts.size());
  std::iota(order.begin(), order.end(), 0u);
  while (std::next_permutation(order.begin(), order.end())) {
    std::vector<Expression> factors;
    for (const size_t k : order) factors.push_back(v.x->parts[k]);
    v.report(Say("formula.stands_for", {{"this", NameOf(Product(factors))}, {"that", NameOf(v.x)}}), Product(factors));
  }
}

/// Several factors in a row, which the student's code may hold in one variable.
void FactorsTransposed(const View& v) {
  if (v.x->kind != Kind::kProduct) return;
  const size_t n = v.x->parts.size();
  for (size_t length = 2; length <= n; ++length) {
    for (size_t k = 0; k + length <= n; ++k) {
      const Expression run = Run(v.x, k, length), turned = Transpose(run);
      v.report(Say("formula.stands_for", {{"this", NameOf(turned)}, {"that", NameOf(run)}}),
               Product(Replaced(v.x->parts, k, length, {turned})));
    }
  }
}

/// The product of two others that are at hand, one of which may be right: H_mp b_p for b_m.
void ProductForIt(const View& v) {
  const auto& A = v.x->kind == Kind::kMatrix ? TryValue(v.x) : std::nullopt;
  for (const Expression& a : A ? v.named : std::vector<Expression>()) {
    for (const Expression& c : v.named) {
      const Expression product = Product({a, c});
      const bool fits = TryValue(a) && TryValue(c) && TryValue(a)->rows() == A->rows() &&
                        TryValue(c)->cols() == A->cols() && TryValue(a)->cols() == TryValue(c)->rows();
      if (fits) v.report(Say("formula.stands_for", {{"this", NameOf(product)}, {"that", NameOf(v.x)}}), product);
    }
  }
}

/// Something else that is at hand, added to it or subtracted.
void TermTooMany(const View& v) {
  const auto& A = TryValue(v.x);
  for (const Expression& other : A && A->size() > 2 ? v.named : std::vector<Expression>()) {
    const auto& B = TryValue(other);
    if (!B || B->rows() != A->rows() || B->cols() != A->cols() || other == v.x) continue;
    const Text cause = Say("formula.term_too_many", {{"this", NameOf(other)}, {"that", NameOf(v.x)}});
    for (const Expression& instead : {v.x + other, v.x - other}) v.report(cause, instead);
  }
}

/// Something else that is at hand, between two factors, or at an end.
void FactorTooMany(const View& v) {
  if (v.x->kind != Kind::kProduct) return;
  for (const Expression& other : v.named) {
    for (const Expression& more : {other, Transpose(other)}) {
      for (size_t at = 0; at <= v.x->parts.size(); ++at) {
        v.report(Say("formula.factor_too_many", {{"this", NameOf(more)}, {"product", NameOf(v.x)}}),
                 Product(Replaced(v.x->parts, at, 0, {more})));
      }
    }
  }
}

// ---- inverses --------------------------------------------------------------------------------------------------------

void InverseForgotten(const View& v) {
  if (v.x->kind != Kind::kInverse) return;
  v.report(Say("formula.inverse_meant", {{"matrix", NameOf(v.x->parts[0])}}), v.x->parts[0]);
}

void InverseOfOneKindOnly(const View& v) {
  const MatXX* const A = v.x->kind == Kind::kInverse ? Square(v.x->parts[0]) : nullptr;
  if (A == nullptr || A->rows() == 1) return;
  const std::string name = FactorName(v.x->parts[0]);
  const auto instead = [&](const char* id, const MatXX& inverse) {
    v.report(Say(id, {{"matrix", name}}), Matrix(name + "⁻¹", inverse));
  };
  const MatXX one = MatXX::Identity(A->rows(), A->cols());
  instead("formula.only_diagonal_inverted", A->diagonal().cwiseInverse().asDiagonal());
  instead("formula.inverse_by_entries", A->cwiseInverse());
  for (const double number : {(*A)(0, 0), A->determinant(), A->trace(), A->norm()}) {
    instead("formula.divided_by_a_number", one / number);
  }
}

void RootOfInverse(const View& v) {
  const MatXX* const A = v.x->kind == Kind::kInverse ? Symmetric(v.x->parts[0]) : nullptr;
  if (A == nullptr) return;
  const std::string name = FactorName(v.x->parts[0]);
  const MatXX inverse = PseudoInversePsd(*A);
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(inverse);
  const VecX roots = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  v.report(Say("formula.stands_for", {{"this", name + "^-½"}, {"that", name + "⁻¹"}}),
           Matrix(name + "^-½", eigen.eigenvectors() * roots.asDiagonal() * eigen.eigenvectors().transpose()));
}

/// Directions that were measured count as not measured: the weakest; all, where that may be by units or by rank.
void DirectionsCut(const View& v) {
  const MatXX* const A = v.x->kind == Kind::kInverse ? Symmetric(v.x->parts[0]) : nullptr;
  if (A == nullptr) return;
  const bool weak = A->norm() < 1e-3 || !(*A * PseudoInversePsd(*A)).isIdentity(1e-6);
  const std::string name = NameOf(v.x->parts[0]);
  for (Index cut = A->rows() - (weak ? 0 : 1); cut > 0; --cut) {
    try {
      v.report(Say("formula.known_direction_cut", {{"matrix", name}}),
               Matrix(name + "⁻¹", PseudoInversePsd(*A, static_cast<int>(cut))));
    } catch (const std::invalid_argument&) {  // another direction is not positive
    }
  }
}

/// A small multiple of I added, against a matrix that might be singular, or to its inverse.
void MultipleOfIAdded(const View& v) {
  const bool is_inverse = v.x->kind == Kind::kInverse;
  const auto add = [&](const Expression& to, const std::function<Expression(const Expression&)>& with) {
    const MatXX* const A = Square(to);
    if (A == nullptr) return;
    for (double x = A->rows() == 1 ? 1e-3 : 1.0; x > 1e-13; x *= 0.1) {  // a large one of a number is any number
      const Expression more = Matrix(NameOf(to), *A + x * MatXX::Identity(A->rows(), A->cols()));
      v.report(Say("formula.multiple_of_I_added", {{"x", Number(x)}, {"matrix", NameOf(to)}}), with(more));
    }
  };
  if (is_inverse) add(v.x->parts[0], [](const Expression& more) { return Inverse(more); });
  if (is_inverse || v.x->source || (v.x->kind == Kind::kProduct && !v.is_whole))
    add(v.x, [](const Expression& more) { return more; });
}

/// The inverse of another matrix, there or elsewhere in the product.
void InverseOfAnother(const View& v) {
  const bool is_product = v.x->kind == Kind::kProduct;
  for (const Expression& x : is_product ? v.x->parts : std::vector<Expression>{v.x}) {
    if (x->kind != Kind::kInverse) continue;
    for (const Expression& other : v.named) {
      if (other->kind == Kind::kInverse || NameOf(other) == NameOf(x->parts[0]) || !Square(other)) continue;
      const auto report = [&](const Expression& instead) {
        v.report(Say("formula.stands_for", {{"this", NameOf(instead)}, {"that", NameOf(v.x)}}), instead);
      };
      if (!is_product) report(Inverse(other));
      for (size_t at = 0; is_product && at < v.x->parts.size(); ++at) {  // where its size fits
        auto factors = v.x->parts;
        factors.erase(std::find(factors.begin(), factors.end(), x));
        report(Product(Replaced(factors, at, 0, {Inverse(other)})));
      }
    }
  }
}

/// Where a matrix is singular, its inverse is not finite, and so is what it is a part of.
void InverseOfSingular(const View& v) {
  const MatXX* const A = v.x->kind == Kind::kInverse ? Symmetric(v.x->parts[0]) : nullptr;
  if (A == nullptr || v.got.allFinite() || (*A * PseudoInversePsd(*A)).isIdentity(1e-6)) return;
  v.report(Say("formula.inverse_of_singular", {{"matrix", NameOf(v.x->parts[0])}}), nullptr);
}

/// Of an inverse that is made block by block, the first or the last block for all.
void InverseOfOneBlock(const View& v) {
  const std::vector<int>& sizes = v.x->sizes;
  if (v.x->kind != Kind::kInverse || sizes.size() < 2 || !TryValue(v.x)) return;
  const Index size = sizes[0], last = static_cast<Index>(sizes.size()) - 1;
  if (!std::all_of(sizes.begin(), sizes.end(), [&](int other) { return other == size; })) return;
  const std::string name = FactorName(v.x);
  for (const Index number : {Index{0}, last}) {
    MatXX inverse = *TryValue(v.x);
    const MatXX block = inverse.block(number * size, number * size, size, size);
    for (Index k = 0; k <= last; ++k) inverse.block(k * size, k * size, size, size) = block;
    v.report(Say("formula.one_block_for_all", {{"n", std::to_string(number)}, {"matrix", name}}),
             Matrix(name, inverse));
  }
}

/// (H⁻¹)_mm for (H_mm)⁻¹.
void BlockOfTheInverse(const View& v) {
  if (v.x->kind != Kind::kInverse || !v.x->parts[0]->source) return;
  const Node& block = *v.x->parts[0];
  const MatXX& A = block.source->A;
  if (A.rows() != A.cols() || block.value.rows() != block.value.cols() || block.value.rows() == A.rows()) return;
  const Index n = block.value.rows();
  v.report(Say("formula.block_of_the_inverse", {{"block", block.name}, {"matrix", block.source->name}}),
           Matrix(block.name + "⁻¹", PseudoInversePsd(A).block(block.row, block.column, n, n)));
}

// ---- the whole -------------------------------------------------------------------------------------------------------

/// How often each term is in A, by least squares.
static VecX CountsIn(const MatXX& A, const std::vector<Term>& terms) {
  MatXX basis(A.size(), terms.size());
  for (Index k = 0; k < basis.cols(); ++k) basis.col(k) = TryValue(terms[static_cast<size_t>(k)].x)->reshaped();
  const VecX scale = basis.colwise().norm().cwiseMax(1e-300).cwiseInverse().transpose();
  const MatXX scaled = basis * scale.asDiagonal();
  return scale.asDiagonal() * (PseudoInversePsd(scaled.transpose() * scaled) * (scaled.transpose() * A.reshaped()));
}

constexpr double kMostTimes = 1e3;  // that anybody counts a term; more: numbers of another unit, or of an earlier call

/// Whether an earlier answer, which was right, had this term of so many: what was zero there has shown no count.
static bool WasShown(const View& v, size_t number, size_t count) {
  return std::any_of(v.earlier.begin(), v.earlier.end(), [&](const Formula& one) {
    const std::vector<Term> terms = TermsOfSum(one.right);
    if (NameOf(one.right) != NameOf(v.formula.right) || terms.size() != count) return false;
    const auto& A = TryValue(terms[number].x);
    return A && !A->isZero(0.0);
  });
}

/// How often A has each term.
struct Counts {
  VecX counts, times;        ///< as they stand in the sum; beside the right ones
  std::vector<Index> wrong;  ///< which terms
};

/// Half and whole numbers, or any of one term; nothing if such counts do not explain A.
static std::optional<Counts> CountTerms(const MatXX& A, const std::vector<Term>& terms) {
  Counts found{CountsIn(A, terms), VecX(terms.size()), {}};
  int odd_ones = 0;
  for (Index k = 0; k < found.counts.size(); ++k) {
    const double factor = terms[static_cast<size_t>(k)].factor, half = 0.5 * std::round(2.0 * found.counts[k]);
    double& count = found.counts[k];
    const bool is_half = std::abs(count - half) < 1e-6;
    if (is_half) count = half;
    if (!is_half && std::abs(count / factor - 1.0) < 1e-3) return std::nullopt;  // no count, but another small error
    odd_ones += !is_half;
    found.times[k] = count / factor + 0.0;  // no −0
    if (count != factor) found.wrong.push_back(k);
  }
  const bool are_too_odd = odd_ones > 0 && found.wrong.size() > 1;
  if (found.counts.isZero(0.0) || are_too_odd || found.times.cwiseAbs().maxCoeff() > kMostTimes) return std::nullopt;
  return found;
}

static void ReportCounts(const View& v, const std::vector<Term>& terms, const Counts& found) {
  std::vector<Expression> parts;
  std::vector<double> factors;
  for (Index k = 0; k < found.counts.size(); ++k) {
    if (found.counts[k] == 0.0) continue;
    parts.push_back(terms[static_cast<size_t>(k)].x);
    factors.push_back(found.counts[k]);
  }
  const Expression instead = Sum(parts, factors);
  if (found.wrong.size() > 1) {
    return v.report(Say("formula.combination", {{"this", NameOf(instead)}, {"that", NameOf(v.x)}}), instead);
  }
  const auto k = static_cast<size_t>(found.wrong[0]);
  v.report(Say(WasShown(v, k, terms.size()) ? "formula.term_times_here" : "formula.term_times",
               {{"term", NameOf(terms[k].x)}, {"k", Number(found.times[found.wrong[0]])}}),
           instead);
}

/// A rule for each part of a stack by itself.
static void InEachPart(Rule rule, const View& v) {
  Index row = 0;
  for (size_t k = 0; k < v.x->parts.size(); ++k) {
    const MatXX own = v.got.middleRows(row, std::min(Value(v.x->parts[k]).rows(), v.got.rows() - row));
    row += own.rows();
    rule({v.x->parts[k], true, v.formula, own, v.named, v.earlier, [&](const Text& cause, const Expression& part) {
            v.report(cause, Stack(Replaced(v.x->parts, k, 1, {part})));
          }});
  }
}

/// The terms so many times each.
void TermsOfOtherCounts(const View& v) {
  if (!v.is_whole) return;
  if (v.x->kind == Kind::kStack) return InEachPart(&TermsOfOtherCounts, v);
  const auto& right = TryValue(v.x);
  if (v.formula.right->kind == Kind::kSeen || !right || !v.got.allFinite()) return;
  if (right->rows() != v.got.rows() || right->cols() != v.got.cols()) return;
  const std::vector<Term> terms = TermsOfSum(v.x);
  const auto n = static_cast<Index>(terms.size());
  if (n < 2 || v.got.size() <= n) return;
  const auto found = CountTerms(v.got, terms);
  if (!found) return;
  if ((found->times.array() != found->times[0]).any()) return ReportCounts(v, terms, *found);
  if (v.formula.right->kind != Kind::kStack) return;  // of the whole that is said elsewhere
  v.report(Say("formula.term_times", {{"term", NameOf(v.x)}, {"k", Number(found->times[0])}}), found->times[0] * v.x);
}

// ---- the table -------------------------------------------------------------------------------------------------------

const std::vector<Rule>& Rules(bool unlikely) {
  static const std::vector<Rule> first{
      &PartZero,          &InverseOfSingular,     &TermOfOtherSign,    &TermMissing,   &FactorMissing,
      &BracketsMissing,   &BracketsTooMany,       &InverseForgotten,   &FactorTwice,   &InverseOfOneKindOnly,
      &AnotherSource,     &InverseOfOneBlock,     &TransposeForgotten, &AnotherForIt,  &Transposed,
      &FactorsTransposed, &FactorsInAnotherOrder, &InverseOfAnother,   &PartsOfATerm,  &PartsOfABlock,
      &DirectionsCut,     &OnlyDiagonal,          &OnlyTriangle,       &RootOfInverse, &Inverted,
      &BlockOfTheInverse, &AnotherPlace,          &MultipleOfIAdded,   &TurnsOfALoop,  &SharesOfAKind,
      &SharesElsewhere};
  static const std::vector<Rule> last{&FactorTooMany, &Converted,           &TermsOfOtherCounts, &SharesOffByOne,
                                      &ShareTooMany,  &ShareAtAnotherPlace, &ProductForIt,       &TermTooMany};
  return unlikely ? last : first;
}

}  // namespace ch5::homework::formula
