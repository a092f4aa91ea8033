// The slave that feels with a camera: ties source, estimator and operated tool together.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "slave/pipeline/camera/estimator.h"
#include "slave/pipeline/camera/tip_registration.h"
#include "slave/pipeline/teleop/operated_slave.h"
#include "slave/site/camera/simulated_site.h"

namespace palpate {

// The camera's thread owns the estimator under touch_mutex(). What it shares with callers besides
// is the newest picture.
class VisionSlave final : public OperatedSlave {
 public:
  // Opens the source, looks at the first picture, precomputes the model, starts. Throws
  // std::runtime_error or std::invalid_argument: what cannot be opened, found or modelled.
  explicit VisionSlave(const Scene& scene);
  ~VisionSlave() override;

  [[nodiscard]] BoundaryShape Shape(bool nodal_forces) override;
  [[nodiscard]] std::optional<JpegPicture> Picture(bool overlays, int quality) override;

  // How the rest surface was found.
  [[nodiscard]] const Registration& registration() const { return registration_; }

 private:
  [[nodiscard]] bool is_simulated() const override { return site_ != nullptr; }
  [[nodiscard]] std::string SourceDescription() const override { return source_->description(); }
  [[nodiscard]] std::optional<Eigen::Vector3d> TrueForce() const override;
  [[nodiscard]] std::vector<StageTimes> Stages() const override;
  void ResetSenses() override { estimator_->Reset(); }
  void Apply(const ModelChange& change, ModelOptions* model) const override;
  ModelInfo Replace(const Scene& changed, const std::function<void()>& may_adopt) override;
  void Publish(const Frame& frame, const ContactEstimate& felt,
               const Eigen::Vector3d& p_S_encoders);

  std::shared_ptr<SimulatedSite> site_;  // null where the site is real; the tool moves in it too
  std::unique_ptr<FrameSource> source_;
  Registration registration_;
  std::unique_ptr<Estimator> estimator_;
  TipRegistration tip_registration_;

  mutable std::mutex picture_mutex_;  // guards what follows
  Frame newest_frame_;
  Observation newest_observation_;
  std::vector<Eigen::Vector2d> newest_contour_I_;
  cv::Rect newest_window_;
};

}  // namespace palpate
