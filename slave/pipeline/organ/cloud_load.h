// The force on a held organ from a cloud of points on the part of its surface that is seen. Where
// the load acts and how widely is unknown.
//
// Posterior of force, place, width and stiffness, by Gauss and Newton. Prior: one patch
// (patch_greens.h) anywhere on the surface, flat in force and place, log-normal in width; Young's
// modulus differs from the scene's by `tolerance`, as a whole and in bumps. The likelihood is that
// of the points' heights over the deformed surface, their scatter taken from the cloud itself and
// its weight lowered by as much as neighbouring heights err alike (CloudSquares::effect). A patch
// that stays is known better by every cloud, but only as the mean of them: what a model does wrong
// it does wrong in all. Source: Gauss-Newton and Laplace's approximation; the weighted likelihood
// after Kish's design effect.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "shared/state/failed_check.h"
#include "shared/state/validity.h"
#include "slave/contact/surface_contact.h"
#include "slave/pipeline/organ/cloud_fit.h"
#include "slave/pipeline/organ/patch_greens.h"

namespace palpate {

// Frame O.
struct CloudForce {
  Eigen::Vector3d force_O{0, 0, 0};                        // of the tool on the organ [N]
  Eigen::Matrix3d covariance_O = Eigen::Matrix3d::Zero();  // [N^2]
  LoadPatch patch;
  double rms = 0;    // of the points' heights over the fitted surface [m]
  double moved = 0;  // rms displacement of the surface under the points [m]
  int used = 0;      // points
  Validity validity = Validity::kFailed;
  FailedCheck check = FailedCheck::kNone;
  std::string_view why;  // reason if it is not kValid, with static lifetime
};

// Measured (liver_registration, remeshed, patch not told, one scale from three frames): 5.8 % mean
// error over the linear sequences (1.8, 4.6, 11.1 %) where the published scheme, told the patch,
// has 6.6 %; 75 and 93 % within one and two sigma. What is left is how much stiffer the coarser
// mesh behind the clouds is than this one, otherwise for every direction.
//
// One thread at a time. Linear elasticity of four-node tetrahedra: see PatchGreens.
// kExtrapolated: more is left of the points than noise and 6 % of the displacement; the load lies
// out of sight; it moves its place beyond `range`; nu is at least 0.49, where elements lock.
class CloudLoad {
 public:
  struct Params {
    double young_modulus = 0;  // [Pa]
    double poisson_ratio = 0;  // < 0.5
    double sigma = 1e-4;       // of a point along the normal [m]
    double tolerance = 0.05;   // of the stiffness, a standard deviation [-]
    double range = 0.1;  // displacement under the load over the larger side, beyond: kExtrapolated
    std::vector<std::array<int, 3>> seen{};  // triangles of the surface in view; none: all of it
  };
  static constexpr int kFewestPoints = 20;

  // Throws std::invalid_argument naming the parameter; see PatchGreens. Some hundred sparse
  // solutions.
  CloudLoad(const SolidMesh& mesh, const HeldNodes& held, const Params& params);

  // Microseconds per point while the patch stays where it is; tenths of a second for the first
  // cloud and where the patch is lost. Never throws.
  CloudForce Fit(std::span<const Eigen::Vector3d> points_O) noexcept;
  void Reset() noexcept { known_ = false; }

 private:
  // Quantities that are constant from cloud to cloud, for the present patch: the mean of the
  // clouds' information and information vector.
  static constexpr int kStill = kLoadUnknowns - 3;
  using StillVector = Eigen::Matrix<double, kStill, 1>;
  using StillMatrix = Eigen::Matrix<double, kStill, kStill>;
  struct Memory {
    StillMatrix information = StillMatrix::Zero();
    StillVector vector = StillVector::Zero();
    int clouds = 0;
  };
  struct Attempt {
    LoadPatch patch;
    LoadVector u = LoadVector::Zero();
    double distance = 0;  // CloudSquares::distance [m]
  };

  CloudForce TryFit(std::span<const Eigen::Vector3d> points_O);
  bool IsAtRest(std::span<const Eigen::Vector3d> points_O);
  [[nodiscard]] CloudForce ResultAtRest() const;
  bool Follow(std::span<const Eigen::Vector3d> points_O);
  void Search(std::span<const Eigen::Vector3d> points_O);
  void Refine(std::span<const Eigen::Vector3d> points_O, Attempt* attempt);
  bool MovePatch(double least);
  Eigen::Vector3d Step(std::span<const Eigen::Vector3d> points_O);
  void AddPriors(LoadMatrix* H, LoadVector* g) const;
  void Remember();
  [[nodiscard]] CloudForce Result() const;

  Params params_;
  PatchGreens greens_;
  SurfaceContact skin_;
  std::vector<bool> in_view_;  // per node
  std::unique_ptr<CloudFit> fit_;
  double larger_side_ = 0, least_width_ = 0, most_width_ = 0;  // [m]
  std::vector<LoadPatch> candidates_;
  std::vector<Eigen::VectorXf> candidate_fields_;

  bool known_ = false;
  LoadPatch patch_, softened_;  // of the field: its first columns, its last
  PatchGreens::Field field_;
  LoadVector u_ = LoadVector::Zero();
  Memory memory_, latest_;
  // Of the last step.
  CloudSquares squares_;
  LoadMatrix posterior_ = LoadMatrix::Zero();  // information, times one over share_
  double share_ = 1;                           // weight of this cloud in these means
  Eigen::Matrix<double, 3, kStill> by_ = Eigen::Matrix<double, 3, kStill>::Zero();
  Eigen::Matrix3d force_information_ = Eigen::Matrix3d::Zero();
};

}  // namespace palpate
