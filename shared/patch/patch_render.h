// Blends between consecutive patches.
#pragma once

#include <Eigen/Core>

#include "shared/patch/patch_contact.h"

namespace palpate {

// Keeps the newest patch and, for 30 ms, the previous one. The force changes gradually between
// them, and the contact keeps its anchors. Each patch alone is passive, and the passivity control
// removes energy of the change. Real-time safe. Not thread-safe.
class PatchRender {
 public:
  static constexpr double kBlendTime = PatchContact::kBlendTime;  // [s]

  // These functions are those of PatchContact.
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
  double since_ = -1e9;  // arrival of the newest patch [s]
};

}  // namespace palpate
