#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "shared/telemetry/latency_histogram.h"
#include "slave/pipeline/awaited_sense.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/camera/camera_sense.h"
#include "slave/pipeline/fingertips/fingertip_sense.h"
#include "slave/pipeline/points/points_sense.h"
#include "slave/site/environment/simulated_environment.h"

namespace palpate {
namespace {

constexpr int kFewestElements = 3;

[[noreturn]] void Refuse(const std::string& what, const std::string& accepted) {
  throw std::invalid_argument(what + ": accepted is " + accepted);
}

void SetKind(const std::string& kind, const Changeable& accepted, ModelOptions* model) {
  if (!IsKindFor(*accepted.object, kind)) Refuse("kind = " + kind, KindsFor(*accepted.object));
  model->kind = kind;
}

void SetElements(int elements, const Changeable& accepted, ModelOptions* model) {
  const std::string what = fmt::format("elements = {}", elements);
  if (accepted.most_elements == 0) Refuse(what, "none here, because the mesh comes from the scene");
  if (elements < kFewestElements || elements > accepted.most_elements) {
    Refuse(what, fmt::format("{} to {}", kFewestElements, accepted.most_elements));
  }
  model->elements = elements;
}

void SetPlane(const std::string& plane, const Changeable& accepted, ModelOptions* model) {
  if (!accepted.plane) Refuse("plane = " + plane, "none here");
  if (plane != "stress" && plane != "strain") Refuse("plane = " + plane, "stress, strain");
  model->plane = plane == "stress" ? Plane::kStress : Plane::kStrain;
}

void SetContact(const std::string& contact, const Changeable& accepted, ModelOptions* model) {
  if (!accepted.contact) Refuse("contact = " + contact, "none here");
  if (contact != "bonded" && contact != "frictionless") {
    Refuse("contact = " + contact, "bonded, frictionless");
  }
  model->contact = contact == "bonded" ? ContactLaw::kBonded : ContactLaw::kFrictionless;
}

// What is known of a sense before its first picture.
SenseInfo Awaited(const Scene& scene) {
  SenseInfo info;
  info.source = "images from a driver (FeedPictures)";
  info.samples = "images";
  info.is_awaited = true;
  info.tells_force = !HasStereoOrDepth(scene.sense) || EstimatesForce(scene);
  info.model.kind = "none";
  info.reason = "no image received yet";
  return info;
}

// One line for each way of feeling.
struct SenseMaker {
  template <typename Made>
  [[nodiscard]] std::unique_ptr<SensingPipeline> Make() const {
    const bool is_played = pace.player != nullptr;
    if (is_played || !TakesPictures(scene.sense))
      return std::make_unique<Made>(scene, pace, environment);
    if (!pace.is_live) {
      throw std::invalid_argument(
          "sense.camera.source = stream: accepted here are recorded or simulated images");
    }
    const auto make = [scene = scene,
                       tap = pace.tap](Pace streamed) -> std::unique_ptr<SensingPipeline> {
      streamed.tap = tap;
      return std::make_unique<Made>(scene, streamed, nullptr);
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
  const Pace& pace;
  SimulatedEnvironment* environment;
};

}  // namespace

ModelOptions Changed(ModelOptions model, const ModelChange& change, const Changeable& accepted) {
  if (!accepted.object) Refuse("kind = " + change.kind, "none, because no force is estimated here");
  model.decision = {};  // whoever changes it decides
  if (!change.kind.empty()) SetKind(change.kind, accepted, &model);
  if (change.elements != 0) SetElements(change.elements, accepted, &model);
  if (!change.plane.empty()) SetPlane(change.plane, accepted, &model);
  if (!change.contact.empty()) SetContact(change.contact, accepted, &model);
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

void Append(std::vector<float>* out, const Eigen::Vector3d& v) {
  for (const double x : v) out->push_back(static_cast<float>(x));
}

std::unique_ptr<SensingPipeline> MakeSensingPipeline(const Scene& scene, const Pace& pace,
                                                     SimulatedEnvironment* environment) {
  if (scene.sense.all().empty()) throw std::runtime_error(scene.name + ": the scene has no sense");
  return std::visit(SenseMaker{scene, pace, environment}, scene.sense.all().front());
}

}  // namespace palpate
