#include "ch5_homework/judge/formula/rules.h"

#include <algorithm>
#include <cmath>

namespace ch5::homework::formula {

// ---- the parts of a formula ------------------------------------------------------------------------------------------

static bool CanBeMistaken(const View& v) {
  return v.x->kind == Kind::kMatrix || v.x->kind == Kind::kInverse || !v.x->name.empty() || v.is_whole;
}

static Text StandsFor(const View& v, const std::string& name) {
  if (v.is_whole) return Say("formula.result_is", {{"this", name}, {"that", NameOf(v.x)}});
  return Say("formula.stands_for", {{"this", name}, {"that", NameOf(v.x)}});
}

void AnotherForIt(const View& v) {
  for (const auto& [other, cause] : v.x->mistaken) {
    v.report(cause.empty() ? StandsFor(v, NameOf(other)) : cause, other);
  }
  if (!CanBeMistaken(v)) return;
  const std::string own = NameOf(v.x);
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
  const auto& A = TryValue(v.x);
  if (!CanBeMistaken(v) || !A || A->rows() == 1 || A->cols() == 1) return;
  if (A->rows() == A->cols() && A->isApprox(-A->transpose(), 1e-12)) return;  // a sign, rather
  v.report(StandsFor(v, NameOf(Transpose(v.x))), Transpose(v.x));
}

void Inverted(const View& v) {
  if (v.x->kind == Kind::kInverse || !CanBeMistaken(v) || !Square(v.x)) return;
  v.report(StandsFor(v, NameOf(Inverse(v.x))), Inverse(v.x));
}

void OnlyDiagonal(const View& v) {
  const MatXX* const A = Square(v.x);
  if (A == nullptr || A->rows() == 1 || A->diagonal().isZero(0.0)) return;
  v.report(Say("formula.diagonal_alone", {{"matrix", NameOf(v.x)}}), Matrix(NameOf(v.x), A->diagonal().asDiagonal()));
}

void OnlyTriangle(const View& v) {
  const MatXX* const A = Square(v.x);
  const bool halves_say_all = A != nullptr && A->isApprox(A->transpose());  // of another matrix nobody takes one
  if (!halves_say_all || A->rows() == 1 || v.is_whole) return;
  for (const MatXX& half : {MatXX(A->triangularView<Eigen::Upper>()), MatXX(A->triangularView<Eigen::Lower>())}) {
    v.report(Say("formula.one_triangle_alone", {{"matrix", NameOf(v.x)}}), Matrix(NameOf(v.x), half));
  }
}

/// Its absolute values, whole numbers or floats, or a vector of length one.
void Converted(const View& v) {
  const auto& A = TryValue(v.x);
  if (!A || A->size() < 2 || v.is_whole) return;
  const auto report = [&](const char* id, const MatXX& changed) {
    if (changed != *A) v.report(Say(id, {{"matrix", NameOf(v.x)}}), Matrix(NameOf(v.x), changed));
  };
  report("formula.signs_lost", A->cwiseAbs());
  report("formula.cast_to_int", A->unaryExpr([](double x) { return std::trunc(x); }));
  report("formula.cast_to_float", A->cast<float>().cast<double>());
  if (A->cols() == 1) report("formula.normalized", A->normalized());
}

// ---- parts of a block, or of a term ----------------------------------------------------------------------------------

/// The parts that [begin, begin + size) consists of, counted from there.
static std::vector<Part> PartsWithin(const std::vector<Part>& all, Index begin, Index size) {
  std::vector<Part> parts;
  for (const Part& part : all) {
    if (part.begin >= begin && part.begin + part.size <= begin + size) {
      parts.push_back({part.name, part.begin - begin, part.size});
    }
  }
  return parts;
}

static void OnlyOnePart(const View& v, const MatXX& A, const std::vector<Part>& parts, bool of_columns) {
  if (parts.size() < 2) return;
  for (const Part& part : parts) {
    MatXX rest = A;
    if (of_columns) {
      rest.middleCols(part.begin, part.size).setZero();
    } else {
      rest.middleRows(part.begin, part.size).setZero();
    }
    const MatXX alone = A - rest;
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

static Text StartsAt(const Node& block, Index row, Index column) {
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

}  // namespace ch5::homework::formula
