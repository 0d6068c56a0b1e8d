#pragma once
/// The vertices and edges that a program in Python makes: parameters in NumPy's memory; residuals that are functions of Python,
/// or formulas compiled in C++.

#include <dlfcn.h>
#include <pybind11/eigen.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "ch5_backend/graph/c_formula.h"
#include "ch5_backend/graph/edge.h"
#include "ch5_backend/python/shared.h"
#include "ch5_backend/types/plus_jacobian.h"

// A base class, so that it is there before the vertex.
struct Memory {
  py::array_t<double> now;  // NumPy's, so that an array can be shared
  ch5::VecX before;
};

// Numbers that add, as many as are given.
class VertexNumbers : private Memory, public ch5::Vertex {
 public:
  VertexNumbers(const py::array_t<double>& x, bool landmark)
      : Memory{x, ch5::VecX(x.size())},
        Vertex(static_cast<int>(x.size()), static_cast<int>(x.size()), now.mutable_data(), before.data(),
               landmark ? ch5::Role::kLandmark : ch5::Role::kPose) {}
  void Plus(const double* delta) override { Parameters() += Eigen::Map<const ch5::VecX>(delta, Dimension()); }
  ch5::VecX Minus(const ch5::VecX& x0) const override { return Parameters() - x0; }
  std::string TypeInfo() const override { return "Vector"; }
};

// A view of a vertex' parameters, not a copy; the vertex lives as long.
inline py::array_t<double> View(const std::shared_ptr<ch5::Vertex>& vertex) {
  const py::capsule keep(new std::shared_ptr<ch5::Vertex>(vertex),
                         [](void* kept) { delete static_cast<std::shared_ptr<ch5::Vertex>*>(kept); });
  py::array_t<double> view(vertex->Dimension(), vertex->Parameters().data(), keep);
  view.attr("flags").attr("writeable") = false;
  return view;
}

// An edge whose sizes are known at run time.
class EdgeOfAnySize : public ch5::Edge {
 public:
  EdgeOfAnySize(std::vector<std::shared_ptr<ch5::Vertex>> vertices, int size)
      : Edge(size, std::move(vertices), nullptr, nullptr),
        r_(ch5::VecX::Zero(size)),
        W_(ch5::MatXX::Identity(size, size)) {
    SetMemory(r_.data(), W_.data());
  }

 protected:
  void TakeJacobians() const override {
    if (!J_.empty()) return;
    for (const auto& vertex : vertices_) J_.emplace_back(ch5::MatXX::Zero(r_.size(), vertex->LocalDimension()));
    for (size_t i = 0; i < J_.size(); ++i) jacobians_[i] = J_[i].data();
  }

  ch5::VecX r_;
  ch5::MatXX W_;
  mutable std::vector<ch5::MatXX> J_;
};

// A residual in Python, differentiated numerically; or residual and Jacobians, if `jacobians` is there. Solving goes on without
// Python's lock, which is taken for each call.
class EdgeFunction : public EdgeOfAnySize {
 public:
  EdgeFunction(std::vector<std::shared_ptr<ch5::Vertex>> vertices, py::function residual, int size,
               py::object jacobians)
      : EdgeOfAnySize(std::move(vertices), size),
        residual_function_(std::move(residual)),
        jacobian_function_(std::move(jacobians)),
        arguments_(vertices_.size()) {
    for (size_t i = 0; i < vertices_.size(); ++i) {
      if (vertices_[i]) arguments_[i] = View(vertices_[i]);  // AddEdge refuses a missing one
    }
  }

  void ComputeResidual() override {
    const py::gil_scoped_acquire lock;
    Take(residual_function_(*arguments_), &r_);
  }
  void ComputeJacobians() override {
    if (jacobian_function_.is_none()) return Edge::ComputeJacobians();
    TakeJacobians();
    const py::gil_scoped_acquire lock;
    const py::object given = jacobian_function_(*arguments_);
    if (!py::isinstance<py::sequence>(given) || py::len(given) != J_.size()) {
      throw std::invalid_argument(Name() + ": its jacobians are no list of " + std::to_string(J_.size()) +
                                  " matrices, one a vertex");
    }
    for (size_t i = 0; i < J_.size(); ++i) Take(given[py::int_(i)], &J_[i]);
  }
  std::string TypeInfo() const override { return "Edge of Python"; }

