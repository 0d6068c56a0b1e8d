// Elimination as a game: the fewer zeros are filled, the better.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/lab/panels.h"
#include "ch5_backend/linear/elimination_plan.h"
#include "ch5_backend/simulate/random.h"

namespace ch5::lab {
namespace {

/// w (x_i − x_j)², or w x_i² if j = i. So no entry of H beside the diagonal is positive, each elimination only subtracts from
/// it, and a zero of H or L is one of the pattern.
struct Factor {
  int i, j;
  double weight = 1.0;
};

struct Board {
  std::vector<std::string> kinds;  // of the variables, which are scalars
  std::vector<Vec2> places;        // in the picture, [0, 1]²
  std::vector<Factor> factors;

  int Size() const { return static_cast<int>(kinds.size()); }
  int Add(const char* kind, double x, double y) {
    kinds.emplace_back(kind);
    places.emplace_back(x, y);
    return Size() - 1;
  }
  void Tie(int i, int j) { factors.push_back({i, j}); }
};

// The three scalars of SlidesChain, which can be worked out by hand: 1/σ², σ = 0.1, 0.2, 0.3.
Board ChainBoard() {
  Board board;
  for (const double x : {0.1, 0.5, 0.9}) board.Add("scalar", x, 0.5);
  board.factors = {{0, 1, 100.0}, {1, 1, 25.0}, {1, 2, 1.0 / 0.09}};
  return board;
}

Board LoopBoard() {
  constexpr int kPoses = 8;
  Board board;
  board.Tie(0, 0);
  for (int i = 0; i < kPoses; ++i) {
    const double angle = 2.0 * M_PI * i / kPoses;
    board.Add("scalar", 0.5 + 0.4 * std::cos(angle), 0.5 + 0.4 * std::sin(angle));
    board.Tie(i, (i + 1) % kPoses);
  }
  return board;
}

Board GridBoard() {
  constexpr int kSide = 4;
  Board board;
  board.Tie(0, 0);
  for (int i = 0; i < kSide * kSide; ++i) {
    const int row = i / kSide;
    board.Add("scalar", 0.1 + 0.8 / (kSide - 1) * (i % kSide), 0.1 + 0.8 / (kSide - 1) * row);
    if (i % kSide > 0) board.Tie(i - 1, i);
    if (i >= kSide) board.Tie(i - kSide, i);
  }
  return board;
}

// Cameras in a row, and points that two or three neighboring ones see: a bundle adjustment in small.
Board BundleBoard(Random* random) {
  constexpr int kCameras = 4, kPoints = 9;
  Board board;
  for (int i = 0; i < kCameras; ++i) board.Add("pose", 0.14 + 0.24 * i, i % 2 ? 0.92 : 0.74);
  board.Tie(0, 0);
  for (int k = 0; k < kPoints; ++k) {
    const int seen = random->Uniform() < 0.5 ? 2 : 3,
              first = static_cast<int>((kCameras - seen + 1) * random->Uniform());
    const int point = board.Add("landmark", 0.08 + 0.105 * k, k % 2 ? 0.14 : 0.34);
    for (int i = first; i < first + seen; ++i) board.Tie(i, point);
  }
  return board;
}

// Places at random, each tied to the two nearest of those before it.
Board ScatteredBoard(Random* random) {
  constexpr int kColumns = 4, kRows = 3;
  Board board;
  board.Tie(0, 0);
  for (int i = 0; i < kColumns * kRows; ++i) {
    const double x = 0.13 + 0.74 * (i % kColumns) / (kColumns - 1) + random->Uniform(-0.08, 0.08);
    const int row = i / kColumns;
    const double y = 0.14 + 0.72 * row / (kRows - 1) + random->Uniform(-0.1, 0.1);
    std::vector<int> nearest(static_cast<size_t>(i));
    std::iota(nearest.begin(), nearest.end(), 0);
    const Vec2 place(x, y);
    std::sort(nearest.begin(), nearest.end(), [&](int a, int b) {
      return (board.places[static_cast<size_t>(a)] - place).norm() <
             (board.places[static_cast<size_t>(b)] - place).norm();
    });
    board.Add("scalar", x, y);
    for (int k = 0; k < std::min(i, 2); ++k) board.Tie(nearest[static_cast<size_t>(k)], i);
  }
  return board;
}

MatXX HessianOf(const Board& board) {
  MatXX H = MatXX::Zero(board.Size(), board.Size());
  for (const auto& [i, j, weight] : board.factors) {
    H(i, i) += weight;
    if (j == i) continue;
    H(j, j) += weight;
    H(i, j) -= weight;
    H(j, i) -= weight;
  }
  return H;
}

/// A game as far as it has been played. A step is marginalizing one variable, by the function that students write; with its
/// row of H it is a column of the Cholesky factor, and a node of the Bayes net:
///
///   p(x_v | x_clique) = N(−Σ_i (l_iv / l_vv) x_i, 1/l_vv²),     l_vv = √H_vv,  l_iv = H_iv / l_vv
struct Game {
  explicit Game(const Board& board)
      : H(HessianOf(board)), L(MatXX::Zero(board.Size(), board.Size())), filled(L), left(H.rows()) {
    std::iota(left.begin(), left.end(), 0);
  }

