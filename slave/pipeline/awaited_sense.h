// A sensing whose images a driver sends: it is created from the first usable images, and until then
// reports what it waits for.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>

#include "slave/capture/picture_inbox.h"
#include "slave/pipeline/base/sensing_pipeline.h"

namespace palpate {

class AwaitedSense final : public SensingPipeline {
 public:
  // `make` creates the sensing from `pace.pictures`; it throws if the images cannot be used, and is
  // called again with the next ones. `awaited`: description until then.
  using Make = std::function<std::unique_ptr<SensingPipeline>(const Pace& pace)>;
  AwaitedSense(const Scene& scene, Make make, SenseInfo awaited);

  bool Acquire(const std::stop_token& stop) override;
  void Process() noexcept override { Made()->Process(); }
  const ContactEstimate& Estimate(const Eigen::Vector3d& p_S_tip) noexcept override {
    return Made()->Estimate(p_S_tip);
  }
  [[nodiscard]] std::string_view doubt() const override { return Made()->doubt(); }
  LocalModel LocalModelAt(const Eigen::Vector3d& p_S_tip) noexcept override {
    return Made() ? Made()->LocalModelAt(p_S_tip) : LocalModel{};
  }
  BoundaryShape Shape(bool nodal_forces) override {
    return Made() ? Made()->Shape(nodal_forces) : BoundaryShape{};
  }
  [[nodiscard]] std::optional<SeenPicture> Picture(double full_scale) const override {
    return Made() ? Made()->Picture(full_scale) : std::nullopt;
  }
  // Throws std::logic_error before the first sample.
  [[nodiscard]] std::unique_ptr<PreparedModel> Prepare(const Scene& changed,
                                                       Progress* progress) const override;
  void Adopt(std::unique_ptr<PreparedModel> prepared, const Scene& changed) override {
    Made()->Adopt(std::move(prepared), changed);
  }
  void Reset() override { Made()->Reset(); }
  [[nodiscard]] SenseInfo info() const override { return Made() ? Made()->info() : awaited_; }
  [[nodiscard]] std::vector<StageTimes> Stages() const override;
  std::unique_ptr<OfflineReport> OpenOfflineReport(
      const SimulatedEnvironment* environment) override;
  [[nodiscard]] PictureInbox* pictures() override { return &inbox_; }
  [[nodiscard]] Time sensed_at() const override { return inbox_.taken_at(); }
  [[nodiscard]] std::optional<CameraHealth> health() const override;

 private:
  [[nodiscard]] SensingPipeline* Made() const noexcept { return made_; }
  // False: these images cannot be used; the reason is reported.
  bool TryToMake(const std::stop_token& stop);
  void ReportTrouble(const std::string& trouble);

  PictureInbox inbox_;
  const Make make_;
  const SenseInfo awaited_;
  std::unique_ptr<SensingPipeline> sense_;
  std::atomic<SensingPipeline*> made_ = nullptr;  // `sense_`, once it has its first sample
  mutable std::mutex mutex_;                      // guards the next one
  std::string trouble_;
};

}  // namespace palpate