 private:
  // What a function has returned; for a single number a float will do.
  template <typename Matrix>
  void Take(const py::handle& given, Matrix* own) const {
    const bool is_number = PyNumber_Check(given.ptr()) != 0 && !py::isinstance<py::array>(given);
    if (is_number && own->size() == 1) return void(own->setConstant(given.cast<double>()));
    const auto size = [](Eigen::Index rows, Eigen::Index columns) {
      return std::to_string(rows) + "x" + std::to_string(columns) + " numbers";
    };
    std::string got = py::str(py::type::of(given).attr("__name__"));
    try {
      const auto numbers = given.cast<Matrix>();
      got = size(numbers.rows(), numbers.cols());
      if (numbers.rows() == own->rows() && numbers.cols() == own->cols()) return void(*own = numbers);
    } catch (const py::cast_error&) {  // got is its type
    }
    throw std::invalid_argument(Name() + ": its function returned " + got + ", expected " +
                                size(own->rows(), own->cols()));
  }

  py::function residual_function_;
  py::object jacobian_function_;
  py::tuple arguments_;
};

// A formula that was compiled in C++, by its name in a shared library (graph/c_formula.h).
struct Formula {
  Formula(const std::string& path, const std::string& name) {
    void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);  // for as long as the program runs
    if (!library) throw std::invalid_argument(std::string("Formula: ") + dlerror());
    const auto get = reinterpret_cast<const Ch5Formula* (*)()>(dlsym(library, name.c_str()));
    if (!get) throw std::invalid_argument("Formula: " + path + " has no formula '" + name + "': CH5_FORMULA makes one");
    it = get();
  }
  const Ch5Formula* it;
};

// An edge with a compiled formula, whose numbers stay in NumPy's memory.
class EdgeFormula : public EdgeOfAnySize {
 public:
  EdgeFormula(const Formula& formula, std::vector<std::shared_ptr<ch5::Vertex>> vertices, Rows numbers, py::ssize_t row)
      : EdgeOfAnySize(std::move(vertices), formula.it->rows),
        formula_(formula.it),
        memory_(std::move(numbers)),
        numbers_(formula.it->numbers > 0 ? memory_.data(row) : nullptr) {
    const auto wanted = static_cast<size_t>(formula_->vertices);
    if (vertices_.size() != wanted)
      throw std::invalid_argument("Formula: " + std::to_string(vertices_.size()) + " vertices, expected " +
                                  std::to_string(wanted));
    for (size_t i = 0; i < wanted; ++i) {
      const auto& vertex = vertices_[i];
      if (!vertex) throw std::invalid_argument("Formula: vertex " + std::to_string(i) + " is missing");
      if (vertex->Dimension() != formula_->parameters[i])
        throw std::invalid_argument("Formula: vertex " + std::to_string(i) + " has " +
                                    std::to_string(vertex->Dimension()) + " parameters, expected " +
                                    std::to_string(formula_->parameters[i]));
      x_.push_back(vertex->Parameters().data());
      by_parameters_.emplace_back(ch5::MatXX::Zero(formula_->rows, vertex->Dimension()));
      J_of_parameters_.push_back(by_parameters_.back().data());
    }
  }
  void ComputeResidual() override { formula_->evaluate(x_.data(), numbers_, r_.data(), nullptr); }
  void ComputeJacobians() override {
    TakeJacobians();
    formula_->evaluate(x_.data(), numbers_, r_.data(), J_of_parameters_.data());
    for (size_t i = 0; i < J_.size(); ++i) {
      const auto* const pose = dynamic_cast<const ch5::VertexPose*>(vertices_[i].get());
      if (pose)
        J_[i] = by_parameters_[i] * ch5::PlusJacobian(*pose);
      else
        J_[i] = by_parameters_[i];
    }
  }
  std::string TypeInfo() const override { return "Edge of a formula"; }

 private:
  const Ch5Formula* formula_;
  Rows memory_;
  const double* numbers_;
  std::vector<const double*> x_;
  std::vector<ch5::MatXX> by_parameters_;
  std::vector<double*> J_of_parameters_;
};