  // The variables to which the one in `row` of H is tied.
  std::vector<int> Clique(int row) const {
    std::vector<int> clique;
    for (int i = 0; i < H.rows(); ++i) {
      if (i != row && H(i, row) != 0.0) clique.push_back(left[static_cast<size_t>(i)]);
    }
    return clique;
  }

  void Eliminate(int row) {
    const int variable = left[static_cast<size_t>(row)];
    cliques.push_back(Clique(row));
    order.push_back(variable);
    const double l = std::sqrt(H(row, row));
    for (int i = 0; i < H.rows(); ++i) L(left[static_cast<size_t>(i)], variable) = H(i, row) / l;
    const MatXX old = H;
    H = Problem::TestMarginalize(H, VecX::Zero(H.rows()), row, 1).H_prior;
    left.erase(left.begin() + row);
    last_fill = MatXX::Zero(H.rows(), H.cols());
    for (int i = 0; i < H.rows(); ++i) {
      for (int j = 0; j < H.cols(); ++j) {
        if (H(i, j) == 0.0 || old(i + (i >= row), j + (j >= row)) != 0.0) continue;
        last_fill(i, j) = filled(left[static_cast<size_t>(i)], left[static_cast<size_t>(j)]) = 1.0;
      }
    }
  }

  int Fill() const { return static_cast<int>(filled.sum()) / 2; }

  MatXX H;                                // of the variables that are left
  MatXX L;                                // columns of those that are gone, zero else; rows and columns by number
  MatXX filled;                           // 1 where a zero of H has been filled, by number
  MatXX last_fill;                        // likewise in the rows of H, by the last step
  std::vector<int> left, order;           // numbers; those gone in their order
  std::vector<std::vector<int>> cliques;  // of those gone
};

// The library's own order, Eigen's AMD behind it, and the zeros that it fills.
Game ByAmd(const Board& board) {
  Game game(board);
  std::vector<std::vector<int>> rows(game.left.size());
  for (int j = 0; j < board.Size(); ++j) {
    for (int i = j; i < board.Size(); ++i) {
      if (game.H(i, j) != 0.0) rows[static_cast<size_t>(j)].push_back(i);
    }
  }
  SymmetricBlockMatrix pattern;
  pattern.SetPattern(Array<int>(rows.size(), 1), rows);
  for (const int variable : PlanElimination(pattern).order) {
    game.Eliminate(static_cast<int>(std::find(game.left.begin(), game.left.end(), variable) - game.left.begin()));
  }
  return game;
}

// The least that any order fills. What v is tied to when the set `gone` has been eliminated does not depend on the order
// in which it was: it is what v reaches through `gone`. So 2ⁿ sets are enough, not n! orders.
int LeastFill(const Board& board) {
  const int n = board.Size();
  const MatXX H = HessianOf(board);
  std::vector<unsigned> neighbors(static_cast<size_t>(n), 0);
  int ties = 0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      if (i != j && H(i, j) != 0.0) neighbors[static_cast<size_t>(i)] |= 1U << j, ++ties;
    }
  }
  std::vector<int> least(size_t{1} << n, std::numeric_limits<int>::max());
  least[0] = 0;
  for (unsigned gone = 0; gone + 1 < least.size(); ++gone) {
    for (int v = 0; v < n; ++v) {
      if (gone >> v & 1U) continue;
      unsigned reached = neighbors[static_cast<size_t>(v)] | 1U << v, before = 0;
      while (reached != before) {
        before = reached;
        for (int i = 0; i < n; ++i) {
          if (reached & gone & 1U << i) reached |= neighbors[static_cast<size_t>(i)];
        }
      }
      int clique = -1;  // v itself does not count
      for (unsigned rest = reached & ~gone; rest; rest &= rest - 1) ++clique;
      int& sum = least[gone | 1U << v];
      sum = std::min(sum, least[gone] + clique);
    }
  }
  return least.back() - ties / 2;
}

