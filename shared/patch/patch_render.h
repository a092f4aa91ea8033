// From one patch to the next without a step.
#pragma once

#include <Eigen/Core>

#include "shared/patch/patch_contact.h"

namespace palpate {

// Holds the newest patch and, for 30 ms, the one before: the force goes over from what that shows
// to what this shows, whatever the hand does meanwhile, and the contact sticks where it stuck.
// Either is a spring at any time; what the change itself would give out, the control of passivity
// after this does not let through. Real-time safe; one thread.
class PatchRender {
 public:
  static constexpr double kBlendTime = PatchContact::kBlendTime;  // [s]

  // See PatchContact::Take.
  void Take(const SurfacePatch& patch, const PatchLaw& law, double at, double now) noexcept;
  void LetGo() noexcept;
  void Forget() noexcept;
  Eigen::Vector3d ForceAt(const Eigen::Vector3d& p_S, double now, double then) noexcept;
  void set_stiffest(double stiffest) noexcept;
  [[nodiscard]] bool known() const noexcept { return newest_.patch().known(); }
  [[nodiscard]] bool IsBlending(double now) const noexcept { return now - since_ < kBlendTime; }
  [[nodiscard]] const PatchContact& newest() const noexcept { return newest_; }

 private:
  PatchContact newest_, before_;
  double since_ = -1e9;  // when the newest patch came [s]
};

}  // namespace palpate
