#include "ch5_homework/judge/diagnosis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <ctime>
#include <limits>
#include <map>
#include <optional>
#include <sstream>

#include "ch5_homework/judge/explains.h"
#include "ch5_homework/judge/fingerprint.h"
#include "ch5_homework/judge/formula/slips.h"
#include "ch5_homework/judge/unset_memory.h"

namespace ch5::homework {
namespace {

constexpr int kSmall = 3;               // matrices up to this size are shown whole
constexpr double kMistakeMatch = 1e-6;  // how near to a mistake's answer counts as that mistake

std::string Size(const MatXX& A) { return std::to_string(A.rows()) + "×" + std::to_string(A.cols()); }

constexpr int kDigits = 6, kMoreDigits = 12;  // more where fewer would show the same numbers

std::string Whole(const MatXX& A, int digits) {
  std::ostringstream out;
  out << A.format(Eigen::IOFormat(digits, 0, "  ", "\n", "[ ", " ]"));
  return out.str();
}

double LargestEntry(const MatXX& A) { return A.size() == 0 ? 0.0 : A.cwiseAbs().maxCoeff(); }

// What Require compares.
struct Claim {
  const Check& check;
  const MatXX &expected, &got;
  const formula::Formula* formula = nullptr;

  double Allowed() const { return check.tolerance * LargestEntry(expected); }
};

// |got − expected|, with infinity where `got` is not finite.
MatXX Deviation(const Claim& claim) {
  return (claim.got - claim.expected).unaryExpr([](double x) {
    return std::isfinite(x) ? std::abs(x) : std::numeric_limits<double>::infinity();
  });
}

bool HaveSameBits(const MatXX& A, const MatXX& B) {
  const auto bytes = static_cast<size_t>(B.size()) * sizeof(double);
  return A.rows() == B.rows() && A.cols() == B.cols() && std::memcmp(A.data(), B.data(), bytes) == 0;
}

bool HaveOneSize(const MatXX& A, const MatXX& B) { return A.rows() == B.rows() && A.cols() == B.cols(); }

// Whether the student has a mistake's answer; a numerical one is nearer to it than to the right one. What differs by more than
// rounding is another: a part kept from a call in other units may be as small as that.
bool IsAnswer(const Claim& claim, const MatXX& answer) {
  if (!claim.got.allFinite()) return HaveSameBits(answer, claim.got);
  if (!Equal(claim.got, answer, std::min(kMistakeMatch, 1e-3 * claim.check.tolerance))) return false;
  return !HaveOneSize(answer, claim.expected) ||
         LargestEntry(claim.got - answer) <= 0.1 * LargestEntry(answer - claim.expected);
}

// The right answers so far, of calls that were right, by what they are called.
struct Earlier {
  std::vector<MatXX> answers;
  std::vector<formula::Formula> formulas;  // of the first ones
};
Earlier& CallsBefore(const Claim& claim) {
  static std::map<std::string, Earlier> calls;
  return calls[claim.check.variable];
}

bool IsOfAnEarlierCall(const Claim& claim) {
  const auto& answers = CallsBefore(claim).answers;
  return std::any_of(answers.begin(), answers.end(),
                     [&](const MatXX& answer) { return Equal(claim.got, answer, kMistakeMatch); });
}

bool IsAddedToAnEarlierCall(const Claim& claim) {
  const auto& answers = CallsBefore(claim).answers;
  return std::any_of(answers.begin(), answers.end(), [&](const MatXX& answer) {
    return HaveOneSize(answer, claim.expected) && !answer.isZero(0.0) &&
           Equal(claim.got, answer + claim.expected, 1e-9);
  });
}

// A mistake, and whether it is a slip in the formula.
struct Found {
  Mistake mistake;
  bool is_slip = false;
};

// Memory that was never set, or has been freed, gets its own message.
std::optional<Found> FindMistake(const Claim& claim) {
  if (HoldsUnset(claim.got) || claim.got.size() == 0) return {};
  const auto find = [&](const Mistakes& among) -> std::optional<Found> {
    const auto found = std::find_if(among.begin(), among.end(),
                                    [&](const Mistake& mistake) { return IsAnswer(claim, mistake.answer); });
    return found == among.end() ? std::nullopt : std::optional(Found{*found});
  };
  if (const auto found = find(claim.check.mistakes)) return found;
  if (claim.formula == nullptr || claim.got.isZero(0.0)) return {};  // many slips give zero
  const auto is = [&](const MatXX& answer) { return IsAnswer(claim, answer); };
  if (const auto slip = FindSlip(*claim.formula, claim.got, is, CallsBefore(claim).formulas)) return Found{*slip, true};
  return find(claim.check.vaguer);
}

// A slip that was found in an earlier run of the same tests: does it explain all wrong answers?
struct Asked {
  std::string formula, cause;
  std::clock_t spent = 0;  // on comparing
};
std::optional<Asked>& AskedCause() {
  static std::optional<Asked> asked;
  return asked;
}

// The same slip in another call may have other numbers: where a block is read depends on sizes.
std::string WithoutNumbers(std::string text) {
  text.erase(
      std::remove_if(text.begin(), text.end(), [](char c) { return std::strchr("+-.0123456789", c) != nullptr; }),
      text.end());
  return text;
}

// Notes in the report if the slip cannot have given this wrong answer, though it could be made here.
void CompareWithAsked(const Claim& claim) {
  Asked& asked = *AskedCause();
  if (claim.formula == nullptr || NameOf(claim.formula->right) != asked.formula) return;
  if (claim.got.size() == 0 || !claim.got.allFinite() || asked.spent > CLOCKS_PER_SEC) return;
  const std::clock_t begin = std::clock();
  bool is_tried = false;
  const auto is = [&](const MatXX& answer) {
    is_tried = true;
    return IsAnswer(claim, answer);
  };
  const auto is_asked = [&](const Text& cause) { return WithoutNumbers(cause.Json()) == asked.cause; };
  if (!FindSlip(*claim.formula, claim.got, is, CallsBefore(claim).formulas, is_asked) && is_tried) {
    testing::Test::RecordProperty("refuted", "true");
  }
  asked.spent += std::clock() - begin;
}

Text Called(const Claim& claim) {
  const std::string& variable = claim.check.variable;
  return variable.empty() ? Text("matrix.it") : Word(variable);
}

bool Any(const MatXX& A, bool (*is)(double)) { return std::any_of(A.data(), A.data() + A.size(), is); }

// What a NaN tells us: memory that was never written, or has been freed, is filled with NaNs of different kinds.
Text SymptomOfNaN(const Claim& claim) {
  if (Any(claim.got, &IsFreed)) return "matrix.freed_memory_read";
  if (Any(claim.got, &IsFresh)) {
    const bool all = std::all_of(claim.got.data(), claim.got.data() + claim.got.size(), &IsFresh);
    return all ? Text("matrix.never_set", {{"variable", Called(claim)}}) : "matrix.some_never_set";
  }
  return "matrix.not_finite";
}

// k if got = k · expected, otherwise NaN.
double Ratio(const MatXX& got, const MatXX& expected) {
  const double k = got.cwiseProduct(expected).sum() / expected.squaredNorm();
  const bool is = std::abs(k) > 1e-9 && Equal(got, k * expected, kMistakeMatch * std::min(1.0, std::abs(k)));
  return is ? k : std::numeric_limits<double>::quiet_NaN();
}

bool HasIntegersAlone(const MatXX& A) {
  return A == A.unaryExpr([](double x) { return std::trunc(x); });
}

bool SameNumbersElsewhere(MatXX got, MatXX expected, double tolerance) {
  std::sort(got.data(), got.data() + got.size());
  std::sort(expected.data(), expected.data() + expected.size());
  return Equal(got, expected, tolerance);
}

bool IsSymmetric(const MatXX& A) { return A.rows() == A.cols() && A.rows() > 1 && Equal(A, A.transpose(), 1e-9); }

// x if A has x on its diagonal, more than once, else zeros; otherwise 0.
double OnTheDiagonal(const MatXX& A, double zero) {
  if (A.rows() != A.cols() || A.rows() == 1) return 0.0;
  const VecX diagonal = A.diagonal();
  Eigen::Index largest = 0;
  diagonal.cwiseAbs().maxCoeff(&largest);
  const double x = diagonal[largest];
  const auto is = [&](double d) { return std::abs(d) <= zero || std::abs(d - x) <= zero; };
  const bool all = std::all_of(diagonal.data(), diagonal.data() + diagonal.size(), is);
  const bool often = (diagonal.array().abs() > 10.0 * zero).count() > 1;
  return all && often && LargestEntry(A - MatXX(diagonal.asDiagonal())) <= zero ? x : 0.0;
}

// Of a vector whose wrong entries are right ones of other places: where the first belongs. Nothing if that is not certain.
Text BelongsElsewhere(const Claim& claim) {
  if (claim.got.cols() != 1 || HasIntegersAlone(claim.expected)) return {};  // where whole numbers meet by chance
  const VecX got = claim.got, expected = claim.expected;
  Text first;
  for (Eigen::Index i = 0; i < got.size(); ++i) {
    if (std::abs(got[i] - expected[i]) <= claim.Allowed()) continue;
    const VecX distance = (expected.array() - got[i]).abs();
    Eigen::Index j = 0;
    distance.minCoeff(&j);
    if ((distance.array() <= 1e-9 * std::abs(got[i])).count() != 1) return {};
    if (first.empty()) first = {"matrix.entry_belongs_elsewhere", {{"i", Word(i)}, {"j", Word(j)}}};
  }
  return first;
}

bool IsHalfOrWhole(double k) { return std::abs(2.0 * k - std::round(2.0 * k)) < 1e-6; }

// The first or the last row or column alone is wrong: a loop begins too late or ends too soon.
Text AtAnEdge(const Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>& wrong) {
  const auto wrong_row = wrong.rowwise().any().eval(), wrong_column = wrong.colwise().any().transpose().eval();
  for (const auto& [is_wrong, first, last] :
       {std::tuple{wrong_row, "matrix.first_row_alone", "matrix.last_row_alone"},
        {wrong_column, "matrix.first_column_alone", "matrix.last_column_alone"}}) {
    if (is_wrong.size() < 3 || is_wrong.count() != 1) continue;
    if (is_wrong[0]) return first;
    if (is_wrong[is_wrong.size() - 1]) return last;
  }
  return {};
}

// Which simple change of the whole matrix explains it; empty if none does.
Text SymptomOfTheWhole(const Claim& claim) {
  const MatXX &got = claim.got, &expected = claim.expected;
  if (got.isZero(0.0)) return {"matrix.still_zero", {{"variable", Called(claim)}}};
  if (expected.isZero(0.0)) return {};
  const double k = Ratio(got, expected);
  if (std::abs(k + 1.0) < 1e-6) return "matrix.sign";
  const double largest = LargestEntry(expected);
  if (const double x = OnTheDiagonal(got - expected, 1e-12 * largest); x != 0.0) {
    return {"matrix.added_to_diagonal", {{"x", Word(x)}}};
  }
  if (std::abs(k - 1.0) < 1e-3) {
    const double difference = LargestEntry(got - expected) / largest;
    return {difference < 3e-7 ? "matrix.nearly_float" : "matrix.nearly", {{"difference", Word(difference)}}};
  }
  const auto is_set = (expected.array() != 0.0).eval();
  if (std::isfinite(k) && is_set.count() > 1)
    return {"matrix.factor", {{"k", Word(k)}}};  // one number alone has any ratio
  // A short vector may be integral by coincidence; so may 2 I, but it is not what is right, rounded.
  const bool rounded = LargestEntry(got) > 1.0 && LargestEntry(got - expected) < 1.0;
  if (got.size() > 6 && rounded && HasIntegersAlone(got) && !HasIntegersAlone(expected)) return "matrix.integers";
  const bool square = got.rows() == got.cols() && got.rows() > 1;
  if (square && Equal(got, expected.transpose(), kMistakeMatch)) return "matrix.transposed";
  if (square && IsSymmetric(expected)) {
    const MatXX upper = expected.triangularView<Eigen::Upper>(), lower = expected.triangularView<Eigen::Lower>();
    if (Equal(got, upper, kMistakeMatch)) return "matrix.only_upper_triangle";
    if (Equal(got, lower, kMistakeMatch)) return "matrix.only_lower_triangle";
  }
  const auto wrong = ((got - expected).array().abs() > claim.Allowed()).eval();
  const MatXX wrong_got = wrong.select(got, 0.0), meant = wrong.select(expected, 0.0);
  if (wrong_got.isZero(0.0)) return "matrix.wrong_entries_are_zero";
  const double k_wrong = Ratio(wrong_got, meant);  // not finite where zeros are meant
  if (std::isfinite(k_wrong) && (wrong.count() > 1 || IsHalfOrWhole(k_wrong) || IsHalfOrWhole(1.0 / k_wrong))) {
    return {"matrix.wrong_entries_factor", {{"k", Word(k_wrong)}}};
  }
  if (const Text elsewhere = BelongsElsewhere(claim); !elsewhere.empty()) return elsewhere;
  if (SameNumbersElsewhere(got, expected, kMistakeMatch)) return "matrix.wrong_places";
  return AtAnEdge(wrong);
}

// What can be said of a wrong matrix that no typical mistake explains.
Text Symptom(const Claim& claim) {
  if (!claim.got.allFinite() || HoldsUnset(claim.got)) return SymptomOfNaN(claim);
  if (!claim.got.isZero(0.0) && IsOfAnEarlierCall(claim)) {
    return {"matrix.of_an_earlier_call", {{"variable", Called(claim)}}};
  }
  if (IsAddedToAnEarlierCall(claim)) return {"1.1.not_zeroed", {{"it", Called(claim)}}};
  if (const Text whole = SymptomOfTheWhole(claim); !whole.empty()) return whole;
  if (IsSymmetric(claim.expected) && !claim.expected.isDiagonal() && !IsSymmetric(claim.got))
    return "matrix.none_typical_not_symmetric";
  return "matrix.none_typical";
}

// Of a matrix of another size that is no mistake's: which mistake, or what else at hand, is as large.
Text CauseOfSize(const Claim& claim) {
  if (claim.got.size() == 0) return {"matrix.still_empty", {{"variable", Called(claim)}}};
  for (const Mistake& mistake : claim.check.mistakes) {
    if (HaveOneSize(mistake.answer, claim.got)) return mistake.cause;
  }
  for (const auto& other : claim.formula == nullptr ? std::vector<formula::Expression>() : claim.formula->beside) {
    const auto& A = TryValue(other);
    if (A && HaveOneSize(*A, claim.got)) return {"formula.as_large_as", {{"matrix", Word(NameOf(other))}}};
  }
  return "matrix.size_mismatch";
}

// "(3, 4) = 2.5", "entry 3 = 2.5" of a vector.
Text Entry(const MatXX& A, int row, int column, int digits) {
  const std::string value = Number(A(row, column), digits);
  if (A.cols() == 1) return {"matrix.entry", {{"n", Word(row)}, {"value", Word(value)}}};
  return Word("(" + std::to_string(row) + ", " + std::to_string(column) + ") = " + value);
}

// "rows 6 to 11, columns 0 to 5": what the wrong entries lie in, if that is not the whole; of a vector its entries.
Text WrongWithin(const Eigen::Matrix<bool, Eigen::Dynamic, Eigen::Dynamic>& wrong) {
  const auto range = [](const auto& any) {  // of what holds a wrong one
    Eigen::Index first = 0, last = any.size() - 1;
    while (first < last && any[first] == 0.0) ++first;
    while (last > first && any[last] == 0.0) --last;
    return std::pair{first, last};
  };
  const VecX rows = wrong.rowwise().any().cast<double>(), columns = wrong.colwise().any().transpose().cast<double>();
  const auto [top, bottom] = range(rows);
  const auto [left, right] = range(columns);
  if (bottom - top + 1 == wrong.rows() && right - left + 1 == wrong.cols()) return {};
  if (wrong.cols() == 1) return {"matrix.within_entries", {{"i", Word(top)}, {"j", Word(bottom)}}};
  return {"matrix.within", {{"i", Word(top)}, {"j", Word(bottom)}, {"k", Word(left)}, {"l", Word(right)}}};
}

// The worst entry and whose it is.
void CompareEntry(const Claim& claim, Diagnosis* diagnosis) {
  const MatXX deviation = Deviation(claim);
  int row = 0, column = 0;
  deviation.maxCoeff(&row, &column);
  const auto is_wrong = (deviation.array() > claim.Allowed()).matrix().eval();
  const bool alike = Number(claim.expected(row, column)) == Number(claim.got(row, column));
  const int digits = alike ? kMoreDigits : kDigits;
  diagnosis->expected = Entry(claim.expected, row, column, digits);
  diagnosis->got = {"matrix.worst_entry",
                    {{"entry", Entry(claim.got, row, column, digits)},
                     {"wrong", Word(is_wrong.count())},
                     {"all", Word(deviation.size())}}};
  const Names &rows = claim.check.names.rows, &own = claim.check.names.columns, &columns = own.empty() ? rows : own;
  if (row < static_cast<int>(rows.size())) {
    diagnosis->places.push_back({{"diagnosis.row", {{"n", Word(row)}}}, rows[row]});
  }
  if (claim.got.cols() > 1 && column < static_cast<int>(columns.size())) {
    diagnosis->places.push_back({{"diagnosis.column", {{"n", Word(column)}}}, columns[column]});
  }
  if (const Text within = WrongWithin(is_wrong); !within.empty()) {
    diagnosis->places.push_back({"diagnosis.all_wrong_ones", within});
  }
  if (claim.formula == nullptr) return;
  if (const Text terms = TermsOf(claim.formula->right, row, column); !terms.empty()) {
    diagnosis->places.push_back({"diagnosis.terms", terms});
  }
}

// "VertexPose 1", "pose 0", with "δp.y" of a pose, nothing more of a scalar.
Text NameOfRow(const Vertex& vertex, const Text& name, int k) {
  static const char* const kPose[] = {"δp.x", "δp.y", "δp.z", "δθ.x", "δθ.y", "δθ.z"};
  static const char* const kPoint[] = {"x", "y", "z"};
  if (vertex.LocalDimension() == 1) return name;
  const bool is_pose = vertex.TypeInfo() == "VertexPose";
  if (!is_pose && vertex.TypeInfo() != "VertexPointXYZ") {
    return {"scene.component", {{"vertex", name}, {"n", Word(k)}}};
  }
  return {"scene.row_of", {{"vertex", name}, {"component", Word(std::string(is_pose ? kPose[k] : kPoint[k]))}}};
}

// For graders: the largest deviation so far in this test, in tolerances.
void RecordMargin(const Claim& claim) {
  static const testing::TestInfo* test = nullptr;
  static double largest = 0.0;
  const testing::TestInfo* now = testing::UnitTest::GetInstance()->current_test_info();
  if (now != test) largest = 0.0;
  test = now;
  if (!HaveOneSize(claim.got, claim.expected)) return;
  const double allowed = std::max(claim.Allowed(), std::numeric_limits<double>::min());
  largest = std::max(largest, LargestEntry(Deviation(claim)) / allowed);
  if (std::isfinite(largest)) testing::Test::RecordProperty("margin", Number(largest));
}

// For a grader's picture: rows of '.', 'o' or 'x' for an entry that is zero, not zero, or wrong; "" if it is too large.
std::string Picture(const Claim& claim) {
  constexpr Eigen::Index kMost = 90;
  const MatXX& E = claim.expected;
  if (!HaveOneSize(claim.got, E) || E.rows() > kMost || E.cols() > kMost) return "";
  const MatXX deviation = Deviation(claim);
  const double allowed = claim.Allowed();
  std::string rows;
  for (Eigen::Index i = 0; i < E.rows(); ++i) {
    if (i > 0) rows += '/';
    for (Eigen::Index j = 0; j < E.cols(); ++j) rows += deviation(i, j) > allowed ? 'x' : E(i, j) == 0.0 ? '.' : 'o';
  }
  return rows;
}

// A JSON list.
std::string Json(const Names& names) {
  std::string json;
  for (const Text& name : names) json += (json.empty() ? "[" : ", ") + name.Json();
  return json.empty() ? "[]" : json + "]";
}

std::string JsonString(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c == '\n' ? "\\n" : std::string(1, c);
  }
  return quoted + "\"";
}

// "1.1" in the tests Stage11.
std::string StageNow() {
  const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
  std::string stage = test == nullptr ? "" : std::string(test->test_suite_name()).substr(std::strlen("Stage"));
  return stage.size() > 1 ? stage.insert(1, ".") : stage;
}

[[noreturn]] void Tell(const Diagnosis& diagnosis) {
  std::string json = "{\"stage\": " + JsonString(StageNow()) + ", \"check\": " + diagnosis.check.Json();
  for (const auto& [name, text] : {std::pair{"expected", &diagnosis.expected},
                                   {"got", &diagnosis.got},
                                   {"cause", &diagnosis.cause},
                                   {"symptom", &diagnosis.symptom}}) {
    if (!text->empty()) json += std::string(", \"") + name + "\": " + text->Json();
  }
  std::string places;
  for (const auto& [place, name] : diagnosis.places) {
    places += (places.empty() ? "[" : ", [") + place.Json() + ", " + name.Json() + "]";
  }
  if (!diagnosis.formula.empty()) json += ", \"formula\": " + JsonString(diagnosis.formula);
  if (diagnosis.elsewhere) json += ", \"elsewhere\": true";
  if (!diagnosis.fingerprint.empty()) json += ", \"fingerprint\": " + diagnosis.fingerprint;
  json += ", \"places\": [" + places + "], \"todo\": " + JsonString(diagnosis.todo) + "}";
  testing::Test::RecordProperty("diagnosis", json);
  ADD_FAILURE() << json;
  throw testing::AssertionException({testing::TestPartResult::kFatalFailure, __FILE__, __LINE__, "told"});
}

}  // namespace

