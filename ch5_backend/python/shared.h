#pragma once
/// What the files of the Python module share.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <mutex>
#include <stdexcept>
#include <string>

namespace py = pybind11;

using Rows = py::array_t<double, py::array::c_style | py::array::forcecast>;

// Something that one thread at a time uses: Python's lock is not held while it works.
class OneThread {
 public:
  std::unique_lock<std::recursive_mutex> Use(const char* what) {
    std::unique_lock<std::recursive_mutex> lock(mutex_, std::try_to_lock);
    if (!lock) throw std::runtime_error(std::string(what) + ": another thread is using it");
    return lock;
  }

 private:
  std::recursive_mutex mutex_;
};

/// Of estimator.cc.
void DefineEstimator(py::module_& module);
