#pragma once
/// How a stage test asks for what a student's functions do: by the name of a check (checks/), which runs in this process
/// (ask.cc), or in a worker (remote/remote.cc).

#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {

/// @throws what has kept the worker from answering; what the student's function has thrown is in the answer
Answer Ask(const std::string& check, const Values& given = {});
/// About a scene, which is built again, in its present states, where the student's code runs.
inline Answer Ask(const std::string& check, Scene& scene, Values given = {}) {
  scene.Describe(&given);
  return Ask(check, given);
}

}  // namespace ch5::homework
