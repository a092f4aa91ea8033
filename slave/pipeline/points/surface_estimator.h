// One observation of the surface in, one felt state out: from all visible points the place of the
// load, the load and the deformed shape, by least squares through the object's model (paper C, 4).
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
#include "slave/mechanics/deformation_model.h"
#include "slave/pipeline/estimate_builder.h"
#include "slave/pipeline/load/load_identifier.h"
#include "slave/pipeline/local_model/stiffness_scale.h"
#include "slave/scene/scene.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// One thread at a time.
class SurfaceEstimator {
 public:
  explicit SurfaceEstimator(const Scene& scene);

  // `p_S_tip`: where the manipulator says that the hand has its tip. A load that pulls outward by
  // more than its sigma is no press: kExtrapolated. Never throws; allocation-free after the first
  // observations.
  // `arm_lag`: how far the manipulator's instant may be from the pictures' [their periods];
  // nullopt: they do not show the manipulator's tool, so that it is no witness of the depth.
  const ContactEstimate& Estimate(const SurfaceObservation& seen, const Eigen::Vector3d& p_S_tip,
                                  std::optional<double> arm_lag = {}) noexcept;
  // The contact that the master renders for a tip at p_S_tip now, between pictures too: the plane
  // at the membrane's own place under it, tangent at its depth to the model's force times what was
  // felt by what the model has at that depth (StiffnessScale): learnt from valid loads under the
  // tip over tenths of a second, the slower the less the force stands out of its error and the
  // faster the tip moves, and kept for the next contact.
  [[nodiscard]] LocalModel LocalAt(const Eigen::Vector3d& p_S_tip) noexcept;
  // The surface around the tip, as stiff along its normals as it begins; and the law over depth as
  // the model and what was felt have it at the tip's last place. See SensingPipeline.
  bool MakePatch(const Eigen::Vector3d& p_S_tip, SurfacePatch* patch) noexcept;
  void LearnLaw(PatchLaw* law) noexcept;
  // Puts a replacement to work; made by MakeLoadIdentifier, in another thread if need be.
  void Adopt(std::unique_ptr<LoadIdentifier> body, const Scene& scene);
  void Reset() noexcept;

  [[nodiscard]] const ContactEstimate& felt() const { return felt_; }
  [[nodiscard]] const SurfaceLoad& load() const { return load_; }
  [[nodiscard]] LoadIdentifier& body() { return *body_; }
  [[nodiscard]] const Eigen::Isometry3d& X_SO() const { return X_SO_; }
  // Of the fits.
  [[nodiscard]] const LatencyHistogram& times() const { return times_; }
  // Nodes of body().surface() as they are deformed now, and the forces of the tool on them; frame
  // S.
  void DeformedNodes(std::vector<Eigen::Vector3d>* p_S);
  void NodalForces(std::vector<Eigen::Vector3d>* f_S);

 private:
  void ToObject(const std::vector<SurfacePoint>& points_S);
  void CompareWithEncoders(double lag) noexcept;
  void WidenForTiming(double sigma) noexcept;
  void Learn() noexcept;
  void SetEstimate() noexcept;
  void Lose(Validity validity, FailedCheck check) noexcept;

  std::unique_ptr<LoadIdentifier> body_;
  Eigen::Isometry3d X_SO_, X_OS_;
  double larger_side_ = 0;    // [m]
  double valid_radius_ = 0;   // of local models [m]
  double full_depth_ = 0;     // of a press, by the scene [m]
  double telling_depth_ = 0;  // [m]

  std::vector<SurfacePoint> points_O_;
  SurfaceLoad load_;
  ContactEstimate felt_;
  StiffnessScale felt_ratio_;
  double last_depth_ = std::numeric_limits<double>::quiet_NaN();  // of the tip, last picture [m]
  double arm_depth_ = 0;                                          // likewise, as the arm says [m]
  int distrust_ = 0;                  // pictures until eyes and arm are believed again
  LocalModel local_;                  // the last one told
  std::optional<double> last_force_;  // that was known, outward [N]
  double last_change_ = 0;            // from the one before it [N]
  LatencyHistogram times_;
  EstimateBuilder rules_;
};

// The place of a moving object whose force nobody can tell, because the scene has no model of how
// it is touched: paper C's second experiment (5.2).
// The points that the first observation shows stand for the object. Its place is their mean at
// rest, carried by the mean displacement of those that are seen: exact for a body that does not
// turn, whichever of them are hidden.
class RigidTranslation {
 public:
  // The place is told as tip and as contact. The force is unknown: kFailed while the object is
  // followed, kTrackingLost while it is not. Never throws; allocates in the first observation only.
  const ContactEstimate& Estimate(const SurfaceObservation& seen) noexcept;
  void Reset() noexcept { first_.clear(); }
  [[nodiscard]] const ContactEstimate& felt() const { return felt_; }
  // From the place at rest [m]; while it is lost that of before.
  [[nodiscard]] const Eigen::Vector3d& moved() const { return moved_; }

 private:
  void Start(const SurfaceObservation& seen) noexcept;

  std::vector<char> first_;  // per point: in the first observation; empty: nothing was seen yet
  Eigen::Vector3d p_S_rest_{0, 0, 0}, moved_{0, 0, 0};
  ContactEstimate felt_;
};

}  // namespace palpate
