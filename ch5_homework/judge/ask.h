#pragma once
/// How a stage test asks for what a student's functions do: by the name of a check (checks/), which runs in this process
/// (main.cc), or in a worker (remote/remote.cc).

#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {

/// @throws std::exception that has kept the worker from answering; what the student's function has thrown is in the answer
Answer Ask(const std::string& check, const Values& given = {});
/// About a scene, which is built again, in its present states, where the student's code runs.
inline Answer Ask(const std::string& check, Scene& scene, Values given = {}) {
  scene.Describe(&given);
  return Ask(check, given);
}

/// What the k-th call of a solver has left (checks/problem.cc, checks/block_solver.cc).
struct Solved {
  bool solved;
  VecX delta_x, b_S, b;
  MatXX S, H;

  Solved(const Answer& answer, size_t k)
      : solved(answer.Number(Numbered("solved", k)) != 0.0),
        delta_x(answer.Vector(Numbered("delta_x", k))),
        b_S(answer.Vector(Numbered("b_S", k))),
        b(answer.Vector(Numbered("b", k))),
        S(answer[Numbered("S", k)]),
        H(answer[Numbered("H", k)]) {}
};

}  // namespace ch5::homework
