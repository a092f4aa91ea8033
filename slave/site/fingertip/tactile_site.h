// The simulated site of a scene with fingertips: a soft body under a large-strain law on a mesh of
// its own, pressed by simulated fingertips. It shows itself through tactile samples only; its truth
// is for reports.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/mesh/solid_mesh.h"
#include "shared/scene/scene.h"
#include "slave/capture/tactile_frame.h"

namespace palpate {

// What really happens at one fingertip. Frame S.
struct FingerTruth {
  Eigen::Isometry3d X_SF = Eigen::Isometry3d::Identity();
  bool in_contact = false;
  Eigen::Vector3d p_S_contact{0, 0, 0};  // on the deformed object [m]
  Eigen::Vector3d force{0, 0, 0};        // of the object on the fingertip [N]
  double depth = 0;                      // how far it presses in [m]
};

class TactileSite {
 public:
  // Throws std::invalid_argument naming the key where the scene cannot be simulated.
  explicit TactileSite(const Scene& scene);
  ~TactileSite();

  // The manipulator carries the hand here: the tip, which is the apex of the first finger's pad,
  // frame S [m]. Thread-safe, short.
  void MoveTool(const Eigen::Vector3d& p_S_tip);
  // Thread-safe, short.
  [[nodiscard]] std::array<FingerTruth, kMaxFingers> truth() const;
  // One sample of every finger; the world moves on by one sample period (1 / rate). One thread; the
  // same calls in the same order give the same samples.
  TactileFrame TakeSample(Time now);
  // Surface of the true body at rest and as it is deformed now, frame S [m]; same triangles. For
  // reports and for the pictures of a virtual depth camera.
  [[nodiscard]] SurfaceMesh rest_surface() const;
  [[nodiscard]] std::vector<Eigen::Vector3d> DeformedSurface() const;

 private:
  struct World;
  std::unique_ptr<World> world_;
};

}  // namespace palpate
