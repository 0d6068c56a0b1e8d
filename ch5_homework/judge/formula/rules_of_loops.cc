#include "ch5_homework/judge/formula/rules.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace ch5::homework::formula {

bool IsOfKind(const Share& share, const Text& kind) {
  return std::any_of(share.kinds.begin(), share.kinds.end(),
                     [&](const Text& one) { return one.Json() == kind.Json(); });
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

std::string TodoOf(const std::vector<Share>& shares, const Text& kind) {
  std::set<std::string> todos;
  for (const Share& share : shares) {
    if (IsOfKind(share, kind)) todos.insert(share.x->todo);
  }
  return todos.size() == 1 ? *todos.begin() : "";
}

/// An assembly with `change` of the shares that are of this kind, or of all; written where those are that it changes.
template <typename Change>
static Expression WithShares(const Expression& x, const Text* kind, const Change& change) {
  std::vector<Share> shares;
  std::set<std::string> todos;
  for (const Share& share : x->shares) {
    const bool is = kind == nullptr || IsOfKind(share, *kind);
    Share changed = share;
    const bool stays = change(is, &changed);
    const bool is_same = changed.x == share.x && changed.place.row == share.place.row &&
                         changed.place.column == share.place.column && changed.assigned == share.assigned;
    if (!stays || !is_same) todos.insert(share.x->todo);
    if (stays) shares.push_back(std::move(changed));
  }
  return WrittenAt(todos.size() == 1 ? *todos.begin() : "", Assembly(x->name, x->rows, x->columns, std::move(shares)));
}

/// A loop that ends too early or begins too late, or keeps what its last turn has.
void TurnsOfALoop(const View& v) {
  if (v.x->kind != Kind::kAssembly) return;
  size_t loops = 0;
  for (const Share& share : v.x->shares) loops = std::max(loops, share.turns.size());
  for (size_t k = 0; k < loops; ++k) {
    const auto at =
        std::find_if(v.x->shares.begin(), v.x->shares.end(), [=](const Share& s) { return s.turns.size() > k; });
    const auto report = [&](const char* id, bool (*stays)(const Share::Turn& turn)) {
      v.report({id, {{"loop", at->turns[k].loop}}}, WithShares(v.x, nullptr, [&](bool, Share* share) {
                 return share->turns.size() <= k || stays(share->turns[k]);
               }));
    };
    report("formula.loop_ends_at_once", [](const Share::Turn& turn) { return turn.number == 0; });
    report("formula.loop_begins_late", [](const Share::Turn& turn) { return turn.number > 0; });
    report("formula.loop_ends_early", [](const Share::Turn& turn) { return turn.number + 1 < turn.count; });
    report("formula.loop_keeps_last", [](const Share::Turn& turn) { return turn.number + 1 == turn.count; });
  }
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
    for (const auto& [id, times] : {std::pair{"formula.shares_twice", 2.0},
                                    {"formula.shares_half", 0.5},
                                    {"formula.shares_of_other_sign", -1.0}}) {
      report(id, kind, [factor = times](bool is, Share* share) {
        if (is) share->x = factor * share->x;
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
  const auto assigned = [&](double sign) {
    return WithShares(v.x, nullptr, [=](bool, Share* share) {
      share->assigned = true;
      if (sign < 0.0) share->x = -share->x;
      return true;
    });
  };
  const Expression last_alone = assigned(1.0);  // = for +=
  const auto &sum = TryValue(v.x), &last = TryValue(last_alone);
  if (!sum || !last || sum->isApprox(*last)) return;  // no share meets another: with −= that is the sign alone
  v.report({"formula.assigned", {{"matrix", matrix}}}, last_alone);
  v.report({"formula.assigned", {{"matrix", matrix}}}, assigned(-1.0));
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
        if (!is || other.name.Json() != wanted->Json() || now++ != last) continue;
        share->place = other.place;
        if (other.transposed) share->x = Transpose(share->x);
      }
      return true;
    };
    v.report(name, WithShares(v.x, nullptr, move));
    for (const Text& kind : kinds) {
      v.report({"formula.in_kind", {{"kind", kind}, {"cause", name}}}, WithShares(v.x, &kind, move));
    }
  }
}

/// All shares of a kind a row or a column too far on, or not far enough.
void SharesOffByOne(const View& v) {
  if (v.x->kind != Kind::kAssembly) return;
  for (const Text& kind : KindsOf(v.x)) {
    for (const auto& [rows, columns] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      v.report({rows != 0 ? "formula.one_row_off" : "formula.one_column_off", {{"kind", kind}}},
               WithShares(v.x, &kind, [&, i = rows, j = columns](bool is, Share* share) {
                 if (is) share->place = {share->place.row + i, share->place.column + j};
                 return true;
               }));
    }
  }
}

/// The block of one share, added or put where it does not belong, and all else is right.
void ShareTooMany(const View& v) {
  const auto& right = TryValue(v.x);
  if (v.x->kind != Kind::kAssembly || !v.is_whole || !right || !v.got.allFinite()) return;
  if (right->rows() != v.got.rows() || right->cols() != v.got.cols()) return;
  const MatXX more = v.got - *right;
  const double zero = 1e-9 * right->cwiseAbs().maxCoeff();
  std::vector<Index> rows, columns;  // that have wrong numbers
  for (Index i = 0; i < more.rows(); ++i) {
    if (more.row(i).cwiseAbs().maxCoeff() > zero) rows.push_back(i);
  }
  for (Index j = 0; j < more.cols(); ++j) {
    if (more.col(j).cwiseAbs().maxCoeff() > zero) columns.push_back(j);
  }
  if (rows.empty()) return;
  for (const Share& share : v.x->shares) {
    const MatXX& A = Value(share.x);
    if ((A.array() != 0.0).count() < 3) continue;  // a number or two may be anything
    for (Index i = std::max<Index>(0, rows.back() + 1 - A.rows()); i <= rows[0] && i + A.rows() <= more.rows(); ++i) {
      for (Index j = std::max<Index>(0, columns.back() + 1 - A.cols()); j <= columns[0] && j + A.cols() <= more.cols();
           ++j) {
        const auto is_A = [&](const MatXX& B) {
          return (B.block(i, j, A.rows(), A.cols()) - A).cwiseAbs().maxCoeff() <= zero;
        };
        const bool is_at_home = i == share.place.row && j == share.place.column;
        if (!is_A(more) && (is_at_home || !is_A(v.got))) continue;
        v.report(Say(is_at_home ? "formula.added_once_more" : "formula.stands_there_too",
                     {{"this", NameOf(share.x)}, {"i", std::to_string(i)}, {"j", std::to_string(j)}}),
                 Matrix(v.x->name, v.got));
      }
    }
  }
}

/// Of copies side by side, one at another place, where it replaces what is there.
void ShareAtAnotherPlace(const View& v) {
  if (v.x->kind != Kind::kAssembly || !v.is_whole) return;
  for (size_t k = 0; k < v.x->shares.size(); ++k) {
    const Share& right = v.x->shares[k];
    if (!right.x->source || right.x->value.size() == 0) continue;
    auto shares = v.x->shares;
    shares[k].assigned = true;
    for (Index i = 0; i + right.x->value.rows() <= v.x->rows; ++i) {
      for (Index j = 0; j + right.x->value.cols() <= v.x->columns; ++j) {
        shares[k].place = {i, j};
        v.report(Say(v.x->columns == 1 ? "formula.lies_at_entry" : "formula.lies_at",
                     {{"block", NameOf(right.x)},
                      {"i", std::to_string(i)},
                      {"j", std::to_string(j)},
                      {"row", std::to_string(right.place.row)},
                      {"column", std::to_string(right.place.column)}}),
                 Assembly(v.x->name, v.x->rows, v.x->columns, shares));
      }
    }
  }
}

}  // namespace ch5::homework::formula
