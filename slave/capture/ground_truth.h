// The true state of a simulated scene. Reports compare estimates with it; no estimator reads it.
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/mesh/solid_mesh.h"
#include "shared/state/slave_state.h"

namespace palpate {

// FingerTruth is the true contact of one fingertip. Frame S.
struct FingerTruth {
  Eigen::Isometry3d X_SF = Eigen::Isometry3d::Identity();
  bool in_contact = false;
  Eigen::Vector3d p_S_contact{0, 0, 0};  // on the deformed object [m]
  Eigen::Vector3d force{0, 0, 0};        // of the object on the fingertip [N]
  double depth = 0;                      // indentation [m]
};

// The true state of the simulation at this moment. Frame S.
struct Truth {
  Eigen::Vector3d p_S_tip{0, 0, 0};  // of the tool [m]
  bool in_contact = false;
  Eigen::Vector3d force{0, 0, 0};  // of the object on the tool [N]
  double depth = 0;                // of the surface under the tool, along its normal [m]
  // False: the force is an approximation, because the contact is not solved yet.
  bool solved = true;
  // The fingertips of scenes that have some; the first is the tool.
  std::array<FingerTruth, kMaxFingers> fingers{};
  bool punctured = false;  // the tool is through the membrane, whose force has ended
};

// A target that moves as a rigid body, whose frame is B.
struct TargetTruth {
  double seconds = 0;  // on its path, since the first images
  Eigen::Isometry3d X_SB_first = Eigen::Isometry3d::Identity();  // in the first images
  Eigen::Isometry3d X_SB = Eigen::Isometry3d::Identity();        // in the last ones
};

class GroundTruth {
 public:
  virtual ~GroundTruth() = default;
  GroundTruth() = default;
  GroundTruth(const GroundTruth&) = delete;
  GroundTruth& operator=(const GroundTruth&) = delete;

  // Returns the truth at the instant of the last sample, or of the simulation itself now.
  [[nodiscard]] virtual Truth truth() const = 0;
  // Returns the target that moves as a rigid body; nullopt: there is none.
  [[nodiscard]] virtual std::optional<TargetTruth> target() const { return std::nullopt; }
  // Returns the target of the tool in frame S [m]; nullopt if there is none. The target never
  // changes.
  [[nodiscard]] virtual std::optional<Eigen::Vector3d> goal() const { return std::nullopt; }
  // Returns the displacement of the point of the membrane that rests at p_O [m], frame O [m]; zero
  // for other objects.
  [[nodiscard]] virtual Eigen::Vector3d TrueDisplacement(const Eigen::Vector2d& /*p_O*/) const {
    return Eigen::Vector3d::Zero();
  }
  // Returns the nodes of the object that fingertips touch, frame S [m], with the same triangles at
  // every sample. Empty for other objects.
  [[nodiscard]] virtual SurfaceMesh TrueSurface() const { return {}; }
};

}  // namespace palpate
