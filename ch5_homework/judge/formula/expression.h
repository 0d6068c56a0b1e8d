#pragma once
/// A formula as data: named blocks that know where they are read, and what is done with them.
///
///   const Source H("H", A);
///   const Expression H_pp = H.Block("H_pp", 0, 0, p, p), …;
///   const Expression S = H_pp - H_pm * Inverse(H_mm) * H_mp;
///   Value(S)      the right answer
///   NameOf(S)     "H_pp − H_pm H_mm⁻¹ H_mp"
///
/// What a slip in it gives: slips.h.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ch5_backend/math/eigen_types.h"
#include "ch5_homework/judge/diagnosis.h"

namespace ch5::homework::formula {

struct Node;
using Expression = std::shared_ptr<const Node>;

/// Rows or columns that belong together, by name: those of a pose.
struct Part {
  Text name;
  Eigen::Index begin, size;
};

/// A matrix of which blocks are taken.
class Source {
 public:
  /// The same matrix as it may be taken by mistake: undamped, before rows were moved.
  struct Other {
    Text name;
    MatXX A;
  };

  Source(const std::string& name, const MatXX& A, const std::vector<Other>& others = {},
         const std::vector<Part>& parts = {});
  /// @param todo  where a student reads it: "1.2a"
  Expression Block(const std::string& name, Eigen::Index row, Eigen::Index column, Eigen::Index rows,
                   Eigen::Index columns, const std::string& todo = {}) const;
  /// Of a vector.
  Expression Segment(const std::string& name, Eigen::Index row, Eigen::Index rows, const std::string& todo = {}) const {
    return Block(name, row, 0, rows, 1, todo);
  }

  struct Data {
    std::string name;
    MatXX A;
    std::vector<Other> others;
    std::vector<Part> parts;  ///< of its rows, and of its columns if it is square
  };

 private:
  std::shared_ptr<const Data> data_;
};

enum class Kind { kMatrix, kInverse, kTranspose, kProduct, kSum, kStack, kSeen, kAssembly };

/// Where a share of an assembly is added.
struct Place {
  Eigen::Index row = 0, column = 0;
};

/// What one edge, or one landmark, adds to a matrix.
struct Share {
  Expression x;  ///< shares whose expressions have one name are written by one statement of the student's loop
  Place place;
  Text from = {};                ///< "edge 3"
  std::vector<Text> kinds = {};  ///< what it is one of: "the mirrored blocks"
  struct Elsewhere {
    Text name;
    Place place;
    bool transposed = false;
  };
  std::vector<Elsewhere> elsewhere = {};  ///< where it may be added by mistake; outside of the matrix: not at all
  bool assigned = false;                  ///< = for +=
  struct Turn {
    Text loop;
    size_t number, count;
  };
  std::vector<Turn> turns = {};  ///< of the loops that it is added in, which the shares of one assembly have in common
};

/// What may be taken for a node by mistake, and the sentence about it; without one the two names are said.
struct Instead {
  Expression x;
  Text cause;

  Instead(const Expression& x, const Text& cause = {}) : x(x), cause(cause) {}
};

struct Node {
  Kind kind;
  std::string name = {};  ///< of a matrix, and of what the student's code gives a name: "tempH"
  std::string todo = {};  ///< where the student writes it; empty: where he writes what it is a part of
  std::vector<Expression> parts = {};
  std::vector<double> factors = {};                 ///< of a sum
  std::vector<int> sizes = {};                      ///< of the blocks of an inverse that is made block by block
  MatXX value = {};                                 ///< of a matrix
  std::shared_ptr<const Source::Data> source = {};  ///< of a matrix that is a block of one, from (row, column) on
  Eigen::Index row = 0, column = 0;
  std::vector<Instead> mistaken = {};              ///< what may be taken for it
  std::vector<Share> shares = {};                  ///< of an assembly; their expressions are its parts
  Eigen::Index rows = 0, columns = 0;              ///< likewise
  std::function<MatXX(const MatXX& x)> seen = {};  ///< what a check sees of its part
  mutable std::optional<std::optional<MatXX>> known = {};
};

/// A matrix that is read nowhere: x_p, which has been solved for.
Expression Matrix(const std::string& name, const MatXX& value, const std::string& todo = {});
/// What the student's code calls by a name, or writes elsewhere.
Expression Named(const Expression& x, const std::string& name, const std::string& todo = {});
/// With what may be taken for it, and for nothing else.
Expression MistakenFor(const Expression& x, const std::vector<Instead>& others);
Expression WrittenAt(const std::string& todo, const Expression& x);
/// Of a symmetric matrix, which has to be positive semi-definite, the pseudo-inverse.
/// @param sizes  of the blocks of one that is block diagonal: block by block
Expression Inverse(const Expression& x, const std::vector<int>& sizes = {});
Expression Transpose(const Expression& x);
/// A loop's sum: zeros, to which each share is added at its place.
Expression Assembly(const std::string& name, Eigen::Index rows, Eigen::Index columns, std::vector<Share> shares);
/// One below the other.
Expression Stack(const std::vector<Expression>& parts);
/// What a check compares of x, which alone is the student's: JᵀJ of J.
Expression Seen(const Expression& x, const std::function<MatXX(const MatXX& x)>& how);
Expression Sum(const std::vector<Expression>& terms, const std::vector<double>& factors);
Expression Product(const std::vector<Expression>& factors);
Expression operator+(const Expression& a, const Expression& b);
Expression operator-(const Expression& a, const Expression& b);
Expression operator-(const Expression& a);
Expression operator*(const Expression& a, const Expression& b);
Expression operator*(double factor, const Expression& a);

/// Nothing where the sizes do not fit, or a block is not positive definite.
const std::optional<MatXX>& TryValue(const Expression& x);
/// @throws std::logic_error if there is none
const MatXX& Value(const Expression& x);
/// As the handout writes it.
std::string NameOf(const Expression& x);
/// The same as a factor, in brackets if it is a sum.
std::string FactorName(const Expression& x);

}  // namespace ch5::homework::formula
