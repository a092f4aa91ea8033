// Contact with one surface patch, solved for each tool position. The master renders it between two
// states. The slave compares it with its estimate.
#pragma once

#include <array>
#include <limits>

#include <Eigen/Core>

#include "shared/patch/patch_place.h"
#include "shared/state/surface_patch.h"

namespace palpate {

// The nearest symmetric stiffness to `K` with eigenvalues from 0 to `most` [N/m]. A `K` that
// fulfils this is returned unchanged. Finite input gives finite output. Real-time safe.
Eigen::Matrix3d NearestSpring(const Eigen::Matrix3d& K, double most) noexcept;

// Each tool is a sphere that moves with the tip. It sticks at its anchor, where it passed the
// surface at rest. With friction mu, tangential force above mu f_n drags the anchor along. Without
// friction the anchor stays below the tool. There
//
//   sum_b C_ab f_b = d_a,   n_a . f_a >= 0,   f = r(depth) f_linear
//
// d: displacement of the surface below each tool; C: compliance of the nodes, weighted by vertices
// within a block; r: ratio of the force-depth curve. Solved by kSweeps of block Gauss-Seidel,
// starting with the last forces, which never pull. It is exact for one tool. Nothing is solved
// outside of the patch. Frame S. Real-time safe. Not thread-safe.
class PatchContact {
 public:
  static constexpr double kBlendTime = 0.030;  // transition between two force-depth curves [s]
  static constexpr int kSweeps = 12;

  // Sets patch and force-depth curve. `at`: its sample time; `now`: both on the caller's clock [s].
  // With the same epoch the curve is blended in. Another epoch starts from the beginning.
  void Take(const SurfacePatch& patch, const PatchLaw& law, double at, double now) noexcept;
  void TakeLaw(const PatchLaw& law, double at, double now) noexcept;
  // Takes over the anchors of `before`.
  void Resume(const PatchContact& before) noexcept;
  // Forgets the contact.
  void EndContact() noexcept;
  // Forgets the patch.
  void Forget() noexcept {
    EndContact();
    patch_.epoch = 0;
  }
  // Moves the tip to `p_S` and returns the force of the object on the first tool [N]. `then`: the
  // time, possibly later, for which a moving surface is predicted [s].
  Eigen::Vector3d ForceAt(const Eigen::Vector3d& p_S, double now, double then) noexcept;

  // Sets the largest rendered stiffness [N/m].
  void set_stiffest(double stiffest) noexcept { stiffest_ = stiffest; }
  [[nodiscard]] const SurfacePatch& patch() const noexcept { return patch_; }
  [[nodiscard]] const PatchLaw& law() const noexcept { return to_.law; }
  // Returns the predicted displacement of the moving surface at `then`, as known at `now` [m].
  [[nodiscard]] Eigen::Vector3d ShiftAt(double now, double then) const noexcept;
  // Returns the result of the last ForceAt for the first tool: depth, and whether it is on the
  // patch.
  [[nodiscard]] double depth() const noexcept { return depth_; }  // [m]; negative outside
  [[nodiscard]] const Eigen::Vector3d& normal() const noexcept { return touches_[0].place.normal; }
  [[nodiscard]] bool serves() const noexcept { return serves_; }
  // Returns whether the depth exceeds the valid depth of the model.
  [[nodiscard]] bool is_beyond() const noexcept { return depth_ > patch_.valid_depth; }
  // Returns whether the last ForceAt limited the stiffness.
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
    Eigen::Vector3d d{0, 0, 0};       // displacement of the surface [m]
    Eigen::Vector3d linear{0, 0, 0};  // linear force [N]
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
  double since_ = 0;  // arrival of the newer curve [s]
  double stiffest_ = std::numeric_limits<double>::infinity();
  double steepest_ratio_ = 1;
  std::array<Touch, kPatchTools> touches_;
  double depth_ = 0;
  bool serves_ = false, capped_ = false;
};

// Keeps the newest patch and, for 30 ms, the previous one. The force changes gradually between
// them, and the contact keeps its anchors. Each patch alone is passive, and the passivity control
// removes energy of the change. Real-time safe. Not thread-safe.
class PatchRender {
 public:
  static constexpr double kBlendTime = PatchContact::kBlendTime;  // [s]

  // These functions forward to PatchContact.
  void Take(const SurfacePatch& patch, const PatchLaw& law, double at, double now) noexcept;
  void EndContact() noexcept;
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
