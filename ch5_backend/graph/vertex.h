#pragma once
/// A vertex is one block of the unknowns: a value x on a manifold and the rule x ⊞ δ that moves it.

#include <algorithm>
#include <stdexcept>
#include <string>

#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

/// Where the ordering puts a vertex: poses first, landmarks last; only landmarks are eliminated.
enum class Role { kPose, kLandmark };

class Vertex {
 public:
  virtual ~Vertex() = default;
  Vertex(const Vertex&) = delete;
  Vertex& operator=(const Vertex&) = delete;

  /// Number of stored parameters (a pose: 7).
  int Dimension() const { return dimension_; }
  /// Number of degrees of freedom, the size of δ (a pose: 6).
  int LocalDimension() const { return local_dimension_; }

  /// The parameters, Dimension()×1, as a view. Who writes them keeps what the type asks for, such as a quaternion of length
  /// 1; SetEstimate sees to it.
  Eigen::Map<VecX> Parameters() { return {parameters_, dimension_}; }
  Eigen::Map<const VecX> Parameters() const { return {parameters_, dimension_}; }

  /// x ← x ⊞ δ;  `delta` points to LocalDimension() numbers.
  virtual void Plus(const double* delta) = 0;

  /// δ = x ⊟ x₀: how far x is from `x0` (Dimension() numbers), LocalDimension()×1.
  virtual VecX Minus(const VecX& x0) const = 0;
  /// ∂((x ⊞ δ) ⊟ x₀)/∂δ at δ = 0, square; the identity where x = x₀, and everywhere in a vector space.
  virtual MatXX MinusJacobian(const VecX& /*x0*/) const { return MatXX::Identity(local_dimension_, local_dimension_); }

  /// Either or both into a caller's memory, as a prior asks for them in every iteration; null: not wanted. Types that ask for
  /// no memory here seal Minus, so that no other δ comes from a class made of them.
  virtual void MinusInto(const VecX& x0, double* delta, double* derivative) const {
    if (delta) Eigen::Map<VecX>(delta, local_dimension_) = Minus(x0);
    if (derivative) Eigen::Map<MatXX>(derivative, local_dimension_, local_dimension_) = MinusJacobian(x0);
  }

  /// The type's name, as it appears in messages.
  virtual std::string TypeInfo() const = 0;
  /// The same, and the id once it is in a graph.
  std::string Name() const { return TypeInfo() + (id_ < 0 ? "" : " " + std::to_string(id_)); }

  /// Saves x, so that a rejected step can be undone to the last bit.
  void BackUpParameters() { std::copy_n(parameters_, dimension_, backup_); }
  void RollBackParameters() { std::copy_n(backup_, dimension_, parameters_); }

  /// Residuals depend on a fixed vertex, but it has no rows and columns in H.
  bool IsFixed() const { return fixed_; }
  void SetFixed(bool fixed = true) { fixed_ = fixed; }

  Role GetRole() const { return role_; }
  void SetRole(Role role) { role_ = role; }

  /// Number within its graph, in order of insertion; −1 outside of a graph.
  int Id() const { return id_; }

  /// First row of this vertex in H and b; −1 if it is fixed or has no edge. Set by MakeOrdering.
  int OrderingId() const { return ordering_id_; }
  void SetOrderingId(int ordering_id) { ordering_id_ = ordering_id; }

 protected:
  [[noreturn]] void ThrowMissing(const char* function) const {
    throw std::logic_error(TypeInfo() + " has " + std::to_string(dimension_) + " parameters and " +
                           std::to_string(local_dimension_) + " degrees of freedom, so it needs a " + function +
                           " of its own");
  }

  Vertex(int dimension, int local_dimension, double* parameters, double* backup, Role role)
      : dimension_(dimension),
        local_dimension_(local_dimension),
        parameters_(parameters),
        backup_(backup),
        role_(role) {}

 private:
  friend class Graph;  // numbers its vertices

  int dimension_;
  int local_dimension_;
  double* parameters_;  // the memory belongs to SizedVertex
  double* backup_;
  Role role_;
  bool fixed_ = false;
  int id_ = -1;
  int ordering_id_ = -1;
};

/// A vertex with `D` parameters and `T` degrees of freedom, stored in place.
template <int D, int T>
class SizedVertex : public Vertex {
 public:
  static constexpr int kDimension = D;
  static constexpr int kLocalDimension = T;
  using Estimate = Eigen::Matrix<double, D, 1>;

  const Estimate& GetEstimate() const { return x_; }
  void SetEstimate(const Estimate& x) { x_ = x; }

  /// Vector spaces add; manifolds override both.
  /// @throws std::logic_error if D ≠ T, so that these cannot be the right ones
  void Plus(const double* delta) override {
    if constexpr (D != T) ThrowMissing("Plus");
    if constexpr (D == T) x_ += Eigen::Map<const Estimate>(delta);
  }
  VecX Minus(const VecX& x0) const override {
    if constexpr (D != T) ThrowMissing("Minus");
    if constexpr (D == T) return x_ - x0;
    return VecX();
  }

 protected:
  /// (The base class needs addresses; data() would be a call to what is not made yet.)
  SizedVertex(const Estimate& x, Role role)
      : Vertex(D, T, reinterpret_cast<double*>(&x_), reinterpret_cast<double*>(&backup_), role), x_(x), backup_(x) {}

  Estimate x_;
  Estimate backup_;
};

}  // namespace ch5
