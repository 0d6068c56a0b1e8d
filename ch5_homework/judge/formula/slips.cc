#include "ch5_homework/judge/formula/slips.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>

#include "ch5_backend/math/psd.h"

namespace ch5::homework::formula {
namespace {

using Index = Eigen::Index;

Text Say(const char* id, std::initializer_list<std::pair<const char*, std::string>> words) {
  std::vector<Text::Argument> arguments;
  for (const auto& [name, word] : words) arguments.push_back({name, Word(word)});
  return {id, arguments};
}

/// What a rule sees, and reports.
struct View {
  const Expression& x;
  bool is_whole;  ///< x is the formula
  const Formula& formula;
  const MatXX& got;
  const std::vector<Expression>& named;  ///< all that has a name: blocks, and what is beside
  std::function<void(const Text& cause, const Expression& instead)> report;
};

// ---- sums ------------------------------------------------------------------------------------------------------------

Expression Without(const Expression& sum, size_t k) {
  auto terms = sum->parts;
  auto factors = sum->factors;
  terms.erase(terms.begin() + static_cast<ptrdiff_t>(k));
  factors.erase(factors.begin() + static_cast<ptrdiff_t>(k));
  return Sum(terms, factors);
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
    for (size_t only = 0; only < sum->parts.size(); ++only) {
      auto factors = v.x->parts;
      factors[k] = sum->parts[only];
      auto terms = sum->parts;
      terms[only] = Product(factors);
      factors.erase(factors.begin() + static_cast<ptrdiff_t>(k));
      v.report(Say("formula.inverse_on_one_term", {{"inverse", NameOf(Product(factors))}, {"that", NameOf(sum)}}),
               Sum(terms, sum->factors));
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
      const auto begin = v.x->parts.begin() + static_cast<ptrdiff_t>(k);
      auto rest = v.x->parts;
      rest.erase(rest.begin() + static_cast<ptrdiff_t>(k), rest.begin() + static_cast<ptrdiff_t>(k + length));
      const std::string missing = NameOf(Product({begin, begin + static_cast<ptrdiff_t>(length)}));
      v.report(Say("formula.missing_in", {{"this", missing}, {"product", NameOf(v.x)}}), Product(rest));
    }
  }
}

void FactorTwice(const View& v) {
  if (v.x->kind != Kind::kProduct) return;
  for (size_t k = 0; k < v.x->parts.size(); ++k) {
    auto twice = v.x->parts;
    twice.insert(twice.begin() + static_cast<ptrdiff_t>(k), v.x->parts[k]);
    v.report(Say("formula.inverse_twice", {{"inverse", FactorName(v.x->parts[k])}}), Product(twice));
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
      const auto begin = v.x->parts.begin() + static_cast<ptrdiff_t>(k), end = begin + static_cast<ptrdiff_t>(length);
      const Expression run = Product({begin, end});
      std::vector<Expression> factors(v.x->parts.begin(), begin);
      factors.push_back(Transpose(run));
      factors.insert(factors.end(), end, v.x->parts.end());
      v.report(Say("formula.stands_for", {{"this", NameOf(Transpose(run))}, {"that", NameOf(run)}}), Product(factors));
    }
  }
}

// ---- inverses --------------------------------------------------------------------------------------------------------

const MatXX* Square(const Expression& x) {
  const auto& A = TryValue(x);
  return A && A->rows() == A->cols() && A->size() > 0 && A->allFinite() ? &*A : nullptr;
}

void InverseForgotten(const View& v) {
  if (v.x->kind != Kind::kInverse) return;
  v.report(Say("formula.inverse_meant", {{"matrix", NameOf(v.x->parts[0])}}), v.x->parts[0]);
}

void InverseOfOneKindOnly(const View& v) {
  const MatXX* const A = v.x->kind == Kind::kInverse ? Square(v.x->parts[0]) : nullptr;
  if (A == nullptr || A->rows() == 1) return;
  const std::string name = NameOf(v.x->parts[0]);
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
  const MatXX* const A = v.x->kind == Kind::kInverse ? Square(v.x->parts[0]) : nullptr;
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
  const MatXX* const A = v.x->kind == Kind::kInverse ? Square(v.x->parts[0]) : nullptr;
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
  const MatXX* const A = Square(v.x);
  const bool may = v.x->kind == Kind::kInverse || (v.x->kind == Kind::kMatrix && v.x->source);
  if (A == nullptr || !may) return;
  const std::string name = NameOf(v.x);
  for (double x = 1.0; x > 1e-13; x *= 0.1) {
    const MatXX more = *A + x * MatXX::Identity(A->rows(), A->cols());
    v.report(Say("formula.multiple_of_I_added", {{"x", Number(x)}, {"matrix", name}}), Matrix(name, more));
  }
}

