// Computes the force of each tick from the slave's states, in one of three rendering modes.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include <Eigen/Core>

#include "master/haptics/force_chain.h"
#include "master/haptics/render_fallback_selector.h"
#include "master/haptics/render_mode.h"
#include "shared/patch/patch_contact.h"
#include "shared/state/slave_state.h"

namespace palpate {

// The local contact between two states. It is one-sided, and the master decides about contact
// instead of the delayed slave (Adachi et al. 1995; Mark et al. 1996).
//
//   f = f_r + K (x_r - p)   for n . (x_r - p) > 0,   else 0
//
// An f_r into the object, such as of the tangent of a stiffening curve, never makes the contact
// pull.
//
// When the slave changes the plane or the stiffness, x_r, n, f_r and K change linearly within 30
// ms. The force follows the device at once in both directions. A limit on its rise alone would
// cause a limit cycle, and so would dropping the plane at a late "no contact".
//
// K comes from the slave. The master renders its symmetric part without negative eigenvalues,
// because anything else would create energy. Its largest stable stiffness is:
//
//   K_M < b / (T / 2 + t_d) = 2 b / T    (Colgate & Schenkel 1994; t_d = 0 for a local model)
//
// The position of x_r along the plane determines the shear force. Until the slave reports contact,
// x_r is only the nearest point of an older tool position. The contact point is then where the tool
// passed the plane, so that there is no sideways force. Frame S.
class LocalContact {
 public:
  static constexpr double kBlendTime = 0.030;  // [s]

  // Sets the slave's newest model at `now` [s]. An unknown model (revision 0) is ignored. The first
  // model starts with zero stiffness. Real-time safe.
  void Take(const LocalModel& model, double now) noexcept;
  // Moves the tip to `p_S` and returns the force of the object on the tool [N]. Zero without a
  // model. Real-time safe.
  [[nodiscard]] Eigen::Vector3d ForceAt(const Eigen::Vector3d& p_S, double now) noexcept;
  // Forgets where the tip passed the plane. Real-time safe.
  void EndContact() noexcept { entry_.reset(); }
  // The active model at `now` [s].
  [[nodiscard]] LocalModel At(double now) const noexcept;
  [[nodiscard]] bool known() const noexcept { return to_.known(); }
  [[nodiscard]] bool IsBlending(double now) const noexcept {
    return known() && now - since_ < kBlendTime;
  }
  // Returns whether the tip is outside the valid radius of the model.
  [[nodiscard]] bool IsBeyond(const Eigen::Vector3d& p_S) const noexcept;

 private:
  LocalModel from_, to_;
  double since_ = 0;  // when the blend from `from_` to `to_` began [s]
  // The position at which the tip passed the plane is kept while the tip is inside; nullopt
  // outside.
  std::optional<Eigen::Vector3d> entry_;
};

// Returns whether `model` can be rendered: finite, a unit normal within 1 %, and no number beyond
// 1e12.
bool IsSane(const LocalModel& model) noexcept;

// Converts forces at the image rate to the haptic rate: delays them by one sample period and the
// transport delay, and interpolates linearly over their timestamps (paper A, section 3.4, below
// eq. 7; after Zhuang & Canny 2000).
//
//   F(t) = linear through (s_k, F_k) at t - D,   D = newest period + transport delay
//
// The transport delay is the largest recent arrival - stamp. It rises at once and falls slowly, so
// that jitter does not change the speed of the force. A sample without predecessor is held.
// Constants are exact, and a ramp lags by exactly D (reference f, interpolation_60_to_1000).
class DelayedLinear {
 public:
  // Adds a sample with its `stamp` [s] and `arrival` >= `stamp` [s], both on the reader's clock.
  // Samples with stamps that do not rise are ignored. Real-time safe.
  void Add(double stamp, double arrival, const Eigen::Vector3d& force) noexcept;
  // The force at `now` [s]; zero before the first sample. Real-time safe.
  [[nodiscard]] Eigen::Vector3d At(double now) const noexcept;
  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }
  // Returns the newest sample [N]; zero before the first.
  [[nodiscard]] const Eigen::Vector3d& newest() const noexcept { return samples_[0].force; }
  void Clear() noexcept { *this = DelayedLinear(); }

