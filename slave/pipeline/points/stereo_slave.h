// The slave that feels with two eyes, or with a depth camera: ties source, eyes, estimator and
// operated tool together (paper C).
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "slave/capture/stereo_source.h"
#include "slave/pipeline/points/points_overlay.h"
#include "slave/pipeline/points/surface_point_tracker.h"
#include "slave/pipeline/points/surface_teller.h"
#include "slave/pipeline/teleop/operated_slave.h"
#include "slave/site/points/stereo_site.h"

namespace palpate {

// The pictures' thread owns the eyes, and the teller under touch_mutex(). What it shares with
// callers besides is the newest picture.
class StereoSlave final : public OperatedSlave {
 public:
  // Opens the source, precomputes the model, starts; the first pairs are the rest frame, so until
  // it is known the force is unknown. Throws std::runtime_error or std::invalid_argument: what
  // cannot be opened or modelled, pictures that are not the rig's.
  explicit StereoSlave(const Scene& scene);
  // The same with another source than the scene's; for tests.
  StereoSlave(const Scene& scene, std::unique_ptr<StereoSource> source);
  ~StereoSlave() override;

  // As every slave's; the local model follows the hand between pictures.
  [[nodiscard]] SlaveState Compose(Time now) override;
  // Where no force is told, the object as it is followed: moved as a whole.
  [[nodiscard]] BoundaryShape Shape(bool nodal_forces) override;
  // The left picture.
  [[nodiscard]] std::optional<JpegPicture> Picture(bool overlays, int quality) override;

  [[nodiscard]] const StereoRig& rig() const { return rig_; }
  // Pictures before the rest frame is known, at least.
  [[nodiscard]] int rest_pictures() const { return eyes_->rest_pictures(); }

 private:
  void OpenSource(const Scene& scene);
  void Start(const Scene& scene);
  void Look(const StereoPair& pair);
  [[nodiscard]] LocalModel LocalNow();

  [[nodiscard]] bool is_simulated() const override { return site_ != nullptr; }
  [[nodiscard]] std::string SourceDescription() const override { return source_->description(); }
  [[nodiscard]] std::optional<Eigen::Vector3d> TrueForce() const override;
  [[nodiscard]] std::vector<StageTimes> Stages() const override;
  // With the next pair: nothing must touch the object.
  void ResetSenses() override { reset_wanted_ = true; }
  // Kinds of the scene's object; `elements`, `plane` and `contact` are not theirs.
  void Apply(const ModelChange& change, ModelOptions* model) const override;
  ModelInfo Replace(const Scene& changed, const std::function<void()>& may_adopt) override;

  StereoRig rig_;
  std::unique_ptr<SurfacePointTracker> eyes_;
  SurfaceTeller teller_;
  Eigen::Isometry3d X_SO_ = Eigen::Isometry3d::Identity();
  SurfaceMesh followed_;                       // frame O; empty where a force is told
  LatencyHistogram look_times_, total_times_;  // under touch_mutex()
  std::shared_ptr<StereoSite> site_;  // null where the site is real; the tool moves in it too
  std::unique_ptr<StereoSource> source_;
  std::atomic<bool> reset_wanted_{false};

  std::mutex local_mutex_;  // guards the next one
  LocalModel newest_local_;

  std::mutex picture_mutex_;  // guards what follows
  StereoPair newest_pair_;
  PointsOverlay newest_overlay_;
};

}  // namespace palpate
