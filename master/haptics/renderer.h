// From the slave's states to the force at this millisecond, in one of three ways.
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
#include "shared/patch/patch_render.h"
#include "shared/patch/spring.h"
#include "shared/state/slave_state.h"

namespace palpate {

// The contact as the master renders it between two states: one-sided, decided here and not by the
// slave's late word (Adachi et al. 1995; Mark et al. 1996).
//
//   f = f_r + K (x_r - p)   for n . (x_r - p) > 0,   else 0
//
// An f_r into the object, as of the tangent to a law that stiffens, never makes the contact pull.
//
// When the slave changes the plane or the stiffness, x_r, n, f_r and K go from their present to
// their new values in 30 ms, straight in time. The force follows the hand at once and both ways:
// a limit on its rise alone would make a limit cycle, as would dropping the plane on a late "no
// contact".
//
// K is the slave's word. What is rendered of it is its symmetric part without what is negative,
// for anything else turns motion into energy, and no stiffer than can be shown stably:
//
//   K_M < b / (T / 2 + t_d) = 2 b / T    (Colgate & Schenkel 1994; the device waits for nobody)
//
// Where along the plane x_r lies decides the shear. Until the slave tells of contact its x_r is
// only the nearest place, late by the way gone since; the contact then is where the hand came
// through the plane, as it will be for the slave, and nothing pulls sideways. Frame S.
class LocalContact {
 public:
  static constexpr double kBlendTime = 0.030;  // [s]

  // Takes the slave's newest model at `now` [s]. Unknown ones (revision 0) leave the last in place.
  // The first one grows from no stiffness. Real-time safe.
  void Take(const LocalModel& model, double now) noexcept;
  // Moves the tip to `p_S`: force of the object on the tool there [N]. Zero while nothing is known.
  // Real-time safe.
  [[nodiscard]] Eigen::Vector3d ForceAt(const Eigen::Vector3d& p_S, double now) noexcept;
  // The tip is taken elsewhere: where it came through the plane counts no more. Real-time safe.
  void LetGo() noexcept { entry_.reset(); }
  // The model in force at `now`.
  [[nodiscard]] LocalModel At(double now) const noexcept;
  [[nodiscard]] bool known() const noexcept { return to_.known(); }
  [[nodiscard]] bool IsBlending(double now) const noexcept {
    return known() && now - since_ < kBlendTime;
  }
  // The tip is farther from the reference than the slave vouches for.
  [[nodiscard]] bool IsBeyond(const Eigen::Vector3d& p_S) const noexcept;

 private:
  LocalModel from_, to_;
  double since_ = 0;  // when the blend from `from_` to `to_` began [s]
  // Where the tip came through the plane, or what stood for it; nothing: it is outside.
  std::optional<Eigen::Vector3d> entry_;
};

// Finite, a normal of unit length within 1 %, and no number beyond 1e12: fit to be rendered.
bool IsSane(const LocalModel& model) noexcept;

// Forces sampled at the image rate, shown at the haptic rate: delayed by one sample period and
// interpolated linearly over their time stamps (paper A, 3.4, below eq. 7; after Zhuang & Canny
// 2000).
//
//   F(t) = linear through (s_k, F_k) at t - D,   D = newest period + transport delay
//
// The transport delay is the largest arrival - stamp of late: raised at once, lowered slowly, so
// that jitter neither stalls nor hurries the hand. A sample without predecessor is held.
// Exact for constants; a ramp lags by exactly D (reference f, interpolation_60_to_1000).
class DelayedLinear {
 public:
  // A sample with its `stamp` [s] and when it came, `arrival` >= `stamp` [s], both on the reader's
  // clock. Stamps that do not rise are ignored. Real-time safe.
  void Add(double stamp, double arrival, const Eigen::Vector3d& force) noexcept;
  // Zero before the first sample. Real-time safe.
  [[nodiscard]] Eigen::Vector3d At(double now) const noexcept;
  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }
  // Newest sample [N]; zero before the first.
  [[nodiscard]] const Eigen::Vector3d& newest() const noexcept { return samples_[0].force; }
  void Clear() noexcept { *this = DelayedLinear(); }