 private:
  struct Sample {
    double stamp = 0;
    Eigen::Vector3d force{0, 0, 0};
  };
  static constexpr int kMaxKept = 8;
  std::array<Sample, kMaxKept> samples_{};  // newest first
  int count_ = 0;
  double transport_ = 0;  // [s]
};

// `local` has three levels, and changes between them within tens of milliseconds:
//
//   patch   the surface around the contact (PatchRender), where the tool is on one
//   plane   the plane of the states (LocalContact): outside the patch, or without patches
//   hold    the newest force, while the model is worse (RenderFallbackSelector)
class Renderer {
 public:
  // `stiffest`: largest rendered stiffness, at the tool [N/m].
  explicit Renderer(RenderMode mode, double stiffest = std::numeric_limits<double>::infinity())
      : mode_(mode), stiffest_(stiffest) {}

  // Call it between two engagements.
  void set_mode(RenderMode mode) noexcept { mode_ = mode; }
  [[nodiscard]] RenderMode mode() const noexcept { return mode_; }
  void set_stiffest(double stiffest) noexcept {
    stiffest_ = stiffest;
    patch_.set_stiffest(stiffest);
  }

  // Takes a new state with its times of sensing, arrival and now, all on the master's clock [s].
  // States of the same sample count once. Real-time safe.
  void Take(const SlaveState& state, double sensed, double arrived, double now) noexcept;
  // Takes a patch with its force-depth curve, sensed at `at`; both times on the master's clock [s].
  // Real-time safe.
  void TakePatch(const SurfacePatch& patch, const PatchLaw& law, double at, double now) noexcept {
    patch_.Take(patch, law, at, now);
  }
  // Forgets the surface, because the settings have changed.
  void ForgetPatch() noexcept { patch_.Forget(); }
  // Sets the delay of a command [s], by which a moving surface is extrapolated.
  void set_ahead(double ahead) noexcept { ahead_ = ahead; }
  // Compares the model with `state`, the response to the command of `commanded` [s]. Real-time
  // safe.
  void CompareWithSlave(double commanded, const SlaveState& state) noexcept;
  // Force of the object on the tool at `p_S`, S [N]. Adds the reasons of changes. Real-time safe.
  Eigen::Vector3d Render(const Eigen::Vector3d& p_S, double now, Reasons* reasons) noexcept;
  // Forgets the forces and keeps the surface, before a new engagement. Real-time safe.
  void ForgetForces() noexcept {
    samples_.Clear();
    contact_.EndContact();
    patch_.EndContact();
    missing_.setZero();
  }
  [[nodiscard]] const LocalContact& contact() const noexcept { return contact_; }
  // Stiffness of the newest plane of the states along its normal, before it is limited, S [N/m];
  // 0: none.
  [[nodiscard]] double reported_stiffness() const noexcept { return reported_stiffness_; }
  [[nodiscard]] const PatchRender& patch() const noexcept { return patch_; }

 private:
  static constexpr double kPunctureTime = 0.010;  // fade to zero after a puncture [s]
  static constexpr double kReturnTime = 0.050;    // fade back after it [s]
  static constexpr double kStepTime = 0.030;      // transition between two levels of `local` [s]
  static constexpr double kNews = 0.030;          // time constant of the measured correction [s]

  // The force of an identified curve plus the decaying measured correction. The curve of foam has
  // no hysteresis, so the correction supplies it.
  [[nodiscard]] Eigen::Vector3d Corrected(const Eigen::Vector3d& model, double now) const noexcept;
  [[nodiscard]] Eigen::Vector3d RenderLocal(const Eigen::Vector3d& p_S, double now, double dt,
                                            Reasons* reasons) noexcept;

  RenderMode mode_;
  double stiffest_;
  double reported_stiffness_ = 0;
  bool projected_ = false;  // the newest model's stiffness was replaced by a stable spring
  LocalContact contact_;
  PatchRender patch_;
  double ahead_ = 0;                      // [s]
  double on_patch_ = 0, held_share_ = 0;  // 0: the other level; 1: this level
  RenderFallbackSelector selector_;
  Eigen::Vector3d missing_{0, 0, 0};  // estimate minus model [N] of `missed_at_`
  double missed_at_ = 0;              // command time of the newest sample [s]
  DelayedLinear samples_;
  bool punctured_ = false;
  double presence_ = 1;  // 0: punctured, 1: intact
  double last_ = 0;      // time of the previous tick [s]
};

}  // namespace palpate
