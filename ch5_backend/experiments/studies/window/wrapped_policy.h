#pragma once
/// A window policy that passes everything on to another, for a study to change what it wants to.

#include <memory>
#include <string>
#include <utility>

#include "ch5_backend/window/policy.h"

namespace ch5 {

class WrappedPolicy : public WindowPolicy {
 public:
  explicit WrappedPolicy(std::unique_ptr<WindowPolicy> policy) : policy_(std::move(policy)) {}
  std::string Name() const override { return policy_->Name(); }
  void NoteNewFrame(Window* window) override { policy_->NoteNewFrame(window); }
  bool Uses(const Window& window, const WindowLandmark& landmark) const override {
    return policy_->Uses(window, landmark);
  }
  SolveOptions Options() const override { return policy_->Options(); }
  void AfterSolve(Window* window) override { policy_->AfterSolve(window); }
  void Slide(Window* window) override { policy_->Slide(window); }
  void SlideWithoutEstimate(Window* window) override { policy_->SlideWithoutEstimate(window); }
  void Reset() override { policy_->Reset(); }

 private:
  std::unique_ptr<WindowPolicy> policy_;
};

}  // namespace ch5
