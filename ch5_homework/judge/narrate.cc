#include "ch5_homework/judge/narrate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "ch5_homework/judge/poison.h"

namespace ch5::homework {
namespace {

constexpr int kSmall = 3;               // matrices up to this size are shown whole
constexpr double kMistakeMatch = 1e-6;  // how near to a mistake's answer counts as that mistake

// Adds one line "  label  text" to a story; a text of several lines is indented below.
void Tell(std::ostringstream* story, const std::string& label, const std::string& text) {
  *story << "\n  " << label << std::string(label.size() < 10 ? 10 - label.size() : 1, ' ');
  for (const char c : text) *story << (c == '\n' ? std::string("\n            ") : std::string(1, c));
}

void TellWhereToRead(std::ostringstream* story, const std::string& stage, const std::string& todo) {
  Tell(story, "read", "ch5_homework/README.md, Stage " + stage + (todo.empty() ? "" : ", TODO " + todo));
}

std::string Size(const MatXX& A) { return std::to_string(A.rows()) + "×" + std::to_string(A.cols()); }

std::string Whole(const MatXX& A) {
  std::ostringstream out;
  out << A.format(Eigen::IOFormat(6, 0, "  ", "\n", "[ ", " ]"));
  return out.str();
}

double LargestEntry(const MatXX& A) { return A.size() == 0 ? 0.0 : A.cwiseAbs().maxCoeff(); }

// |got − expected|, with infinity where `got` is not finite.
MatXX Deviation(const Claim& claim) {
  return (claim.got - claim.expected).unaryExpr([](double x) {
    return std::isfinite(x) ? std::abs(x) : std::numeric_limits<double>::infinity();
  });
}

const Mistake* FindMistake(const Claim& claim) {
  for (const Mistake& mistake : claim.mistakes) {
    const MatXX answer = mistake.answer();
    if (Equal(claim.got, answer, kMistakeMatch) && !Equal(answer, claim.expected, 10 * kMistakeMatch)) return &mistake;
  }
  return nullptr;
}

std::string Called(const Claim& claim) { return claim.variable.empty() ? "it" : claim.variable; }

bool Any(const MatXX& A, bool (*is)(double)) { return std::any_of(A.data(), A.data() + A.size(), is); }

// What numbers that are none say: memory that was never written to, or is no more, has a mark of its own.
std::string SymptomOfNaN(const Claim& claim) {
  if (Any(claim.got, &IsFreed)) {
    return "memory is read that is no more: `auto x = …` keeps a recipe with references to matrices that have gone by "
           "the next line; write MatXX or VecX instead of auto";
  }
  if (Any(claim.got, &IsFresh)) {
    const bool all = std::all_of(claim.got.data(), claim.got.data() + claim.got.size(), &IsFresh);
    return all ? "nothing was assigned to " + Called(claim) + ", or += and -= began on a matrix that was never set"
               : "some entries were never set: += or -= begins on a matrix without numbers, or an assignment is too "
                 "small";
  }
  return "some entries are not finite: something was divided by zero";
}

// k if got = k · expected, otherwise NaN.
double Ratio(const MatXX& got, const MatXX& expected) {
  const double k = got.cwiseProduct(expected).sum() / expected.squaredNorm();
  const bool is = std::abs(k) > 1e-9 && Equal(got, k * expected, kMistakeMatch * std::min(1.0, std::abs(k)));
  return is ? k : std::numeric_limits<double>::quiet_NaN();
}

bool SameNumbersElsewhere(MatXX got, MatXX expected, double tolerance) {
  std::sort(got.data(), got.data() + got.size());
  std::sort(expected.data(), expected.data() + expected.size());
  return Equal(got, expected, tolerance);
}

bool IsSymmetric(const MatXX& A) { return A.rows() == A.cols() && A.rows() > 1 && Equal(A, A.transpose(), 1e-9); }

// Which simple change of the whole matrix explains it; "" if none does.
std::string SymptomOfTheWhole(const Claim& claim) {
  const MatXX &got = claim.got, &expected = claim.expected;
  if (got.isZero(0.0)) return "still zero: nothing was written to " + Called(claim);
  if (expected.isZero(0.0)) return "";
  const double k = Ratio(got, expected);
  if (std::abs(k + 1.0) < 1e-6) return "the sign: everything is right but for a minus";
  if (std::isfinite(k)) return "everything is " + Number(k) + " times too large: a factor, or added so often";
  const bool square = got.rows() == got.cols() && got.rows() > 1;
  if (square && Equal(got, expected.transpose(), kMistakeMatch)) return "this is the transpose of what is meant";
  if (square && IsSymmetric(expected)) {
    const MatXX upper = expected.triangularView<Eigen::Upper>(), lower = expected.triangularView<Eigen::Lower>();
    if (Equal(got, upper, kMistakeMatch)) return "only the upper triangle is filled: its mirror image is missing";
    if (Equal(got, lower, kMistakeMatch)) return "only the lower triangle is filled: its mirror image is missing";
  }
  if (SameNumbersElsewhere(got, expected, kMistakeMatch)) return "the right numbers stand in wrong places";
  const auto wrong = ((got - expected).array().abs() > claim.tolerance * LargestEntry(expected)).eval();
  if (wrong.select(got, 0.0).isZero(0.0)) return "what is wrong is zero: to these entries nothing was added";
  return "";
}

// What can be said of a wrong matrix that no typical mistake explains.
std::string Symptom(const Claim& claim) {
  if (!claim.got.allFinite()) return SymptomOfNaN(claim);
  if (const std::string whole = SymptomOfTheWhole(claim); !whole.empty()) return whole;
  if (IsSymmetric(claim.expected) && !IsSymmetric(claim.got)) {
    return "none of the typical mistakes, but the matrix is not symmetric: compare the entry with its mirror";
  }
  return "none of the typical mistakes gives these numbers; begin with the entry above";
}

void TellEntry(std::ostringstream* story, const Claim& claim) {
  const MatXX deviation = Deviation(claim);
  int row = 0, column = 0;
  deviation.maxCoeff(&row, &column);
  const double threshold = claim.tolerance * LargestEntry(claim.expected);
  const auto wrong = (deviation.array() > threshold).count();
  const bool is_vector = claim.got.cols() == 1;
  const std::string place =
      is_vector ? "entry " + std::to_string(row) : "(" + std::to_string(row) + ", " + std::to_string(column) + ")";
  Tell(story, "expected", place + " = " + Number(claim.expected(row, column)));
  Tell(story, "got",
       place + " = " + Number(claim.got(row, column)) + "   the worst of " + std::to_string(wrong) +
           " wrong entries, " + std::to_string(deviation.size()) + " in all");
  if (row < static_cast<int>(claim.names.size())) Tell(story, "row " + std::to_string(row), claim.names[row]);
  const Names& columns = claim.columns.empty() ? claim.names : claim.columns;
  if (!is_vector && column < static_cast<int>(columns.size())) {
    Tell(story, "column " + std::to_string(column), columns[column]);
  }
}

// "δp.y" of a pose, "" of a scalar.
std::string Component(const Vertex& vertex, int k) {
  static const char* const kPose[] = {"δp.x", "δp.y", "δp.z", "δθ.x", "δθ.y", "δθ.z"};
  static const char* const kPoint[] = {"x", "y", "z"};
  if (vertex.LocalDimension() == 1) return "";
  if (vertex.TypeInfo() == "VertexPose") return std::string(", ") + kPose[k];
  if (vertex.TypeInfo() == "VertexPointXYZ") return std::string(", ") + kPoint[k];
  return ", component " + std::to_string(k);
}

// For graders: the largest deviation so far in this test, in tolerances.
void RecordMargin(const Claim& claim) {
  static const testing::TestInfo* test = nullptr;
  static double largest = 0.0;
  const testing::TestInfo* now = testing::UnitTest::GetInstance()->current_test_info();
  if (now != test) largest = 0.0;
  test = now;
  if (claim.got.rows() != claim.expected.rows() || claim.got.cols() != claim.expected.cols()) return;
  const double allowed = std::max(claim.tolerance * LargestEntry(claim.expected), std::numeric_limits<double>::min());
  largest = std::max(largest, LargestEntry(Deviation(claim)) / allowed);
  if (std::isfinite(largest)) testing::Test::RecordProperty("margin", Number(largest));
}

// For a grader's picture: rows of '.', 'o' or 'x' for an entry that is zero, not zero, or wrong; "" if it is too large.
std::string Picture(const Claim& claim) {
  constexpr Eigen::Index kMost = 90;
  const MatXX& E = claim.expected;
  if (claim.got.rows() != E.rows() || claim.got.cols() != E.cols() || E.rows() > kMost || E.cols() > kMost) return "";
  const MatXX deviation = Deviation(claim);
  const double allowed = claim.tolerance * LargestEntry(E);
  std::string rows;
  for (Eigen::Index i = 0; i < E.rows(); ++i) {
    if (i > 0) rows += '/';
    for (Eigen::Index j = 0; j < E.cols(); ++j) rows += deviation(i, j) > allowed ? 'x' : E(i, j) == 0.0 ? '.' : 'o';
  }
  return rows;
}

}  // namespace

std::string Number(double x) {
  std::ostringstream out;
  out << x;
  return out.str();
}

bool HoldsUnset(const MatXX& A) { return Any(A, &IsFresh) || Any(A, &IsFreed); }

bool Equal(const MatXX& got, const MatXX& expected, double tolerance) {
  if (got.rows() != expected.rows() || got.cols() != expected.cols()) return false;
  if (got.size() == 0) return true;
  return got.allFinite() && LargestEntry(got - expected) <= tolerance * LargestEntry(expected);
}

std::string Story(const Claim& claim) {
  RecordMargin(claim);
  if (Equal(claim.got, claim.expected, claim.tolerance)) return "";
  testing::Test::RecordProperty("picture", Picture(claim));
  std::ostringstream story;
  story << "Stage " << claim.stage << ": " << claim.what;
  if (claim.got.rows() != claim.expected.rows() || claim.got.cols() != claim.expected.cols()) {
    Tell(&story, "expected", "a matrix of size " + Size(claim.expected));
    Tell(&story, "got", "one of size " + Size(claim.got));
    Tell(&story, "cause",
         claim.got.size() == 0
             ? "still empty: nothing was assigned to " + Called(claim)
             : "the number of rows or columns in a block(…) or segment(…) is not that of the block meant");
    TellWhereToRead(&story, claim.stage, claim.todo);
    return story.str();
  }
  if (claim.got.rows() <= kSmall && claim.got.cols() <= kSmall) {
    Tell(&story, "expected", Whole(claim.expected));
    Tell(&story, "got", Whole(claim.got));
  } else {
    TellEntry(&story, claim);
  }
  const Mistake* mistake = FindMistake(claim);
  Tell(&story, "cause", mistake == nullptr ? Symptom(claim) : mistake->cause);
  TellWhereToRead(&story, claim.stage, mistake == nullptr || mistake->todo.empty() ? claim.todo : mistake->todo);
  return story.str();
}

std::string Story(const std::string& stage, const std::string& what, const std::string& expected,
                  const std::string& got, const std::string& cause, const std::string& todo) {
  std::ostringstream story;
  story << "Stage " << stage << ": " << what;
  Tell(&story, "expected", expected);
  Tell(&story, "got", got);
  Tell(&story, "cause", cause);
  TellWhereToRead(&story, stage, todo);
  return story.str();
}

Names RowNames(const Ordering& ordering, bool numbered) {
  Names names;
  for (const auto* vertices : {&ordering.poses, &ordering.landmarks}) {
    const std::string role = vertices == &ordering.poses ? "pose " : "landmark ";
    for (size_t i = 0; i < vertices->size(); ++i) {
      const Vertex& vertex = *(*vertices)[i];
      const std::string name =
          numbered ? role + std::to_string(i) : vertex.TypeInfo() + " " + std::to_string(vertex.Id());
      for (int k = 0; k < vertex.LocalDimension(); ++k) names.push_back(name + Component(vertex, k));
    }
  }
  return names;
}

}  // namespace ch5::homework