/// The inverse of another matrix.
void InverseOfAnother(const View& v) {
  if (v.x->kind != Kind::kInverse) return;
  for (const Expression& other : v.named) {
    if (other->kind == Kind::kInverse || NameOf(other) == NameOf(v.x->parts[0]) || !Square(other)) continue;
    v.report(Say("formula.stands_for", {{"this", NameOf(Inverse(other))}, {"that", NameOf(v.x)}}), Inverse(other));
  }
}

/// Where a matrix is singular, its inverse is not finite, and so is what it is a part of.
void InverseOfSingular(const View& v) {
  const MatXX* const A = v.x->kind == Kind::kInverse ? Square(v.x->parts[0]) : nullptr;
  if (A == nullptr || v.got.allFinite() || (*A * PseudoInversePsd(*A)).isIdentity(1e-6)) return;
  v.report(Say("formula.inverse_of_singular", {{"matrix", NameOf(v.x->parts[0])}}), nullptr);
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

// ---- the parts of a formula ------------------------------------------------------------------------------------------

bool CanBeMistaken(const View& v) {
  return v.x->kind == Kind::kMatrix || v.x->kind == Kind::kInverse || !v.x->name.empty() || v.is_whole;
}

Text StandsFor(const View& v, const std::string& name) {
  if (v.is_whole) return Say("formula.result_is", {{"this", name}, {"that", NameOf(v.x)}});
  return Say("formula.stands_for", {{"this", name}, {"that", NameOf(v.x)}});
}

void AnotherForIt(const View& v) {
  if (!CanBeMistaken(v)) return;
  const std::string own = NameOf(v.x);
  for (const Expression& other : v.x->mistaken) v.report(StandsFor(v, NameOf(other)), other);
  for (const bool transposed : {false, true}) {
    for (const Expression& other : v.named) {
      const auto& A = TryValue(other);
      if (!A || NameOf(other) == own) continue;
      if (transposed && A->rows() != A->cols() && (!TryValue(v.x) || A->cols() != TryValue(v.x)->rows())) continue;
      const Expression instead = transposed ? Transpose(other) : other;
      if (NameOf(instead) != own) v.report(StandsFor(v, NameOf(instead)), instead);
    }
  }
}

void TransposeForgotten(const View& v) {
  if (v.x->kind == Kind::kTranspose) v.report(StandsFor(v, NameOf(v.x->parts[0])), v.x->parts[0]);
}

void Transposed(const View& v) {
  if (!CanBeMistaken(v) || !TryValue(v.x) || TryValue(v.x)->rows() == 1 || TryValue(v.x)->cols() == 1) return;
  v.report(StandsFor(v, FactorName(v.x) + "ᵀ"), Transpose(v.x));
}

void Inverted(const View& v) {
  if (v.x->kind == Kind::kInverse || !CanBeMistaken(v) || !Square(v.x)) return;
  v.report(StandsFor(v, FactorName(v.x) + "⁻¹"), Inverse(v.x));
}

void OnlyDiagonal(const View& v) {
  const MatXX* const A = Square(v.x);
  if (A == nullptr || A->rows() == 1) return;
  v.report(Say("formula.diagonal_alone", {{"matrix", NameOf(v.x)}}), Matrix(NameOf(v.x), A->diagonal().asDiagonal()));
}

void OnlyTriangle(const View& v) {
  const MatXX* const A = Square(v.x);
  if (A == nullptr || A->rows() == 1 || v.is_whole) return;
  for (const MatXX& half : {MatXX(A->triangularView<Eigen::Upper>()), MatXX(A->triangularView<Eigen::Lower>())}) {
    v.report(Say("formula.one_triangle_alone", {{"matrix", NameOf(v.x)}}), Matrix(NameOf(v.x), half));
  }
}

// ---- parts of a block, or of a term ----------------------------------------------------------------------------------

/// The parts that [begin, begin + size) consists of, counted from there.
std::vector<Part> PartsWithin(const std::vector<Part>& all, Index begin, Index size) {
  std::vector<Part> parts;
  for (const Part& part : all) {
    if (part.begin >= begin && part.begin + part.size <= begin + size) {
      parts.push_back({part.name, part.begin - begin, part.size});
    }
  }
  return parts;
}

void OnlyOnePart(const View& v, const MatXX& A, const std::vector<Part>& parts, bool of_columns) {
  if (parts.size() < 2) return;
  for (const Part& part : parts) {
    MatXX alone = MatXX::Zero(A.rows(), A.cols()), rest = A;
    if (of_columns) {
      alone.middleCols(part.begin, part.size) = A.middleCols(part.begin, part.size);
      rest.middleCols(part.begin, part.size).setZero();
    } else {
      alone.middleRows(part.begin, part.size) = A.middleRows(part.begin, part.size);
      rest.middleRows(part.begin, part.size).setZero();
    }
    const Text name = Word(NameOf(v.x));
    v.report({"formula.one_part_alone", {{"part", part.name}, {"matrix", name}}}, Matrix(NameOf(v.x), alone));
    v.report({"formula.part_left_out", {{"part", part.name}, {"matrix", name}}}, Matrix(NameOf(v.x), rest));
  }
}

void PartsOfABlock(const View& v) {
  if (!v.x->source) return;
  const auto& parts = v.x->source->parts;
  OnlyOnePart(v, v.x->value, PartsWithin(parts, v.x->row, v.x->value.rows()), false);
  if (v.x->source->A.cols() > 1) {
    OnlyOnePart(v, v.x->value, PartsWithin(parts, v.x->column, v.x->value.cols()), true);
  }
}

/// Of a term as large as the answer: the rows of one part, its block on the diagonal, or all these.
void PartsOfATerm(const View& v) {
  const std::vector<Part>& rows = v.formula.rows;
  const auto& A = TryValue(v.x);
  if (rows.size() < 2 || v.is_whole || v.x->kind != Kind::kProduct || !A || A->rows() != v.got.rows()) return;
  OnlyOnePart(v, *A, rows, false);
  if (A->rows() != A->cols()) return;
  OnlyOnePart(v, *A, rows, true);
  const Text name = Word(NameOf(v.x));
  MatXX diagonal = MatXX::Zero(A->rows(), A->cols());
  for (const Part& part : rows) {
    MatXX block = MatXX::Zero(A->rows(), A->cols());
    block.block(part.begin, part.begin, part.size, part.size) = A->block(part.begin, part.begin, part.size, part.size);
    diagonal += block;
    v.report({"formula.one_part_alone", {{"part", part.name}, {"matrix", name}}}, Matrix(NameOf(v.x), block));
  }
  v.report({"formula.diagonal_blocks_alone", {{"matrix", name}}}, Matrix(NameOf(v.x), diagonal));
  v.report({"formula.diagonal_blocks_left_out", {{"matrix", name}}}, Matrix(NameOf(v.x), *A - diagonal));
}

void PartZero(const View& v) {
  if (v.x->kind != Kind::kStack) return;
  for (const Expression& part : v.x->parts) {
    auto parts = v.x->parts;
    std::replace(parts.begin(), parts.end(), part, 0.0 * part);
    v.report(Say("formula.part_is_zero", {{"part", NameOf(part)}}), Stack(parts));
  }
}

// ---- places and sources ----------------------------------------------------------------------------------------------

Expression ElsewhereIn(const MatXX& A, const Node& block, Index row, Index column) {
  return Matrix(block.name, A.block(row, column, block.value.rows(), block.value.cols()));
}

void AnotherSource(const View& v) {
  if (!v.x->source) return;
  for (const Source::Other& other : v.x->source->others) {
    if (other.A.rows() != v.x->source->A.rows() || other.A.cols() != v.x->source->A.cols()) continue;
    v.report({"formula.from_another_source",
              {{"block", Word(v.x->name)}, {"other", other.name}, {"matrix", Word(v.x->source->name)}}},
             ElsewhereIn(other.A, *v.x, v.x->row, v.x->column));
  }
}

Text StartsAt(const Node& block, Index row, Index column) {
  if (block.source->A.cols() == 1) {
    return Say("formula.starts_at_entry", {{"block", block.name},
                                           {"matrix", block.source->name},
                                           {"i", std::to_string(row)},
                                           {"row", std::to_string(block.row)}});
  }
  return Say("formula.starts_at", {{"block", block.name},
                                   {"matrix", block.source->name},
                                   {"i", std::to_string(row)},
                                   {"j", std::to_string(column)},
                                   {"row", std::to_string(block.row)},
                                   {"column", std::to_string(block.column)}});
}

/// All places where the block fits, the nearer first; in the right source, then in others.
void AnotherPlace(const View& v) {
  if (!v.x->source) return;
  const Node& block = *v.x;
  const MatXX& A = block.source->A;
  std::vector<std::pair<Index, Index>> places;
  for (Index i = 0; i + block.value.rows() <= A.rows(); ++i) {
    for (Index j = 0; j + block.value.cols() <= A.cols(); ++j) {
      if (i != block.row || j != block.column) places.emplace_back(i, j);
    }
  }
  const auto far = [&](const std::pair<Index, Index>& place) {
    return std::abs(place.first - block.row) + std::abs(place.second - block.column);
  };
  std::stable_sort(places.begin(), places.end(), [&](const auto& a, const auto& b) { return far(a) < far(b); });
  for (const auto& [i, j] : places) v.report(StartsAt(block, i, j), ElsewhereIn(A, block, i, j));
  for (const Source::Other& other : block.source->others) {
    if (other.A.rows() != A.rows() || other.A.cols() != A.cols()) continue;
    for (const auto& [i, j] : places) v.report(StartsAt(block, i, j), ElsewhereIn(other.A, block, i, j));
  }
}

// ---- loops that add up -----------------------------------------------------------------------------------------------

bool IsOfKind(const Share& share, const Text& kind) {
  return std::any_of(share.kinds.begin(), share.kinds.end(),
                     [&](const Text& one) { return one.Json() == kind.Json(); });
}

/// An assembly with `change` of the shares that are of this kind, or of all.
template <typename Change>
Expression WithShares(const Expression& x, const Text* kind, const Change& change) {
  std::vector<Share> shares;
  for (const Share& share : x->shares) {
    const bool is = kind == nullptr || IsOfKind(share, *kind);
    Share changed = share;
    if (change(is, &changed)) shares.push_back(changed);
  }
  return Assembly(x->name, x->rows, x->columns, shares);
}

std::vector<Text> KindsOf(const Expression& assembly) {
  std::vector<Text> kinds;
  std::set<std::string> seen;
  for (const Share& share : assembly->shares) {
    for (const Text& kind : share.kinds) {
      if (seen.insert(kind.Json()).second) kinds.push_back(kind);
    }
  }
  return kinds;
}

void SharesOfAKind(const View& v) {
  if (v.x->kind != Kind::kAssembly) return;
  const Text matrix = Word(v.x->name);
  const auto report = [&](const char* id, const Text& kind, const auto& change) {
    v.report({id, {{"kind", kind}, {"matrix", matrix}}}, WithShares(v.x, &kind, change));
  };
  for (const Text& kind : KindsOf(v.x)) {
    report("formula.shares_missing", kind, [](bool is, Share*) { return !is; });
    report("formula.shares_alone", kind, [](bool is, Share*) { return is; });
    for (const double times : {2.0, -1.0}) {
      report(times > 0.0 ? "formula.shares_twice" : "formula.shares_of_other_sign", kind, [=](bool is, Share* share) {
        if (is) share->x = times * share->x;
        return true;
      });
    }
    report("formula.shares_transposed", kind, [](bool is, Share* share) {
      const MatXX& A = Value(share->x);
      if (is && A.rows() == A.cols()) share->x = Transpose(share->x);
      return true;
    });
    report("formula.shares_assigned", kind, [](bool is, Share* share) {
      share->assigned = is;
      return true;
    });
  }
  for (const double sign : {1.0, -1.0}) {  // = for += and for −=
    v.report({"formula.assigned", {{"matrix", matrix}}}, WithShares(v.x, nullptr, [=](bool, Share* share) {
               share->assigned = true;
               if (sign < 0.0) share->x = -share->x;
               return true;
             }));
  }
}

/// At other places: all shares, or those of one kind.
void SharesElsewhere(const View& v) {
  if (v.x->kind != Kind::kAssembly) return;
  struct Move {
    Text name;
    int turn;  // a share may have several places of one name
  };
  std::vector<Move> moves;
  std::set<std::string> seen;
  for (const Share& share : v.x->shares) {
    std::map<std::string, int> turns;
    for (const auto& other : share.elsewhere) {
      const int turn = turns[other.name.Json()]++;
      if (seen.insert(other.name.Json() + std::to_string(turn)).second) moves.push_back({other.name, turn});
    }
  }
  const std::vector<Text> kinds = KindsOf(v.x);
  for (const auto& [name, turn] : moves) {
    const auto move = [&, wanted = &name, last = turn](bool is, Share* share) {
      int now = 0;
      for (const auto& other : share->elsewhere) {
        if (is && other.name.Json() == wanted->Json() && now++ == last) share->place = other.place;
      }
      return true;
    };
    v.report(name, WithShares(v.x, nullptr, move));
    for (const Text& kind : kinds) {
      v.report({"formula.in_kind", {{"kind", kind}, {"cause", name}}}, WithShares(v.x, &kind, move));
    }
  }
}

// ---- the whole -------------------------------------------------------------------------------------------------------

struct Term {
  double factor;
  Expression x;
};

/// The terms of a sum, also behind a factor: A (b − c) has A b and A c.
std::vector<Term> TermsOfSum(const Expression& x) {
  std::vector<Term> terms;
  if (x->kind == Kind::kSum) {
    for (size_t k = 0; k < x->parts.size(); ++k) {
      for (const Term& term : TermsOfSum(x->parts[k])) terms.push_back({x->factors[k] * term.factor, term.x});
    }
    return terms;
  }
  if (x->kind == Kind::kProduct) {
    const auto sum =
        std::find_if(x->parts.begin(), x->parts.end(), [](const Expression& one) { return one->kind == Kind::kSum; });
    if (sum != x->parts.end()) {
      for (const Term& term : TermsOfSum(*sum)) {
        auto factors = x->parts;
        factors[static_cast<size_t>(sum - x->parts.begin())] = term.x;
        terms.push_back({term.factor, Product(factors)});
      }
      return terms;
    }
  }
  return {{1.0, x}};
}

/// The terms so many times each, by least squares: half and whole numbers, or any of one term.
void TermsOfOtherCounts(const View& v) {
  const auto& right = TryValue(v.x);
  if (!v.is_whole || v.formula.right->kind == Kind::kSeen || v.x->kind == Kind::kStack || !right || !v.got.allFinite())
    return;
  if (right->rows() != v.got.rows() || right->cols() != v.got.cols()) return;
  const std::vector<Term> terms = TermsOfSum(v.x);
  const auto n = static_cast<Index>(terms.size());
  if (n < 2 || v.got.size() <= n) return;
  MatXX basis(v.got.size(), n);
  for (Index k = 0; k < n; ++k) basis.col(k) = TryValue(terms[static_cast<size_t>(k)].x)->reshaped();
  const VecX scale = basis.colwise().norm().cwiseMax(1e-300).cwiseInverse().transpose();
  const MatXX scaled = basis * scale.asDiagonal();
  VecX counts =
      scale.asDiagonal() * (PseudoInversePsd(scaled.transpose() * scaled) * (scaled.transpose() * v.got.reshaped()));
  std::vector<Expression> parts;
  std::vector<double> factors;
  Index wrong = -1;
  int wrong_ones = 0, odd_ones = 0;
  for (Index k = 0; k < n; ++k) {
    const Term& term = terms[static_cast<size_t>(k)];
    double& count = counts[k];
    const double half = 0.5 * std::round(2.0 * count);
    const bool is_half = std::abs(count - half) < 1e-6;
    if (is_half) count = half;
    odd_ones += !is_half;
    if (count != term.factor) {
      ++wrong_ones;
      wrong = k;
    }
    if (count == 0.0) continue;
    parts.push_back(term.x);
    factors.push_back(count);
  }
  if (wrong_ones == 0 || parts.empty() || (odd_ones > 0 && wrong_ones > 1)) return;
  const auto ratio = [&](Index k) { return counts[k] / terms[static_cast<size_t>(k)].factor; };
  bool as_a_whole = true;  // then so is what is said of it
  for (Index k = 1; k < n; ++k) as_a_whole = as_a_whole && ratio(k) == ratio(0);
  if (as_a_whole) return;
  const Expression instead = Sum(parts, factors);
  if (wrong_ones == 1) {
    const Term& term = terms[static_cast<size_t>(wrong)];
    v.report(Say("formula.term_times", {{"term", NameOf(term.x)}, {"k", Number(counts[wrong] / term.factor)}}),
             instead);
  } else {
    v.report(Say("formula.combination", {{"this", NameOf(instead)}, {"that", NameOf(v.x)}}), instead);
  }
}

// ---- the table -------------------------------------------------------------------------------------------------------

/// The likelier ones first.
constexpr void (*kRules[])(const View&) = {
    &PartZero,           &InverseOfSingular, &TermOfOtherSign, &TermMissing,          &FactorMissing,
    &BracketsMissing,    &InverseForgotten,  &FactorTwice,     &InverseOfOneKindOnly, &AnotherSource,
    &TransposeForgotten, &AnotherForIt,      &Transposed,      &FactorsTransposed,    &FactorsInAnotherOrder,
    &InverseOfAnother,   &DirectionsCut,     &OnlyDiagonal,    &OnlyTriangle,         &PartsOfATerm,
    &PartsOfABlock,      &RootOfInverse,     &Inverted,        &BlockOfTheInverse,    &AnotherPlace,
    &MultipleOfIAdded,   &SharesOfAKind,     &SharesElsewhere, &TermsOfOtherCounts};

// ---- putting a slip in its place -------------------------------------------------------------------------------------

struct Site {
  Expression x;
  std::vector<size_t> path;
  std::string todo;
  bool is_whole;
};

void Walk(const Expression& x, const std::vector<size_t>& path, std::string todo, bool is_whole,
          std::vector<Site>* sites) {
  if (!x->todo.empty()) todo = x->todo;
  const bool seen = x->kind == Kind::kSeen;
  if (!seen) sites->push_back({x, path, todo, is_whole});
  if (x->kind == Kind::kAssembly) return;  // see Family
  for (size_t k = 0; k < x->parts.size(); ++k) {
    auto deeper = path;
    deeper.push_back(k);
    Walk(x->parts[k], deeper, todo, is_whole && seen, sites);
  }
}

Expression WithParts(const Expression& x, const std::vector<Expression>& parts) {
  if (x->kind == Kind::kProduct && x->name.empty()) return Product(parts);
  if (x->kind == Kind::kAssembly) {
    auto shares = x->shares;
    for (size_t k = 0; k < shares.size(); ++k) {  // where the sizes do not fit, the right one
      const auto &right = TryValue(x->parts[k]), &value = TryValue(parts[k]);
      const bool fits = right && value && right->rows() == value->rows() && right->cols() == value->cols();
      if (fits) shares[k].x = parts[k];
    }
    return Assembly(x->name, x->rows, x->columns, shares);
  }
  Node node = *x;
  node.known.reset();
  node.parts = parts;
  return std::make_shared<const Node>(node);
}

Expression ReplaceAt(const Expression& x, const std::vector<size_t>& path, size_t depth, const Expression& instead) {
  if (depth == path.size()) return instead;
  auto parts = x->parts;
  parts[path[depth]] = ReplaceAt(parts[path[depth]], path, depth + 1, instead);
  return WithParts(x, parts);
}

/// x with `change` of each node that it is not null of; of assemblies, if need be, only in shares of one kind.
template <typename Change>
Expression ReplaceAll(const Expression& x, const Change& change, const Text* kind = nullptr) {
  if (const Expression instead = change(x)) return instead;
  auto parts = x->parts;
  for (size_t k = 0; k < parts.size(); ++k) {
    if (kind != nullptr && x->kind == Kind::kAssembly && !IsOfKind(x->shares[k], *kind)) continue;
    parts[k] = ReplaceAll(parts[k], change, kind);
  }
  return parts == x->parts ? x : WithParts(x, parts);
}

/// What one statement of a loop computes, turn by turn: all nodes of one name in the shares of assemblies.
struct Family {
  std::vector<Expression> nodes;
  std::string todo;
};

void FindFamilies(const Expression& x, bool in_share, std::string todo, std::map<std::string, size_t>* by_name,
                  std::set<const Node*>* seen, std::vector<Family>* families) {
  if (!seen->insert(x.get()).second) return;
  if (!x->todo.empty()) todo = x->todo;
  if (in_share) {
    const auto [at, is_new] = by_name->try_emplace(NameOf(x), families->size());
    if (is_new) families->push_back({{}, todo});
    (*families)[at->second].nodes.push_back(x);
  }
  const bool inside = in_share || x->kind == Kind::kAssembly;
  for (const Expression& part : x->parts) FindFamilies(part, inside, todo, by_name, seen, families);
}

struct Changed {
  Text cause;
  Expression formula;
};

/// Two blocks, each wherever the other is meant.
std::vector<Changed> BlocksExchanged(const Expression& formula, const std::vector<Site>& sites) {
  std::vector<Changed> found;
  for (auto a = sites.begin(); a != sites.end(); ++a) {
    for (auto c = a + 1; c != sites.end(); ++c) {
      if (!a->x->source || !c->x->source || a->x == c->x) continue;
      const auto change = [&](const Expression& x) { return x == a->x ? c->x : x == c->x ? a->x : nullptr; };
      found.push_back(
          {Say("formula.exchanged", {{"this", a->x->name}, {"that", c->x->name}}), ReplaceAll(formula, change)});
    }
  }
  return found;
}

/// All blocks of a source from another one: the whole formula is undamped.
std::vector<Changed> FromOtherSources(const Expression& formula, const std::vector<Site>& sites) {
  std::vector<Changed> found;
  std::set<const Source::Data*> seen;
  for (const Site& site : sites) {
    const Source::Data* const source = site.x->source.get();
    const auto is_of_it = [&](const Site& one) { return one.x->source.get() == source && one.x != site.x; };
    const bool alone = std::none_of(sites.begin(), sites.end(), is_of_it);  // then it is named itself
    if (source == nullptr || alone || !seen.insert(source).second) continue;
    for (const Source::Other& other : source->others) {
      const auto change = [&](const Expression& x) -> Expression {
        if (x->source.get() != source || other.A.rows() != source->A.rows()) return nullptr;
        return ElsewhereIn(other.A, *x, x->row, x->column);
      };
      found.push_back({{"formula.all_from_another_source", {{"other", other.name}, {"matrix", Word(source->name)}}},
                       ReplaceAll(formula, change)});
    }
  }
  return found;
}

std::vector<Expression> NamedIn(const Formula& formula, const std::vector<Site>& sites) {
  std::vector<Expression> named;
  std::set<std::string> names;
  const auto add = [&](const Expression& x) {
    if (!x->name.empty() && names.insert(x->name).second) named.push_back(x);
  };
  for (const Site& site : sites) add(site.x);
  for (const Expression& x : formula.beside) add(x);
  return named;
}

class Search {
 public:
  Search(const Formula& formula, const MatXX& got, const std::function<bool(const MatXX&)>& is)
      : formula_(formula), got_(got), is_(is) {}

  std::optional<Mistake> In(const Expression& way) {
    std::vector<Site> sites;
    Walk(way, {}, {}, true, &sites);
    const std::vector<Expression> named = NamedIn(formula_, sites);
    std::map<const Node*, int> uses;
    for (const Site& site : sites) ++uses[site.x.get()];
    std::vector<Family> families;
    std::map<std::string, size_t> by_name;
    std::set<const Node*> seen;
    FindFamilies(way, false, {}, &by_name, &seen, &families);
    std::vector<Text> kinds;
    for (const Site& site : sites) {
      if (site.x->kind == Kind::kAssembly) kinds = KindsOf(site.x);
    }
    for (const auto rule : kRules) {
      if (rule == &TransposeForgotten) {  // before what replaces another
        for (const auto& [cause, changed] : FromOtherSources(way, sites)) Try(cause, {}, changed);
        for (const auto& [cause, changed] : BlocksExchanged(way, sites)) Try(cause, {}, changed);
      }
      for (const Family& family : families) {
        TryFamily(rule, way, family, kinds);
        if (found_) return found_;
      }
      for (const Site& site : sites) {
        if (found_) return found_;
        rule({site.x, site.is_whole, formula_, got_, named, [&](const Text& cause, const Expression& instead) {
                if (found_) return;
                if (!instead) {
                  found_ = Mistake{site.todo, cause, got_};
                  return;
                }
                Try(cause, site.todo, ReplaceAt(way, site.path, 0, instead));
                if (uses[site.x.get()] < 2) return;
                Try(cause, site.todo,
                    ReplaceAll(way, [&](const Expression& x) { return x == site.x ? instead : nullptr; }));
              }});
      }
    }
    return found_;
  }

 private:
  /// The same slip in every turn of a loop, or in the turns of one kind.
  void TryFamily(void (*rule)(const View&), const Expression& way, const Family& family,
                 const std::vector<Text>& kinds) {
    struct OfAll {
      Text cause;
      std::map<const Node*, Expression> instead;
    };
    const std::vector<Expression> nothing_else;
    std::vector<OfAll> slips;
    std::map<std::string, size_t> known;
    for (const Expression& node : family.nodes) {
      std::map<std::string, int> times;
      rule({node, false, formula_, got_, nothing_else, [&](const Text& cause, const Expression& instead) {
              if (!instead) return;
              const std::string key = cause.Json() + std::to_string(times[cause.Json()]++);
              const auto [at, is_new] = known.try_emplace(key, slips.size());
              if (is_new) slips.push_back({cause, {}});
              slips[at->second].instead[node.get()] = instead;
            }});
    }
    for (const OfAll& slip : slips) {
      const auto change = [&](const Expression& x) -> Expression {
        const auto at = slip.instead.find(x.get());
        return at == slip.instead.end() ? nullptr : at->second;
      };
      Try(slip.cause, family.todo, ReplaceAll(way, change));
      for (const Text& kind : kinds) {
        Try({"formula.in_kind", {{"kind", kind}, {"cause", slip.cause}}}, family.todo, ReplaceAll(way, change, &kind));
      }
    }
  }

  void Try(const Text& cause, const std::string& todo, const Expression& changed) {
    if (found_) return;
    const auto& answer = TryValue(changed);
    if (answer && is_(*answer)) found_ = Mistake{todo, cause, *answer};
  }

  const Formula& formula_;
  const MatXX& got_;
  const std::function<bool(const MatXX&)>& is_;
  std::optional<Mistake> found_;
};

/// "edge 0: 2.5, edge 3: 1": which shares give something to an entry, the largest first.
Text SharesAt(const Node& assembly, Index row, Index column) {
  std::vector<std::pair<double, const Share*>> given;
  for (const Share& share : assembly.shares) {
    const MatXX& A = Value(share.x);
    const Index i = row - share.place.row, j = column - share.place.column;
    if (i < 0 || j < 0 || i >= A.rows() || j >= A.cols() || A(i, j) == 0.0) continue;
    given.push_back({A(i, j), &share});
  }
  std::stable_sort(given.begin(), given.end(),
                   [](const auto& a, const auto& b) { return std::abs(a.first) > std::abs(b.first); });
  if (given.empty()) return {};
  const auto& [value, share] = given[0];
  return {"formula.shares_at",
          {{"n", Word(given.size())}, {"from", share->from}, {"x", Word(value)}, {"term", Word(NameOf(share->x))}}};
}

}  // namespace

