#pragma once
/// A window policy that passes everything on to another, for a study to watch its slides or to change what it wants to.

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "ch5_backend/window/policy.h"

namespace ch5 {

class WrappedPolicy : public WindowPolicy {
 public:
  /// Called in place of each slide of a window, which `slide` then does.
  using SlideWatch = std::function<void(Window* window, const std::function<void()>& slide)>;

  explicit WrappedPolicy(std::unique_ptr<WindowPolicy> policy, SlideWatch watch = nullptr)
      : policy_(std::move(policy)), watch_(std::move(watch)) {}
  std::string Name() const override { return policy_->Name(); }
  void NoteNewFrame(Window* window) override { policy_->NoteNewFrame(window); }
  bool Uses(const Window& window, const WindowLandmark& landmark) const override {
    return policy_->Uses(window, landmark);
  }
  SolveOptions Options() const override { return policy_->Options(); }
  void AfterSolve(Window* window) override { policy_->AfterSolve(window); }
  void Slide(Window* window) override {
    const auto slide = [&] { policy_->Slide(window); };
    watch_ ? watch_(window, slide) : slide();
  }
  size_t MostFrames() const override { return policy_->MostFrames(); }
  void Reset() override { policy_->Reset(); }

 private:
  std::unique_ptr<WindowPolicy> policy_;
  SlideWatch watch_;
};

}  // namespace ch5
