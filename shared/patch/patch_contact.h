// The contact with one patch, solved anew at each place of the tool: what the master shows between
// two words of the slave, and what the slave compares with what it feels.
#pragma once

#include <array>
#include <limits>

#include <Eigen/Core>

#include "shared/patch/patch_place.h"
#include "shared/state/surface_patch.h"

namespace palpate {

// Each tool is a sphere whose centre moves with the tip. Where it came through the surface at rest
// it sticks (its anchor); with friction mu the anchor is dragged along by what exceeds mu f_n,
// without friction it stays below the tool. There
//
//   sum_b C_ab f_b = d_a,   n_a . f_a >= 0,   f = r(depth) f_linear
//
// d: displacement of the surface below each tool, C: compliance of the nodes there, a place's own
// block a mean of its vertices' by their weights, r: the law's ratio. Solved by kSweeps of block
// Gauss-Seidel that begin with the last tick's forces and never pull; of one tool it is exact.
// Nothing is solved where the patch ends. Frame S. Real-time safe; one thread.
class PatchContact {
 public:
  static constexpr double kBlendTime = 0.030;  // from one law to the next [s]
  static constexpr int kSweeps = 12;

  // `at`: when the law was sensed, like `now` on the caller's clock [s]. Of the same epoch as
  // before the law is blended in; of another one all begins anew.
  void Take(const SurfacePatch& patch, const PatchLaw& law, double at, double now) noexcept;
  void TakeLaw(const PatchLaw& law, double at, double now) noexcept;
  // Goes on sticking where `before` does.
  void Resume(const PatchContact& before) noexcept;
  // Forgets the contact: the tool is taken elsewhere.
  void LetGo() noexcept;
  // Knows no patch any more.
  void Forget() noexcept {
    LetGo();
    patch_.epoch = 0;
  }
  // Moves the tip to `p_S`: force of the object on the first tool there [N]. `then`: the instant,
  // maybe ahead, for which a surface that moves is predicted [s].
  Eigen::Vector3d ForceAt(const Eigen::Vector3d& p_S, double now, double then) noexcept;

  // That is shown [N/m]; what is stiffer is made as stiff.
  void set_stiffest(double stiffest) noexcept { stiffest_ = stiffest; }
  [[nodiscard]] const SurfacePatch& patch() const noexcept { return patch_; }
  [[nodiscard]] const PatchLaw& law() const noexcept { return to_.law; }
  // How far the surface has moved, as of `now`, at the instant `then` [m].
  [[nodiscard]] Eigen::Vector3d ShiftAt(double now, double then) const noexcept;
  // Of the last ForceAt, of the first tool: it touches, and how deep; the patch knows the place.
  [[nodiscard]] bool touches() const noexcept { return touches_[0].touching; }
  [[nodiscard]] double depth() const noexcept { return depth_; }  // [m]; negative outside
  [[nodiscard]] const Eigen::Vector3d& normal() const noexcept { return touches_[0].place.normal; }
  [[nodiscard]] bool serves() const noexcept { return serves_; }
  // Deeper than the model vouches for.
  [[nodiscard]] bool is_beyond() const noexcept { return depth_ > patch_.valid_depth; }
  // The stiffness of the last ForceAt was more than can be shown.
  [[nodiscard]] bool is_capped() const noexcept { return capped_; }

 private:
  struct TimedLaw {
    PatchLaw law;
    double at = 0;  // [s]
  };
  struct Touch {
    bool touching = false, has_last = false;
    Eigen::Vector3d last_centre{0, 0, 0};
    double last_gap = 0;
    PatchPlace place;  // the anchor and its normal
    Eigen::Matrix3d K = Eigen::Matrix3d::Zero();
    Eigen::Vector3d d{0, 0, 0};       // of the surface [m], from the tool outwards
    Eigen::Vector3d linear{0, 0, 0};  // force before the law [N]
    Eigen::Vector3d force{0, 0, 0};
  };
  [[nodiscard]] double ShareOfNew(double now) const noexcept;
  [[nodiscard]] double RatioAt(double depth, double now) const noexcept;
  [[nodiscard]] double SteepestRatio() const noexcept;
  void Move(int tool, const Eigen::Vector3d& centre) noexcept;
  void Enter(int tool, const Eigen::Vector3d& centre, const PatchPlace& nearest) noexcept;
  void StickAt(int tool, const Eigen::Vector3d& p) noexcept;
  void Slide(int tool, const Eigen::Vector3d& centre) noexcept;
  void SolveAll() noexcept;
  void Relax(int tool) noexcept;
  [[nodiscard]] Eigen::Matrix3d BlockOf(int node, int other) const noexcept;
  [[nodiscard]] Eigen::Matrix3d OwnCompliance(const PatchPlace& place) const noexcept;
  [[nodiscard]] Eigen::Matrix3d StiffnessAt(const PatchPlace& place) noexcept;
  [[nodiscard]] Eigen::Vector3d MovedBy(int tool, int other) const noexcept;

  SurfacePatch patch_;
  TimedLaw from_, to_;
  double since_ = 0;  // when the newer law came [s]
  double stiffest_ = std::numeric_limits<double>::infinity();
  double steepest_ratio_ = 1;
  std::array<Touch, kPatchTools> touches_;
  double depth_ = 0;
  bool serves_ = false, capped_ = false;
};

}  // namespace palpate