Text::Text(const char* id, const std::vector<Argument>& arguments) {
  std::string json = "{\"id\": " + JsonString(id);
  for (const Argument& argument : arguments) json += ", " + JsonString(argument.name) + ": " + argument.value.Json();
  json_ = std::make_shared<std::string>(json + "}");
}

Text::Text(const char* id, std::initializer_list<Argument> arguments) : Text(id, std::vector<Argument>(arguments)) {}

Text Text::Quoted(const std::string& words) {
  Text text;
  text.json_ = std::make_shared<std::string>("{\"quoted\": " + JsonString(words) + "}");
  return text;
}

Text Text::Word(const std::string& word) {
  Text text;
  text.json_ = std::make_shared<std::string>(JsonString(word));
  return text;
}

const std::string& Text::Json() const {
  static const std::string nothing;
  return empty() ? nothing : *json_;
}

std::string Number(double x, int digits) {
  std::ostringstream out;
  out.precision(digits);
  out << x;
  return out.str();
}

std::string Join(const std::vector<int>& numbers) {
  std::string text;
  for (const int number : numbers) text += (text.empty() ? "" : ", ") + std::to_string(number);
  return text;
}

Mistake CholeskyOfSingular(const std::string& todo, const char* matrix, const VecX& eigenvalues, const MatXX& J,
                           const MatXX& gram) {
  const bool is = (eigenvalues.array() == 0.0).any() && J.isUpperTriangular(1e-12) && !J.isDiagonal(1e-12);
  return {todo, {"formula.cholesky_of_singular", {{"matrix", Word(std::string(matrix))}}}, is ? gram : MatXX()};
}

