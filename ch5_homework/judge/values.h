#pragma once
/// Matrices and words by name: what a check is given, and what it answers. It is all that crosses the wire between judge and
/// worker (remote/wire.h).

#include <exception>
#include <initializer_list>
#include <map>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "ch5_backend/math/so3.h"

namespace ch5::homework {

/// What came from a worker is no reply, or does not fit: reported as a failure of the worker (remote/process.h).
class WireError : public std::runtime_error {
 public:
  explicit WireError(const std::string& what) : std::runtime_error("GARBAGE: " + what) {}
};

/// "x0 3": what there are several of.
template <typename Integer>
std::string Numbered(const char* name, Integer k) {
  return name + (" " + std::to_string(k));
}

/// @throws WireError unless it is a whole number that an int can be
int Whole(double x);

class Values {
 public:
  /// A matrix, also for a number, or a word.
  class Value {
   public:
    template <typename D>
    Value(const Eigen::MatrixBase<D>& A) : is_(MatXX(A)) {}
    template <typename T, std::enable_if_t<std::is_arithmetic_v<T> || std::is_enum_v<T>, int> = 0>
    Value(T x) : is_(MatXX(MatXX::Constant(1, 1, static_cast<double>(x)))) {}
    Value(const std::string& word) : is_(word) {}
    Value(const char* word) : is_(std::string(word)) {}
    /// [p, q], the quaternion as x, y, z, w.
    Value(const Transform& T) : is_(MatXX((VecX(7) << T.p, T.q.coeffs()).finished())) {}

    const MatXX* Matrix() const { return std::get_if<MatXX>(&is_); }
    const std::string* Word() const { return std::get_if<std::string>(&is_); }

   private:
    std::variant<MatXX, std::string> is_;
  };

  Values() = default;
  Values(std::initializer_list<std::pair<const char*, Value>> all) { Put(all); }

  /// A second one of a name is not taken.
  void Put(const std::string& name, const Value& value) { all_.emplace(name, Entry{value}); }
  /// @param number  behind each name (Numbered)
  void Put(std::initializer_list<std::pair<const char*, Value>> all, const std::string& number = {}) {
    for (const auto& [name, value] : all) Put(name + number, value);
  }

  bool Has(const std::string& name) const { return all_.count(name) > 0; }
  /// @throws WireError if there is none of this name and kind, or of this size
  const MatXX& operator[](const std::string& name) const;
  const MatXX& Sized(const std::string& name, Eigen::Index rows, Eigen::Index columns) const;
  VecX Vector(const std::string& name) const;
  double Number(const std::string& name) const { return Sized(name, 1, 1)(0); }
  int Int(const std::string& name) const { return Whole(Number(name)); }
  Transform Pose(const std::string& name) const;
  const std::string& Word(const std::string& name) const;

  size_t size() const { return all_.size(); }
  template <typename Visit>
  void ForEach(const Visit& visit) const {
    for (const auto& [name, entry] : all_) visit(name, entry.value);
  }

 protected:
  struct Entry {
    Value value;
    mutable bool read = false;
  };
  std::map<std::string, Entry> all_;
  std::exception_ptr failure_;  ///< why some may be missing

 private:
  const Value& Find(const std::string& name) const;
};

/// What a check has answered. If the student's function has thrown, that is thrown where the first value that it has not
/// left is read: what came before is judged first.
class Answer : public Values {
 public:
  Answer() = default;
  Answer(Answer&&) = default;
  ~Answer() { Unread() += Count(); }

  void SetFailure(std::exception_ptr failure) { failure_ = std::move(failure); }
  const std::exception_ptr& Failure() const { return failure_; }

  /// How many values of all answers so far have not been read.
  static int& Unread();

 private:
  int Count() const;
};

}  // namespace ch5::homework