std::optional<Mistake> FindSlip(const Formula& formula, const MatXX& got,
                                const std::function<bool(const MatXX& answer)>& is) {
  Search search(formula, got, is);
  if (auto found = search.In(formula.right)) return found;
  for (const Expression& way : formula.as_well) {
    if (auto found = search.In(way)) return found;
  }
  return {};
}

Text TermsOf(const Expression& x, Index row, Index column) {
  Expression one = x;
  if (one->kind == Kind::kSeen) return {};
  while (one->kind == Kind::kStack) {  // the part that the row belongs to
    size_t k = 0;
    while (k + 1 < one->parts.size() && row >= Value(one->parts[k]).rows()) row -= Value(one->parts[k++]).rows();
    one = one->parts[k];
  }
  const std::vector<Term> terms = TermsOfSum(one);
  std::string list;
  if (one->kind == Kind::kAssembly) return SharesAt(*one, row, column);
  if (terms.size() < 2) return {};
  for (const Term& term : terms) {
    const double given = term.factor * Value(term.x)(row, column);
    list += (list.empty() ? "" : ", ") + NameOf(term.factor == 1.0 ? term.x : Sum({term.x}, {term.factor})) + ": " +
            Number(given);
  }
  return Word(list);
}

}  // namespace ch5::homework::formula
