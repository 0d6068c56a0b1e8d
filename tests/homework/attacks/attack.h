#pragma once
/// Hostile submissions of problem.cc. All share one worker: the variable CH5_ATTACK names the one that acts. Where it
/// does not end the process, its answers are wrong (wrong_problem.cc), so that only a trick could pass.

#include <string>

namespace attacks {

/// When an attack acts: in a constructor before main, or in a graded function.
enum class When { kAtStart, kInFunction };

/// Before main. An attack at the start acts at once, if it is the one named.
bool Add(const std::string& name, When when, void (*act)());

/// Called by each graded function.
void Act();

/// What fills the wrong answers, 0 at first.
extern double filling;

}  // namespace attacks
