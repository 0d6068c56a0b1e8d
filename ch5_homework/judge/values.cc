#include "ch5_homework/judge/values.h"

#include <algorithm>
#include <cmath>

namespace ch5::homework {
namespace {

std::string SizeOf(Eigen::Index rows, Eigen::Index columns) {
  return std::to_string(rows) + "×" + std::to_string(columns);
}

}  // namespace

int Whole(double x) {
  if (!(std::abs(x) < 2147483648.0) || x != std::trunc(x)) throw WireError("a number is not whole");
  return static_cast<int>(x);
}

const Values::Value& Values::Find(const std::string& name) const {
  const auto found = all_.find(name);
  if (found == all_.end() && failure_) std::rethrow_exception(failure_);
  if (found == all_.end()) throw WireError("there is no " + name);
  found->second.read = true;
  return found->second.value;
}

const MatXX& Values::operator[](const std::string& name) const {
  const MatXX* matrix = Find(name).Matrix();
  if (matrix == nullptr) throw WireError(name + " is a word");
  return *matrix;
}

const MatXX& Values::Sized(const std::string& name, Eigen::Index rows, Eigen::Index columns) const {
  const MatXX& A = (*this)[name];
  if (A.rows() == rows && A.cols() == columns) return A;
  throw WireError(name + " is " + SizeOf(A.rows(), A.cols()) + " in place of " + SizeOf(rows, columns));
}

VecX Values::Vector(const std::string& name) const { return Sized(name, (*this)[name].rows(), 1); }

Transform Values::Pose(const std::string& name) const {
  const VecX T = Sized(name, 7, 1);
  return {Qd(T[6], T[3], T[4], T[5]), T.head<3>()};
}

const std::string& Values::Word(const std::string& name) const {
  const std::string* word = Find(name).Word();
  if (word == nullptr) throw WireError(name + " is no word");
  return *word;
}

int& Answer::Unread() {
  static int unread = 0;
  return unread;
}

int Answer::Count() const {
  return static_cast<int>(std::count_if(all_.begin(), all_.end(), [](const auto& one) { return !one.second.read; }));
}

}  // namespace ch5::homework
