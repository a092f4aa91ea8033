// Feeling with tactile fingertips (paper B).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "slave/capture/tactile_frame.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/fingertips/tactile_estimator.h"

namespace palpate {

class FingertipSense final : public SensingPipeline {
 public:
  // Loads the network, precomputes the object's model, opens the source; the first samples are the
  // baseline; until they have arrived the force is unknown. Throws the exceptions of
  // MakeSensingPipeline.
  FingertipSense(const Scene& scene, const SenseInputs& inputs);
  // Creates it with another source and other senses than the scene's.
  FingertipSense(const Scene& scene, std::unique_ptr<TactileSource> source, TactileSenses senses);

  bool Acquire(const std::stop_token& stop) override;
  void Process() noexcept override {}
  const ContactEstimate& Estimate(const TipReading& encoders) noexcept override;
  [[nodiscard]] std::string_view flag_reason() const override {
    return estimator_.object().flag_reason();
  }
  LocalModel LocalModelAt(const Eigen::Vector3d& p_S_tip) noexcept override {
    return estimator_.LocalAt(p_S_tip);
  }
  bool MakePatch(const Eigen::Vector3d& p_S_tip, SurfacePatch* patch) noexcept override {
    return estimator_.MakePatch(p_S_tip, patch);
  }
  [[nodiscard]] bool HasOutgrownPatch() const noexcept override {
    return estimator_.HasOutgrownPatch();
  }
  void LearnLaw(PatchLaw* law) noexcept override { estimator_.LearnLaw(law); }
  [[nodiscard]] SurfaceMotion motion() const noexcept override { return {}; }
  [[nodiscard]] std::optional<OverlaidImage> Image(double /*full_scale*/) const override {
    return std::nullopt;
  }
  BoundaryShape Shape(const ShapeParts& parts) override { return estimator_.Shape(parts); }
  [[nodiscard]] std::unique_ptr<PreparedModel> Prepare(const Scene& changed,
                                                       Progress* progress) const override {
    return TactileEstimator::Prepare(changed, progress);
  }
  void Adopt(std::unique_ptr<PreparedModel> prepared, const Scene& changed) override;
  void Reset(const std::function<bool()>& /*is_disengaged*/) override { estimator_.Reset(); }
  [[nodiscard]] SenseInfo info() const override;
  [[nodiscard]] std::vector<StageTimes> Stages() const override;
  std::unique_ptr<OfflineReport> OpenOfflineReport(const GroundTruth* truth) override;
  [[nodiscard]] TactileInbox* inbox() override;
  [[nodiscard]] ImageInbox* image_inbox() override { return nullptr; }
  [[nodiscard]] Time sensed_at() const override { return next_.sensed_at; }
  [[nodiscard]] std::optional<CameraHealth> health() const override { return std::nullopt; }

  [[nodiscard]] const TactileEstimator& estimator() const { return estimator_; }
  [[nodiscard]] const Scene& scene() const { return scene_; }

 private:
  Scene scene_;
  std::unique_ptr<TactileSource> source_;
  TactileEstimator estimator_;
  std::optional<std::uint32_t> encoder_frame_;  // of the last reading
  TactileFrame next_;                           // acquired
};

}  // namespace palpate