bool HoldsUnset(const MatXX& A) { return Any(A, &IsFresh) || Any(A, &IsFreed); }

bool Equal(const MatXX& got, const MatXX& expected, double tolerance) {
  if (!HaveOneSize(got, expected)) return false;
  if (got.size() == 0) return true;
  return got.allFinite() && expected.allFinite() && LargestEntry(got - expected) <= tolerance * LargestEntry(expected);
}

namespace {

// What was expected and what came: the sizes, all of a small matrix, or the worst entry of a large one.
void Compare(const Claim& claim, Diagnosis* diagnosis) {
  const MatXX &expected = claim.expected, &got = claim.got;
  if (!HaveOneSize(got, expected)) {
    diagnosis->expected = {"matrix.size_expected", {{"size", Word(Size(expected))}}};
    diagnosis->got = {"matrix.size_got", {{"size", Word(Size(got))}}};
  } else if (got.rows() <= kSmall && got.cols() <= kSmall) {
    const int digits = Whole(expected, kDigits) == Whole(got, kDigits) ? kMoreDigits : kDigits;
    diagnosis->expected = Word(Whole(expected, digits));
    diagnosis->got = Word(Whole(got, digits));
  } else {
    CompareEntry(claim, diagnosis);
  }
}

void Require(const Claim& claim) {
  const auto& [check, expected, got, formula] = claim;
  RecordMargin(claim);
  if (Equal(got, expected, check.tolerance)) {
    if (check.variable.empty()) return;
    Earlier& before = CallsBefore(claim);
    before.answers.push_back(expected);
    constexpr size_t kMostKept = 6;
    if (formula != nullptr && before.formulas.size() < kMostKept) before.formulas.push_back(*formula);
    return;
  }
  if (AskedCause()) return CompareWithAsked(claim);  // then the other calls
  testing::Test::RecordProperty("picture", Picture(claim));
  testing::Test::RecordProperty("rows", Json(check.names.rows));
  testing::Test::RecordProperty("columns", Json(check.names.columns));
  Diagnosis diagnosis{check.what, {}, {}, {}, check.todo};
  if (!HoldsUnset(got)) diagnosis.fingerprint = Fingerprint(expected, got);
  const auto found = FindMistake(claim);
  const Text symptom = found && !found->is_slip     ? Text()
                       : HaveOneSize(got, expected) ? Symptom(claim)
                                                    : CauseOfSize(claim);
  if (found && !found->mistake.todo.empty()) diagnosis.todo = found->mistake.todo;
  diagnosis.cause = found ? found->mistake.cause : symptom;
  if (found && found->is_slip) {
    diagnosis.formula = NameOf(formula->right);
    diagnosis.elsewhere = found->mistake.elsewhere;
    diagnosis.symptom = symptom;
  }
  Compare(claim, &diagnosis);
  Tell(diagnosis);
}

}  // namespace

