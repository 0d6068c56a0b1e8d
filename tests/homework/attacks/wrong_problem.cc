/// A problem.cc whose answers are wrong, after whatever the attack does.

#include <cstdlib>
#include <map>

#include "ch5_backend/dense/problem.h"
#include "tests/homework/attacks/attack.h"

namespace attacks {
namespace {

std::map<std::string, void (*)()>& InFunction() {
  static std::map<std::string, void (*)()> attacks;
  return attacks;
}

std::string Named() {
  const char* name = std::getenv("CH5_ATTACK");
  return name == nullptr ? "" : name;
}

}  // namespace

bool Add(const std::string& name, When when, void (*act)()) {
  if (when == When::kInFunction) InFunction()[name] = act;
  if (when == When::kAtStart && name == Named()) act();
  return true;
}

double filling = 0.0;

void Act() {
  const auto attack = InFunction().find(Named());
  if (attack != InFunction().end()) attack->second();
}

}  // namespace attacks

namespace ch5 {

void Problem::MakeHessian() {
  attacks::Act();
  Hessian_.setConstant(Size(), Size(), attacks::filling);
  b_.setConstant(Size(), attacks::filling);
}

bool Problem::SolveLinearSystem(double, VecX* delta_x) {
  attacks::Act();
  delta_x->setConstant(Size(), attacks::filling);
  return true;
}

MarginalizeResult Problem::TestMarginalize(MatXX H_marg, VecX b_marg, int, int) {
  attacks::Act();
  H_marg.setConstant(attacks::filling);
  return {H_marg, b_marg, H_marg, b_marg};
}

}  // namespace ch5
