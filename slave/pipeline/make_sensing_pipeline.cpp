#include <atomic>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "shared/link/priority_inheritance_mutex.h"
#include "shared/telemetry/latency_histogram.h"
#include "slave/capture/image_inbox.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/camera/camera_sense.h"
#include "slave/pipeline/fingertips/fingertip_sense.h"
#include "slave/pipeline/offline/offline_report.h"
#include "slave/pipeline/points/points_sense.h"

namespace palpate {
namespace {

constexpr const char* kNothingYet = "no image received yet (FeedImages)";

// A sensing pipeline for images from a driver. It is created from the first usable images; until
// then it reports what it waits for.
class AwaitedSense final : public SensingPipeline {
 public:
  // `make` creates the sensing from `inputs.images`; it throws if the images cannot be used, and
  // is called again with the next ones. `awaited`: description until then.
  using Make = std::function<std::unique_ptr<SensingPipeline>(const SenseInputs& inputs)>;
  AwaitedSense(const Scene& scene, Make make, SenseInfo awaited)
      : inbox_(scene),
        make_(std::move(make)),
        awaited_(std::move(awaited)),
        trouble_(kNothingYet) {}

  bool Acquire(const std::stop_token& stop) override {
    if (Made()) return Made()->Acquire(stop);
    while (inbox_.Wait(stop) && !stop.stop_requested()) {
      if (TryToMake(stop)) return true;
    }
    return false;
  }
  void Process() noexcept override { Made()->Process(); }
  const ContactEstimate& Estimate(const TipReading& encoders) noexcept override {
    return Made()->Estimate(encoders);
  }
  [[nodiscard]] std::string_view flag_reason() const override { return Made()->flag_reason(); }
  LocalModel LocalModelAt(const Eigen::Vector3d& p_S_tip) noexcept override {
    return Made() ? Made()->LocalModelAt(p_S_tip) : LocalModel{};
  }
  bool MakePatch(const Eigen::Vector3d& p_S_tip, SurfacePatch* patch) noexcept override {
    return Made() && Made()->MakePatch(p_S_tip, patch);
  }
  [[nodiscard]] bool HasOutgrownPatch() const noexcept override {
    return Made() && Made()->HasOutgrownPatch();
  }
  void LearnLaw(PatchLaw* law) noexcept override {
    if (Made()) Made()->LearnLaw(law);
  }
  [[nodiscard]] SurfaceMotion motion() const noexcept override {
    return Made() ? Made()->motion() : SurfaceMotion{};
  }
  BoundaryShape Shape(const ShapeParts& parts) override {
    return Made() ? Made()->Shape(parts) : BoundaryShape{};
  }
  [[nodiscard]] std::optional<OverlaidImage> Image(double full_scale) const override {
    return Made() ? Made()->Image(full_scale) : std::nullopt;
  }
  // Throws std::logic_error before the first sample.
  [[nodiscard]] std::unique_ptr<PreparedModel> Prepare(const Scene& changed,
                                                       Progress* progress) const override {
    if (!Made())
      throw std::logic_error(std::string(kNothingYet) +
                             ": expected a change after the first image");
    return Made()->Prepare(changed, progress);
  }
  void Adopt(std::unique_ptr<PreparedModel> prepared, const Scene& changed) override {
    Made()->Adopt(std::move(prepared), changed);
  }
  void Reset(const std::function<bool()>& is_disengaged) override { Made()->Reset(is_disengaged); }
  [[nodiscard]] SenseInfo info() const override { return Made() ? Made()->info() : awaited_; }
  [[nodiscard]] std::vector<StageTimes> Stages() const override {
    return Made() ? Made()->Stages() : std::vector<StageTimes>();
  }
  std::unique_ptr<OfflineReport> OpenOfflineReport(const GroundTruth* truth) override {
    return Made() ? Made()->OpenOfflineReport(truth) : nullptr;
  }
  [[nodiscard]] TactileInbox* inbox() override { return nullptr; }
  [[nodiscard]] ImageInbox* image_inbox() override { return &inbox_; }
  [[nodiscard]] Time sensed_at() const override { return inbox_.taken_at(); }
  [[nodiscard]] std::optional<CameraHealth> health() const override {
    CameraHealth health = inbox_.health();
    if (const auto made = Made() ? Made()->health() : std::nullopt; made && health.trouble.empty())
      health.trouble = made->trouble;
    const std::lock_guard lock(mutex_);
    if (health.trouble.empty()) health.trouble = trouble_;
    return health;
  }

