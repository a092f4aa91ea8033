// Images of one camera without an estimate, while its scene is being set up.
#pragma once

#include <memory>
#include <utility>

#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/offline/offline_report.h"

namespace palpate {

class PreviewSense final : public SensingPipeline {
 public:
  explicit PreviewSense(std::unique_ptr<FrameSource> source) : source_(std::move(source)) {}

  bool Acquire(const std::stop_token& stop) override {
    auto frame = source_->Next(stop);
    if (frame) next_ = *std::move(frame);
    return frame.has_value();
  }
  void Process() noexcept override {}
  const ContactEstimate& Estimate(const TipReading& /*encoders*/) noexcept override {
    shown_ = next_;
    estimate_.sample = shown_.sequence;
    estimate_.sensed_at = shown_.sensed_at;
    estimate_.processed_at = Clock::now();
    return estimate_;
  }
  [[nodiscard]] std::string_view flag_reason() const override { return {}; }
  LocalModel LocalModelAt(const Eigen::Vector3d& /*p_S_tip*/) noexcept override { return {}; }
  bool MakePatch(const Eigen::Vector3d& /*p_S_tip*/, SurfacePatch* /*patch*/) noexcept override {
    return false;
  }
  [[nodiscard]] bool HasOutgrownPatch() const noexcept override { return false; }
  void LearnLaw(PatchLaw* /*law*/) noexcept override {}
  [[nodiscard]] SurfaceMotion motion() const noexcept override { return {}; }
  BoundaryShape Shape(const ShapeParts& /*parts*/) override { return ShapeAsOf(estimate_, 2); }
  [[nodiscard]] std::optional<OverlaidImage> Image(double /*full_scale*/) const override {
    if (shown_.image.empty()) return std::nullopt;
    return OverlaidImage{shown_.sensed_at, shown_.image, [image = shown_.image] { return image; }};
  }
  [[nodiscard]] std::unique_ptr<PreparedModel> Prepare(const Scene& /*changed*/,
                                                       Progress* /*progress*/) const override {
    return nullptr;
  }
  void Adopt(std::unique_ptr<PreparedModel> /*prepared*/, const Scene& /*changed*/) override {}
  void Reset(const std::function<bool()>& /*is_disengaged*/) override {}
  [[nodiscard]] SenseInfo info() const override {
    SenseInfo info;
    info.source = source_->description();
    info.samples = "images";
    info.has_force_estimate = false;
    info.model.kind = "none";
    info.reason = "there is no scene yet";
    return info;
  }
  [[nodiscard]] std::vector<StageTimes> Stages() const override { return {}; }
  std::unique_ptr<OfflineReport> OpenOfflineReport(const GroundTruth* /*truth*/) override {
    return nullptr;
  }
  [[nodiscard]] TactileInbox* inbox() override { return nullptr; }
  [[nodiscard]] ImageInbox* image_inbox() override { return nullptr; }
  [[nodiscard]] Time sensed_at() const override { return next_.sensed_at; }
  [[nodiscard]] std::optional<CameraHealth> health() const override { return source_->health(); }

 private:
  const std::unique_ptr<FrameSource> source_;
  Frame next_, shown_;  // acquired; of the last estimate
  ContactEstimate estimate_;
};

}  // namespace palpate