void Require(const Check& check, const MatXX& right, const MatXX& got) { Require({check, right, got}); }

void Require(const Check& check, const formula::Formula& right, const MatXX& got) {
  Require({check, Value(right.right), got, &right});
}

bool TakeAskedCause(const std::string& option) {
  const std::string name = "--explains=";
  const size_t end = option.find("={", name.size());
  if (option.rfind(name, 0) != 0 || end == std::string::npos) return false;
  AskedCause() = Asked{option.substr(name.size(), end - name.size()), WithoutNumbers(option.substr(end + 1))};
  return true;
}

void Fail(Diagnosis diagnosis) {
  if (diagnosis.fingerprint.empty() && !diagnosis.got.empty())
    diagnosis.fingerprint = Fingerprint(diagnosis.expected.Json(), diagnosis.got.Json());
  Tell(diagnosis);
}

Names Words(const std::vector<std::string>& words) {
  Names names;
  for (const std::string& word : words) names.push_back(Word(word));
  return names;
}

Names RowNames(const std::vector<std::shared_ptr<Vertex>>& vertices, const char* role) {
  Names names;
  for (size_t i = 0; i < vertices.size(); ++i) {
    const Text name = role != nullptr ? Text(role, {{"n", Word(i)}}) : Word(vertices[i]->Name());
    for (int k = 0; k < vertices[i]->LocalDimension(); ++k) names.push_back(NameOfRow(*vertices[i], name, k));
  }
  return names;
}

Names RowNames(const Ordering& ordering, bool numbered) {
  return RowNames(ordering.poses, numbered ? "scene.pose" : nullptr) +
         RowNames(ordering.landmarks, numbered ? "scene.landmark" : nullptr);
}

Names operator+(Names names, const Names& more) {
  names.insert(names.end(), more.begin(), more.end());
  return names;
}

}  // namespace ch5::homework