 private:
  [[nodiscard]] SensingPipeline* Made() const noexcept { return made_; }
  // Returns false if these images cannot be used; the reason is reported.
  bool TryToMake(const std::stop_token& stop) {
    try {
      auto sense = make_({.images = &inbox_});
      if (!sense->Acquire(stop)) return false;
      sense_ = std::move(sense);
      made_ = sense_.get();
      ReportTrouble({});
      return true;
    } catch (const std::exception& error) {
      ReportTrouble(std::string("the received images cannot be used: ") + error.what());
      inbox_.Drop();
      return false;
    }
  }
  void ReportTrouble(const std::string& trouble) {
    const std::lock_guard lock(mutex_);
    if (!trouble.empty() && trouble != trouble_) spdlog::warn("{}", trouble);
    trouble_ = trouble;
  }

  ImageInbox inbox_;
  const Make make_;
  const SenseInfo awaited_;
  std::unique_ptr<SensingPipeline> sense_;
  std::atomic<SensingPipeline*> made_ = nullptr;  // equal to `sense_` after its first sample
  mutable PriorityInheritanceMutex mutex_;        // guards the next member
  std::string trouble_;
};

[[noreturn]] void Refuse(const std::string& what, const std::string& accepted) {
  throw std::invalid_argument(what + ": expected " + accepted);
}

void SetKind(const std::string& kind, ObjectClass object, ModelOptions* model) {
  if (!IsKindFor(object, kind)) Refuse("kind = " + kind, KindsFor(object));
  model->kind = kind;
}

// Only some models have friction.
void RequireFriction(const ModelOptions& model) {
  if (model.contact != ContactLaw::kFriction || FollowsTools(model)) return;
  Refuse("kind = " + model.kind, "fem while contact = friction");
}

// Description of a sense before its first image.
SenseInfo Awaited(const Scene& scene) {
  SenseInfo info;
  info.source = "images from a driver (FeedImages)";
  info.samples = "images";
  info.is_awaited = true;
  info.has_force_estimate = !HasStereoOrDepth(scene.sense) || EstimatesForce(scene);
  info.model.kind = "none";
  info.reason = "no image received yet";
  return info;
}

// Table of the kinds of sensing.
struct SenseMaker {
  template <typename Made>
  [[nodiscard]] std::unique_ptr<SensingPipeline> Make() const {
    const bool is_played = inputs.player != nullptr;
    if (is_played || !TakesImages(scene.sense)) return std::make_unique<Made>(scene, inputs);
    const auto make = [scene = scene, tap = inputs.tap, solves_aside = inputs.solves_aside](
                          SenseInputs streamed) -> std::unique_ptr<SensingPipeline> {
      streamed.tap = tap;
      streamed.solves_aside = solves_aside;
      return std::make_unique<Made>(scene, streamed);
    };
    return std::make_unique<AwaitedSense>(scene, make, Awaited(scene));
  }

  std::unique_ptr<SensingPipeline> operator()(const CameraOptions&) const {
    return Make<CameraSense>();
  }
  std::unique_ptr<SensingPipeline> operator()(const PointsOptions&) const {
    return Make<PointsSense>();
  }
  std::unique_ptr<SensingPipeline> operator()(const Tactile&) const {
    return Make<FingertipSense>();
  }

  const Scene& scene;
  const SenseInputs& inputs;
};

}  // namespace

ModelOptions Changed(ModelOptions model, const ModelChange& change,
                     std::optional<ObjectClass> object) {
  if (!object) Refuse("kind = " + change.kind, "none, because no force is estimated here");
  model.reason.clear();
  if (!change.kind.empty()) SetKind(change.kind, *object, &model);
  RequireFriction(model);
  return model;
}

std::vector<std::string> Introduction(const SenseInfo& info) {
  if (info.is_awaited) return {"waiting for " + info.source};
  const ModelInfo& model = info.model;
  std::vector<std::string> lines{
      fmt::format("{} with {} elements, {} degrees of freedom, precomputed in {:.0f} ms; {}",
                  model.kind, model.elements, model.dof, 1e3 * model.precompute_s, info.source)};
  lines.insert(lines.end(), info.remarks.begin(), info.remarks.end());
  return lines;
}

StageTimes TimesOf(const std::string& name, const LatencyHistogram& times) {
  return {name, times.Quantile(0.5), times.Quantile(0.99), times.max()};
}

void Append(DisplacementField* field, const Eigen::Vector3d& p_O, const Eigen::Vector3d& u_O,
            const Eigen::Vector2d& p_I) {
  Append(&field->rest, p_O);
  Append(&field->displacement, u_O);
  for (const double pixels : {p_I.x(), p_I.y()}) field->image.push_back(static_cast<float>(pixels));
}

void Append(std::vector<float>* out, const Eigen::Vector3d& v) {
  for (const double x : v) out->push_back(static_cast<float>(x));
}

std::unique_ptr<SensingPipeline> MakeSensingPipeline(const Scene& scene,
                                                     const SenseInputs& inputs) {
  if (scene.sense.all().empty()) throw std::runtime_error(scene.name + ": the scene has no sense");
  return std::visit(SenseMaker{scene, inputs}, scene.sense.all().front());
}

}  // namespace palpate
