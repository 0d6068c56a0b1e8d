#include "ch5_homework/judge/formula/slips.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <set>
#include <utility>

#include "ch5_homework/judge/formula/rules.h"

namespace ch5::homework::formula {
namespace {

// ---- putting a slip in its place -------------------------------------------------------------------------------------

struct Site {
  Expression x;
  std::vector<size_t> path;
  std::string todo;
  bool is_whole;
  bool read_elsewhere;  ///< in another TODO than what it is a part of,
  std::string used_in;  ///< which is this one
};

void Walk(const Expression& x, const std::vector<size_t>& path, std::string todo, bool is_whole,
          std::vector<Site>* sites) {
  const bool read_elsewhere = x->source && !x->todo.empty() && x->todo != todo;
  const std::string used_in = read_elsewhere ? todo : x->todo.empty() ? todo : x->todo;
  if (!x->todo.empty()) todo = x->todo;
  const bool seen = x->kind == Kind::kSeen;
  if (!seen) sites->push_back({x, path, todo, is_whole, read_elsewhere, used_in});
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
    return Assembly(x->name, x->rows, x->columns, std::move(shares));
  }
  Node node = *x;
  node.known.reset();
  node.parts = parts;
  return std::make_shared<const Node>(std::move(node));
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

struct KindOfShare {
  Text name;
  std::string todo;  // see TodoOf
};

std::vector<KindOfShare> KindsIn(const std::vector<Site>& sites) {
  std::vector<KindOfShare> kinds;
  for (const Site& site : sites) {
    for (const Text& kind : KindsOf(site.x)) kinds.push_back({kind, TodoOf(site.x->shares, kind)});
  }
  return kinds;
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
      if (a->x->kind != Kind::kMatrix || c->x->kind != Kind::kMatrix || a->x == c->x) continue;
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
    if (names.insert(NameOf(x)).second) named.push_back(x);
  };
  for (const Site& site : sites) {
    if (!site.x->name.empty()) add(site.x);
  }
  for (const Expression& x : formula.beside) add(x);
  return named;
}

/// The first node of each name, also in shares.
std::map<std::string, Expression> FirstOnes(const Expression& x) {
  std::vector<Family> families;
  std::map<std::string, size_t> by_name;
  std::set<const Node*> seen;
  FindFamilies(x, true, {}, &by_name, &seen, &families);
  std::map<std::string, Expression> first;
  for (const auto& [name, number] : by_name) first.emplace(name, families[number].nodes[0]);
  return first;
}

/// Whether a slip may as well be written in the TODO where blocks are read as where they are used: all but a wrong place.
bool MayBeElsewhere(Rule rule, const Site& site, const std::vector<Site>& sites) {
  if (rule == &AnotherPlace || rule == &AnotherSource) return false;
  const bool of_a_term = rule == &TermOfOtherSign || rule == &TermsOfOtherCounts;
  return site.read_elsewhere ||
         (of_a_term && std::any_of(sites.begin(), sites.end(), [](const Site& one) { return one.read_elsewhere; }));
}

std::clock_t search_began = 0;  // of large matrices all slips would take minutes
bool IsLate() { return std::clock() - search_began > 5 * CLOCKS_PER_SEC; }

class Search {
 public:
  using IsAskedCause = std::function<bool(const Text& cause)>;

  /// @param is_asked  no slip but those with such a cause, unless it is empty
  Search(const Formula& formula, const MatXX& got, const std::function<bool(const MatXX&)>& is,
         const std::vector<Formula>& earlier, IsAskedCause is_asked)
      : formula_(formula), got_(got), is_(is), earlier_(earlier), is_asked_(std::move(is_asked)) {}

