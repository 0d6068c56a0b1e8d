#pragma once
/// Failures that teach, as data: what was expected, what came, whose entry it is, and which typical mistake gives just
/// this. A diagnosis leaves the test as one line of JSON; its sentences are in ch5_backend/course/base/language.

#include <initializer_list>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "ch5_backend/graph/ordering.h"
#include "ch5_backend/math/eigen_types.h"

namespace ch5::homework {

namespace formula {
struct Formula;
}

/// What is said: a sentence by its id, "assembly.mirror_missing", with what varies in it by name; or a word that is the same in
/// every language (a number, a name of the code), or somebody else's words (the library's); or nothing.
class Text {
 public:
  struct Argument;

  Text() = default;
  Text(const char* id) : Text(id, {}) {}
  Text(const char* id, std::initializer_list<Argument> arguments);
  Text(const char* id, const std::vector<Argument>& arguments);
  static Text Word(const std::string& word);
  static Text Quoted(const std::string& words);

  bool empty() const { return json_ == nullptr; }
  /// A JSON string for a word, {"id": …, argument: …} for a sentence, {"quoted": …}.
  const std::string& Json() const;

 private:
  std::shared_ptr<const std::string> json_;  // shared: each share of an assembly has many
};

struct Text::Argument {
  const char* name;
  Text value;
};

/// At most so many digits: "100", "0.25".
std::string Number(double x, int digits = 6);

/// "1, 1, 0".
std::string Join(const std::vector<int>& numbers);

inline Text Word(const std::string& word) { return Text::Word(word); }
inline Text Word(double x) { return Text::Word(Number(x)); }
template <class Integer, std::enable_if_t<std::is_integral_v<Integer>, int> = 0>
Text Word(Integer n) {
  return Text::Word(std::to_string(n));
}

/// A common mistake. The cause is shown only if the mistake's own wrong answer is what the student has.
struct Mistake {
  std::string todo;  ///< "1.1b"
  Text cause;        ///< "assembly.mirror_missing"
  MatXX answer;
  bool elsewhere = false;  ///< or in another TODO, where what it is about is read or used
};

/// The likelier ones first.
using Mistakes = std::vector<Mistake>;

/// That J, which was to be a root of a singular matrix with these eigenvalues, comes from LLT.
/// @param gram  JᵀJ, as the check compares it
Mistake CholeskyOfSingular(const std::string& todo, const char* matrix, const VecX& eigenvalues, const MatXX& J,
                           const MatXX& gram);

/// What each row or column means: "VertexPose 1, δp.y".
using Names = std::vector<Text>;
Names Words(const std::vector<std::string>& words);

/// Why a check has failed; its stage is that of the test. All but the check may be empty.
struct Diagnosis {
  Text check;  ///< what was compared: "H of one edge between two poses"
  Text expected = {}, got = {};
  Text cause = {};
  std::string todo = {};                           ///< where to read
  std::vector<std::pair<Text, Text>> places = {};  ///< ("row 3", "VertexPose 1, δp.y")
  std::string fingerprint = {};                    ///< of what came (fingerprint.h); empty: Fail makes that of words
  std::string formula = {};                        ///< in which the cause is a slip; empty if it is none
  bool elsewhere = false;                          ///< another TODO than that may hold such a slip
  Text symptom = {};                               ///< of such a cause, what is said if another call refutes it
};

/// Fails the test with a diagnosis, and leaves it. As one line of JSON it is the property "diagnosis" of the test's report,
/// where a worker cannot write.
[[noreturn]] void Fail(Diagnosis diagnosis);

/// Of the rows and columns of a matrix; those of a square one may have the same.
struct Sides {
  Names rows, columns;

  Sides(const Names& rows = {}, const Names& columns = {}) : rows(rows), columns(columns) {}
};

/// What is compared, and how.
struct Check {
  Text what;                  ///< "H of one edge between two poses"
  std::string todo = {};      ///< where to look if no typical mistake explains it
  std::string variable = {};  ///< what the student's code calls it: "H_prior"
  Sides names = {};
  double tolerance = 1e-10;  ///< of the largest expected entry
  Mistakes mistakes = {};    ///< those that are no slips in a formula
  Mistakes vaguer = {};      ///< what else may be said, if neither they nor slips explain it
};
/// Fails the test if a student's matrix or vector differs from the right one.
void Require(const Check& check, const MatXX& right, const MatXX& got);
/// The same with the value of a formula, one of whose slips may explain the difference.
void Require(const Check& check, const formula::Formula& right, const MatXX& got);

/// The names of the vertices' rows: by type and graph id, "VertexPose 4, δp.x", or the place in the list if it is in no graph;
/// or numbered as stage 7 does, "pose 0, δp.x".  @param role  "scene.pose"
Names RowNames(const std::vector<std::shared_ptr<Vertex>>& vertices, const char* role = nullptr);
Names RowNames(const Ordering& ordering, bool numbered = false);
Names operator+(Names names, const Names& more);

/// Whether it holds numbers from memory that was never written to, or has been freed (unset_memory.h).
bool HoldsUnset(const MatXX& A);

/// Whether the matrices have one size and differ by at most `tolerance` of the largest entry of `expected`.
bool Equal(const MatXX& got, const MatXX& expected, double tolerance);

}  // namespace ch5::homework
