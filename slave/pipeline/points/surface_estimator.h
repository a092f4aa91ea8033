// One observation of the surface in, one felt state out: from all visible points the place of the
// load, the load and the deformed shape, by least squares through the object's model (paper C, 4).
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/mesh/solid_mesh.h"
#include "shared/state/slave_state.h"
#include "shared/telemetry/latency_histogram.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/pipeline/load/load_identifier.h"
#include "slave/scene/scene.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

struct SurfaceTimes {
  LatencyHistogram mechanics;
};

// One thread at a time.
class SurfaceEstimator {
 public:
  explicit SurfaceEstimator(const Scene& scene);
  ~SurfaceEstimator();

  // `p_S_tip`: where the manipulator says that the hand has its tip. A load that pulls outward by
  // more than its sigma is no press: kExtrapolated. Never throws; allocation-free after the first
  // observations.
  const ContactEstimate& Feel(const SurfaceObservation& seen,
                              const Eigen::Vector3d& p_S_tip) noexcept;
  // The contact that the master renders for a tip at p_S_tip now, between pictures too: the plane
  // at the membrane's own place under it, tangent at its depth to the model's force times what was
  // felt by what the model has at that depth (StiffnessScale): learnt from valid loads under the
  // tip over tenths of a second, the slower the less the force stands out of its error and the
  // faster the tip moves, and kept for the next contact.
  [[nodiscard]] LocalModel LocalAt(const Eigen::Vector3d& p_S_tip) noexcept;
  // Puts a replacement to work; made by MakeLoadIdentifier, in another thread if need be.
  void Adopt(std::unique_ptr<LoadIdentifier> body, const Scene& scene);
  void Reset() noexcept;

  [[nodiscard]] const ContactEstimate& felt() const;
  [[nodiscard]] const SurfaceLoad& load() const;
  [[nodiscard]] LoadIdentifier& body();
  [[nodiscard]] const Eigen::Isometry3d& X_SO() const;
  [[nodiscard]] const SurfaceTimes& times() const;
  // Nodes of body().surface() as they are deformed now, and the forces of the tool on them; frame
  // S.
  void DeformedNodes(std::vector<Eigen::Vector3d>* p_S);
  void NodalForces(std::vector<Eigen::Vector3d>* f_S);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