  /// What the first turn of a loop had, in an earlier call, wherever it is used; a later call may be of another size.
  std::optional<Mistake> Kept(const Expression& way, const Expression& of_first_call) {
    may_be_elsewhere_ = true;
    std::vector<Site> sites;
    Walk(way, {}, {}, true, &sites);
    const std::vector<KindOfShare> kinds = KindsIn(sites);
    for (const auto& [name, first] : FirstOnes(of_first_call)) {
      const auto change = [&, &name = name, &first = first](const Expression& x) {
        const bool fits = Value(x).rows() == Value(first).rows() && Value(x).cols() == Value(first).cols();
        return x != first && NameOf(x) == name && fits ? first : nullptr;
      };
      if (name == NameOf(way)) continue;  // all of it: that is seen elsewhere
      const Text cause = Say("formula.kept_from_the_first", {{"this", name}});
      Try(cause, {}, ReplaceAll(way, change));
      for (const auto& [kind, todo] : kinds)
        Try({"formula.in_kind", {{"kind", kind}, {"cause", cause}}}, todo, ReplaceAll(way, change, &kind));
    }
    return found_;
  }

  std::optional<Mistake> In(const Expression& way, bool unlikely) {
    std::vector<Site> sites;
    Walk(way, {}, {}, true, &sites);
    const auto named = formula_.listed_alone ? std::vector<Expression>() : NamedIn(formula_, sites);
    std::map<const Node*, int> uses;
    for (const Site& site : sites) ++uses[site.x.get()];
    std::vector<Family> families;
    std::map<std::string, size_t> by_name;
    std::set<const Node*> seen;
    FindFamilies(way, false, {}, &by_name, &seen, &families);
    const std::vector<KindOfShare> kinds = KindsIn(sites);
    for (const Rule rule : formula_.listed_alone ? std::vector<Rule>{&AnotherForIt} : Rules(unlikely)) {
      if (rule == &TransposeForgotten) {  // before what replaces another
        may_be_elsewhere_ = true;
        for (const auto& [cause, changed] : FromOtherSources(way, sites)) Try(cause, {}, changed);
        for (const auto& [cause, changed] : BlocksExchanged(way, sites)) Try(cause, {}, changed);
      }
      may_be_elsewhere_ = false;
      for (const Family& family : families) {
        TryFamily(rule, way, family, kinds);
        if (found_ || IsLate()) return found_;
      }
      for (const Site& site : sites) {
        if (found_ || IsLate()) return found_;
        may_be_elsewhere_ = MayBeElsewhere(rule, site, sites);
        rule(
            {site.x, site.is_whole, formula_, got_, named, earlier_, [&](const Text& cause, const Expression& instead) {
               if (!found_) TryAt(site, uses[site.x.get()], rule, way, cause, instead);
             }});
      }
    }
    return found_;
  }

 private:
  /// At one place, and at all that use the same. A variable is written once: a slip in it is wherever it is used; another one
  /// stands for it at one place.
  void TryAt(const Site& site, int uses, Rule rule, const Expression& way, const Text& cause,
             const Expression& instead) {
    const std::string& todo =
        rule == &PartsOfABlock ? site.used_in : site.todo;  // a loop over parts, where they are used
    if (!instead) {
      if (IsAsked(cause)) found_ = Mistake{todo, cause, got_};
      return;
    }
    const bool is_of_kind = instead->kind == Kind::kAssembly && !instead->todo.empty();
    const bool is_written_once =
        uses > 1 && !site.x->name.empty() && !site.x->parts.empty() && rule != &AnotherForIt && rule != &Transposed;
    if (!is_written_once) {
      Try(cause, is_of_kind ? instead->todo : todo, ReplaceAt(way, site.path, 0, instead));
    }
    if (uses < 2) return;
    Try(cause, todo, ReplaceAll(way, [&](const Expression& x) { return x == site.x ? instead : nullptr; }));
  }

