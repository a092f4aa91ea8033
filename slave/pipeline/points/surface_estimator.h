// Computes one contact estimate from one observation of the surface: position of the load, load and
// deformed shape by least squares over all visible points with the object's model (paper C, 4).
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/mesh/solid_mesh.h"
#include "shared/state/slave_state.h"
#include "shared/state/surface_patch.h"
#include "shared/telemetry/latency_histogram.h"
#include "slave/checks/load/load_checks.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/pipeline/base/estimate_builder.h"
#include "slave/pipeline/load/load_identifier.h"
#include "slave/pipeline/local_model/stiffness_scale.h"
#include "slave/scene/scene.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// Used by one thread at a time.
class SurfaceEstimator {
 public:
  explicit SurfaceEstimator(const Scene& scene);

  // `p_S_tip`: tip position from the encoders. A load that pulls outward by more than its sigma is
  // not a contact: kExtrapolated. Never throws; allocation-free after the first observations.
  // `arm_lag`: largest time between encoder reading and images [image periods]; nullopt: the images
  // do not show the manipulator's tool, so its depth is not checked.
  const ContactEstimate& Estimate(const SurfaceObservation& seen, const Eigen::Vector3d& p_S_tip,
                                  std::optional<double> arm_lag = {}) noexcept;
  // The plane that the master renders for a tip at p_S_tip now, also between images: at the
  // membrane's point below it, tangent at its depth to the curve of the model's force times the
  // ratio of estimated to modelled force (StiffnessScale). The ratio is learnt from valid loads
  // under the tip over tenths of a second, slower with a larger error of the force and a faster
  // tip, and kept for the next contact.
  [[nodiscard]] LocalModel LocalAt(const Eigen::Vector3d& p_S_tip) noexcept;
  // The surface around the tip, with its initial stiffness along the normals, and the force-depth
  // curve of model and estimates at the tip's last position. See SensingPipeline.
  bool MakePatch(const Eigen::Vector3d& p_S_tip, SurfacePatch* patch) noexcept;
  void LearnLaw(PatchLaw* law) noexcept;
  // Activates a replacement that MakeLoadIdentifier made, if necessary in another thread.
  void Adopt(std::unique_ptr<LoadIdentifier> body, const Scene& scene);
  void Reset() noexcept;

  [[nodiscard]] const ContactEstimate& estimate() const { return estimate_; }
  [[nodiscard]] const SurfaceLoad& load() const { return load_; }
  [[nodiscard]] LoadIdentifier& body() { return *body_; }
  [[nodiscard]] const Eigen::Isometry3d& X_SO() const { return X_SO_; }
  // Results of the fits.
  [[nodiscard]] const LatencyHistogram& times() const { return times_; }
  // Nodes of body().surface() as they are deformed now, and the forces of the tool on them; frame
  // S.
  void DeformedNodes(std::vector<Eigen::Vector3d>* p_S);
  void NodalForces(std::vector<Eigen::Vector3d>* f_S);

 private:
  void ToObject(const std::vector<SurfacePoint>& points_S);
  [[nodiscard]] ToolReading ToolAt(const Eigen::Vector3d& p_S_tip, double lag) noexcept;
  void Learn() noexcept;
  // `shows_tool`: the encoders report the tip of the tool that presses the points.
  void SetEstimate(bool shows_tool) noexcept;
  void SetMoment(bool shows_tool) noexcept;
  void Lose(const Verdict& verdict) noexcept;

  std::unique_ptr<LoadIdentifier> body_;
  Eigen::Isometry3d X_SO_, X_OS_;
  double larger_side_ = 0;            // [m]
  double valid_radius_ = 0;           // of local models [m]
  double tool_width_ = 0;             // [m]; 0: a point
  double full_depth_ = 0;             // indentation of a contact, from the scene [m]
  double min_informative_depth_ = 0;  // [m]

  std::vector<SurfacePoint> points_O_;
  SurfaceLoad load_;
  ContactEstimate estimate_;
  StiffnessScale stiffness_scale_;
  double last_depth_ = std::numeric_limits<double>::quiet_NaN();  // of the tip, last image [m]
  LocalModel local_;                                              // the last estimate
  Checks<LoadSample> checks_ = MakeLoadChecks();
  LatencyHistogram times_;
  EstimateBuilder builder_;
};

// Position of a moving object whose force is unknown, because the scene has no model of its
// contact: paper C's second experiment (5.2). The points of the first observation represent the
// object. Its position is their mean at rest plus the mean displacement of the visible ones: exact
// for a body that does not rotate, whichever points are hidden.
class RigidTranslation {
 public:
  // The position is reported as tip and as contact. The force is unknown: kFailed while the object
  // is tracked, kTrackingLost while it is not. Never throws; allocates in the first observation
  // only.
  const ContactEstimate& Estimate(const SurfaceObservation& seen) noexcept;
  void Reset() noexcept { first_.clear(); }
  [[nodiscard]] const ContactEstimate& estimate() const { return estimate_; }
  // Displacement from the position at rest [m]; the last one while the object is lost.
  [[nodiscard]] const Eigen::Vector3d& moved() const { return moved_; }

 private:
  void Start(const SurfaceObservation& seen) noexcept;

  std::vector<char> first_;  // per point: in the first observation; empty: none yet
  Eigen::Vector3d p_S_rest_{0, 0, 0}, moved_{0, 0, 0};
  ContactEstimate estimate_;
};

}  // namespace palpate
