#pragma once
/// The process that holds the student's code: it answers requests, each by one of the functions that worker_NAME.cc adds.

#include <map>
#include <memory>
#include <string>

#include "ch5_homework/judge/remote/graph_wire.h"

namespace ch5::homework {

/// Reads its arguments, calls the student's function, writes its results.
using Handler = void (*)(Reader* in, Writer* out);

/// Before main.
bool Handle(const std::string& function, Handler handler);

/// The objects of a test, by the judge's handles.
template <typename T>
std::map<int, T>& Kept() {
  static std::map<int, T> kept;
  return kept;
}

}  // namespace ch5::homework