std::vector<Json> Variables(const Board& board, const std::vector<int>& numbers) {
  std::vector<Json> variables;
  for (const int number : numbers) {
    const int row = static_cast<int>(variables.size());
    variables.push_back(VariableJson(board.kinds[static_cast<size_t>(number)], number, row, 1));
  }
  return variables;
}

void AddBoard(const Board& board, const Game& game, Json* json) {
  std::vector<Json> nodes, factors;
  for (const Vec2& place : board.places) nodes.push_back(Json().Add("x", place.x()).Add("y", place.y()));
  for (const Factor& one : board.factors) factors.push_back(Json().Add("i", one.i).Add("j", one.j));
  json->Add("nodes", nodes).Add("factors", factors);
  std::vector<Json> gone, left, ties;
  for (size_t k = 0; k < game.order.size(); ++k) {
    gone.push_back(Json().Add("number", game.order[k]).Add("clique", game.cliques[k]));
  }
  for (int i = 0; i < game.H.rows(); ++i) {
    const int number = game.left[static_cast<size_t>(i)];
    Game next = game;
    next.Eliminate(i);
    left.push_back(Json().Add("number", number).Add("clique", game.Clique(i)).Add("fill", next.Fill() - game.Fill()));
    for (const int other : game.Clique(i)) {
      if (other < number)
        ties.push_back(Json().Add("i", other).Add("j", number).Add("fill", game.filled(other, number) != 0.0));
    }
  }
  json->Add("gone", gone).Add("left", left).Add("ties", ties).Add("fill", game.Fill());
}

}  // namespace

// `order` lists the variables that are gone, by number.
void EliminatePanel(Query* query, Json* json) {
  const int kind = query->Word("board", {"random", "chain", "loop", "grid", "bundle"});
  const int seed = query->Whole("seed", 3, 0, 99);
  const std::vector<int> order = query->Numbers("order", 0, 99);
  if (!query->IsGood()) return;

  Random random(static_cast<uint64_t>(seed));
  const Board board = kind == 0   ? ScatteredBoard(&random)
                      : kind == 1 ? ChainBoard()
                      : kind == 2 ? LoopBoard()
                      : kind == 3 ? GridBoard()
                                  : BundleBoard(&random);
  Game game(board);
  for (const int variable : order) {
    const auto found = std::find(game.left.begin(), game.left.end(), variable);
    if (found != game.left.end()) game.Eliminate(static_cast<int>(found - game.left.begin()));
  }
  AddBoard(board, game, json);
  const Game amd = ByAmd(board);
  json->Add("amd", amd.Fill()).Add("amd_order", amd.order).Add("least", LeastFill(board));
  json->Add("H", game.H).Add("H_variables", Variables(board, game.left)).Add("H_fill", game.last_fill);
  std::vector<int> numbers = game.order;
  numbers.insert(numbers.end(), game.left.begin(), game.left.end());
  json->Add("L", MatXX(game.L(numbers, numbers))).Add("L_variables", Variables(board, numbers));
  const MatXX lower = game.L.unaryExpr([](double l) { return l != 0.0 ? 1.0 : 0.0; }).cwiseProduct(game.filled);
  json->Add("L_fill", MatXX(lower(numbers, numbers)));
}

}  // namespace ch5::lab