  /// The same slip in every turn of a loop, or in the turns of one kind.
  void TryFamily(Rule rule, const Expression& way, const Family& family, const std::vector<KindOfShare>& kinds) {
    struct OfAll {
      Text cause;
      std::map<const Node*, Expression> instead;
    };
    const std::vector<Expression> nothing_else;
    const std::vector<Formula> no_earlier;
    std::vector<OfAll> slips;
    std::map<std::string, size_t> known;
    for (const Expression& node : family.nodes) {
      std::map<std::string, int> times;
      rule({node, false, formula_, got_, nothing_else, no_earlier, [&](const Text& cause, const Expression& instead) {
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
      for (const auto& [kind, todo] : kinds) {
        Try({"formula.in_kind", {{"kind", kind}, {"cause", slip.cause}}}, todo.empty() ? family.todo : todo,
            ReplaceAll(way, change, &kind));
      }
    }
  }

  void Try(const Text& cause, const std::string& todo, const Expression& changed) {
    if (found_ || !IsAsked(cause) || IsLate()) return;
    const auto& answer = TryValue(changed);
    const bool is_limit = cause.Json().find("\"formula.known_direction_cut\"") != std::string::npos;
    if (!answer || !is_(*answer) || (!is_limit && IsRefuted(cause))) return;   // earlier values were not near the limit
    if (!IsLate()) found_ = Mistake{todo, cause, *answer, may_be_elsewhere_};  // compared with all earlier calls
  }

  bool may_be_elsewhere_ = false;

  bool IsAsked(const Text& cause) const { return !is_asked_ || is_asked_(cause); }

  /// Whether the slip would have made the answer to an earlier call wrong, which was right.
  bool IsRefuted(const Text& cause) const;

  const Formula& formula_;
  const MatXX& got_;
  const std::function<bool(const MatXX&)>& is_;
  const std::vector<Formula>& earlier_;
  const IsAskedCause is_asked_;
  std::optional<Mistake> found_;
};

std::vector<Expression> WaysOf(const Formula& formula) {
  std::vector<Expression> ways = formula.as_well;
  ways.insert(ways.begin(), formula.right);
  return ways;
}

bool Search::IsRefuted(const Text& cause) const {
  constexpr double kSame = 1e-6;
  static const std::vector<Formula> none;
  return std::any_of(earlier_.begin(), earlier_.end(), [&](const Formula& one) {
    if (NameOf(one.right) != NameOf(formula_.right)) return false;
    const MatXX& right = Value(one.right);
    bool is_tried = false;
    const std::function<bool(const MatXX&)> stays_right = [&](const MatXX& answer) {
      is_tried = true;
      return Equal(answer, right, kSame);
    };
    const std::vector<Expression> ways = WaysOf(one);
    const auto is_cause = [&](const Text& other) { return other.Json() == cause.Json(); };
    return std::none_of(ways.begin(), ways.end(),
                        [&](const Expression& way) {
                          Search search(one, right, stays_right, none, is_cause);
                          return search.In(way, false) || search.In(way, true);
                        }) &&
           is_tried;
  });
}

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
  if (given.empty() || given[0].second->from.empty()) return {};
  const auto& [value, share] = given[0];
  return {"formula.shares_at",
          {{"n", Word(given.size())}, {"from", share->from}, {"x", Word(value)}, {"term", Word(NameOf(share->x))}}};
}

}  // namespace

std::optional<Mistake> FindSlip(const Formula& formula, const MatXX& got,
                                const std::function<bool(const MatXX& answer)>& is, const std::vector<Formula>& earlier,
                                const std::function<bool(const Text& cause)>& is_asked) {
  search_began = std::clock();
  Search search(formula, got, is, earlier, is_asked);
  const std::vector<Expression> ways = WaysOf(formula);
  for (const bool unlikely : {false, true}) {
    for (const Expression& way : ways) {
      if (auto found = search.In(way, unlikely)) return found;
    }
  }
  if (formula.listed_alone) return {};
  for (const Formula& one : earlier.empty() ? std::vector<Formula>{formula} : earlier) {  // or the first of its size
    const std::vector<Expression> before = WaysOf(one);
    for (size_t k = 0; k < std::min(ways.size(), before.size()); ++k) {
      if (auto found = search.Kept(ways[k], before[k])) return found;
    }
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