 private:
  struct Sample {
    double stamp = 0;
    Eigen::Vector3d force{0, 0, 0};
  };
  static constexpr int kKept = 8;
  std::array<Sample, kKept> samples_{};  // newest first
  int count_ = 0;
  double transport_ = 0;  // [s]
};

// `local` goes down by steps, and up again, each in tens of milliseconds:
//
//   patch   the surface around the contact (PatchRender), where the tool is on one
//   plane   the plane of the states (LocalContact): old slaves, and off the patch
//   hold    the newest force, while what the model said was worth less (RenderFallbackSelector)
class Renderer {
 public:
  // `stiffest`: that is rendered, at the tool [N/m].
  explicit Renderer(RenderMode mode, double stiffest = std::numeric_limits<double>::infinity())
      : mode_(mode), stiffest_(stiffest) {}

  // Between two engagements.
  void set_mode(RenderMode mode) noexcept { mode_ = mode; }
  [[nodiscard]] RenderMode mode() const noexcept { return mode_; }
  void set_stiffest(double stiffest) noexcept {
    stiffest_ = stiffest;
    patch_.set_stiffest(stiffest);
  }

  // Takes a new state that was `sensed` and `arrived` then, now being `now`: all on the master's
  // clock [s]. States that repeat what was sensed count once. Real-time safe.
  void Take(const SlaveState& state, double sensed, double arrived, double now) noexcept;
  // Takes a patch or a law of it, sensed at `at`, now being `now`: master's clock [s]. Real-time
  // safe.
  void TakePatch(const SurfacePatch& patch, const PatchLaw& law, double at, double now) noexcept {
    patch_.Take(patch, law, at, now);
  }
  // The settings are others: what is known of the surface holds no more.
  void ForgetPatch() noexcept { patch_.Forget(); }
  // How long a command is on its way [s]: so far ahead is a surface that moves.
  void set_ahead(double ahead) noexcept { ahead_ = ahead; }
  // What was commanded at `commanded` [s] was felt as `state` tells. Real-time safe.
  void CompareWithSlave(double commanded, const SlaveState& state) noexcept;
  // Force of the object on the tool at `p_S`, S [N], with what became of it. Real-time safe.
  Eigen::Vector3d Render(const Eigen::Vector3d& p_S, double now, Reasons* reasons) noexcept;
  // Forgets the forces, keeps the surface: before a new engagement. Real-time safe.
  void ForgetForces() noexcept {
    samples_.Clear();
    contact_.LetGo();
    patch_.LetGo();
    missing_.setZero();
  }
  [[nodiscard]] const LocalContact& contact() const noexcept { return contact_; }
  [[nodiscard]] const PatchRender& patch() const noexcept { return patch_; }

 private:
  static constexpr double kPunctureTime = 0.010;  // to zero when the tool breaks through [s]
  static constexpr double kReturnTime = 0.050;    // and back when it is clear [s]
  static constexpr double kStepTime = 0.030;      // from one step of `local` to the next [s]
  static constexpr double kNews = 0.030;          // what was felt of a place is news, to 1 / e [s]

  // What a learnt law says, and by how much more was felt, as far as that is still news: of foam it
  // knows one way for pressing and letting go.
  [[nodiscard]] Eigen::Vector3d Corrected(const Eigen::Vector3d& model, double now) const noexcept;
  [[nodiscard]] Eigen::Vector3d RenderLocal(const Eigen::Vector3d& p_S, double now, double dt,
                                            Reasons* reasons) noexcept;

  RenderMode mode_;
  double stiffest_;
  bool projected_ = false;  // the newest model's stiffness was no spring that can be shown
  LocalContact contact_;
  PatchRender patch_;
  double ahead_ = 0;                      // [s]
  double on_patch_ = 0, held_share_ = 0;  // 0: the step above or below; 1: this one
  RenderFallbackSelector selector_;
  Eigen::Vector3d missing_{0, 0, 0};  // of the newest sample [N], commanded at `missed_at_` [s]
  double missed_at_ = 0;
  DelayedLinear samples_;
  bool punctured_ = false;
  double presence_ = 1;  // 0: punctured, 1: intact
  double last_ = 0;      // the tick before [s]
};

}  // namespace palpate
