#pragma once
/// marginalization_error.cc: stage 5.

#include "ch5_homework/judge/remote/remote.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {

template <>
struct ObjectOf<MarginalizationError> {
  static std::unique_ptr<MarginalizationError> Make(Scene*) { return Chosen().make_marginalization_error(); }
  static auto Members(MarginalizationError& term) { return MembersOf(term); }
};

namespace marginalization_error {

using Term = RemoteObject<MarginalizationError>;

struct InsertBlock {
  static constexpr char kName[] = "InsertBlock";
  static int Run(Term term, int dim, bool is_landmark) { return term.object->InsertBlock(dim, is_landmark); }
};
struct SchurComplement {
  static constexpr char kName[] = "MarginalizationError::SchurComplement";
  /// No members: it is a function of its arguments.
  static void Run(const MatXX& V, const MatXX& W, const VecX& b_b, MatXX* U, VecX* b_a) {
    Chosen().make_marginalization_error()->SchurComplement(V, W, b_b, U, b_a);
  }
};
struct UpdateErrorComputation {
  static constexpr char kName[] = "UpdateErrorComputation";
  static void Run(Term term) { term.object->UpdateErrorComputation(); }
};
struct Residual {
  static constexpr char kName[] = "Residual";
  static VecX Run(Term term, const VecX& delta_chi) { return term.object->Residual(delta_chi); }
};

/// A MarginalizationError whose four graded functions run in the worker.
class RemoteMarginalizationError : public MarginalizationError {
 public:
  int InsertBlock(int dim, bool is_landmark) override {
    return Ask<marginalization_error::InsertBlock>(Here(), dim, is_landmark);
  }
  void SchurComplement(const MatXX& V, const MatXX& W, const VecX& b_b, MatXX* U, VecX* b_a) override {
    Ask<marginalization_error::SchurComplement>(V, W, b_b, U, b_a);
  }
  void UpdateErrorComputation() override { Ask<marginalization_error::UpdateErrorComputation>(Here()); }
  VecX Residual(const VecX& delta_chi) const override {
    return Ask<marginalization_error::Residual>(Here(), delta_chi);
  }

 private:
  Term Here() const { return {handle_, nullptr, const_cast<RemoteMarginalizationError*>(this)}; }

  int handle_ = NewHandle();
};

inline void Remote(Submission* s) {
  s->make_marginalization_error = &Make<MarginalizationError, RemoteMarginalizationError>;
}
inline void Serve() { HandleAll<InsertBlock, SchurComplement, UpdateErrorComputation, Residual>(); }

}  // namespace marginalization_error
}  // namespace ch5::homework
