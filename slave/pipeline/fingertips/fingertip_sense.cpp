#include "slave/pipeline/fingertips/fingertip_sense.h"

#include <stdexcept>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "shared/mesh/surface_patch.h"
#include "slave/capture/tactile_inbox.h"
#include "slave/capture/tactile_recording.h"
#include "slave/mechanics/make_model.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kPoseResolution = 10e-6;  // of what tells where a fingertip is [m]

std::unique_ptr<TactileSource> Open(const Scene& scene, const Pace& pace, World* world) {
  if (world != nullptr) return world->OpenFingertips(scene, pace);
  if (scene.sense.tactile->source == Tactile::Source::kRecording) {
    return OpenTactileRecording(scene, pace.is_live);
  }
  if (!pace.is_live) {
    throw std::invalid_argument(
        scene.file.string() +
        ": sense.tactile.source = stream: accepted here is a recording, or simulated");
  }
  return std::make_unique<TactileInbox>(*scene.sense.tactile);
}

// Shares of a contact's force among the nodes, as DeformationModel spreads a load (contracts,
// `solve`): over the triangles of a patch, a third of each one's share per node, or over the
// triangle of a point.
void Spread(const SurfaceMesh& surface, const FingerContact& finger, const Vector3d& force_O,
            std::vector<Vector3d>* f_O) {
  const Contact& contact = finger.contact();
  const auto add = [&](int triangle, const Vector3d& weights) {
    const auto& nodes = surface.triangles[static_cast<std::size_t>(triangle)];
    for (std::size_t c = 0; c < 3; ++c) {
      (*f_O)[static_cast<std::size_t>(nodes[c])] += weights[static_cast<Eigen::Index>(c)] * force_O;
    }
  };
  SurfacePlace place;
  place.triangle = contact.element;
  const SurfacePatch patch =
      contact.width > 0 ? PatchAt(surface, place, contact.p_O, contact.width) : SurfacePatch{};
  double area = 0;
  for (const int t : patch.triangles) area += Area(surface, t);
  if (!(area > 0)) return add(contact.element, finger.weights());
  for (const int t : patch.triangles) add(t, Vector3d::Constant(Area(surface, t) / area / 3));
}

// nullopt: a fingertip touches with a force that nobody knows.
std::optional<std::vector<Vector3d>> NodalForces(const TactileEstimator& estimator) {
  const SurfaceMesh& surface = estimator.body()->surface;
  const Eigen::Matrix3d R_OS = estimator.X_SO().linear().transpose();
  std::vector<Vector3d> f_O(surface.nodes.size(), Vector3d::Zero());
  for (int i = 0; i < estimator.finger_count(); ++i) {
    if (!estimator.contact(i).has_place()) continue;
    const std::optional<Vector3d>& felt = estimator.finger(i).force;
    if (!felt) return std::nullopt;
    Spread(surface, estimator.contact(i), -(R_OS * *felt), &f_O);
  }
  return f_O;
}

}  // namespace

FingertipSense::FingertipSense(const Scene& scene, const Pace& pace, World* world)
    : FingertipSense(scene, Open(scene, pace, world), LoadSenses(scene)) {}

FingertipSense::FingertipSense(const Scene& scene, std::unique_ptr<TactileSource> source,
                               TactileSenses senses)
    : scene_(scene), source_(std::move(source)), estimator_(scene, std::move(senses)) {}

bool FingertipSense::Acquire(const std::stop_token& stop) {
  const std::optional<TactileFrame> frame = source_->Next(stop);
  if (frame) next_ = *frame;
  return frame.has_value();
}

const ContactEstimate& FingertipSense::Estimate(const Vector3d& p_S_tip) noexcept {
  return estimator_.Feel(next_, p_S_tip);
}

LocalModel FingertipSense::LocalModelAt(const Vector3d& p_S_tip) noexcept {
  return estimator_.LocalAt(p_S_tip);
}

BoundaryShape FingertipSense::Shape(bool nodal_forces) {
  BoundaryShape shape;
  shape.nodes_per_element = 3;
  shape.state_sequence = estimator_.felt().sample;
  shape.sensed_at = estimator_.felt().sensed_at;
  shape.validity = estimator_.shape_validity();
  const TactileBody* body = estimator_.body();
  if (body == nullptr) return shape;
  const Eigen::Isometry3d& X_SO = estimator_.X_SO();
  std::vector<Vector3d> p_S;
  estimator_.DeformedNodes(&p_S);
  shape.elements = body->skin_triangles;
  for (const int node : body->skin) {
    const auto i = static_cast<std::size_t>(node);
    Append(&shape.rest, X_SO * body->surface.nodes[i]);
    Append(&shape.positions, p_S[i]);
  }
  if (!nodal_forces) return shape;
  const auto f_O = NodalForces(estimator_);
  if (!f_O) return shape;
  for (const int node : body->skin) {
    Append(&shape.nodal_forces, X_SO.linear() * (*f_O)[static_cast<std::size_t>(node)]);
  }
  return shape;
}

std::unique_ptr<Rebuilt> FingertipSense::Prepare(const Scene& changed) const {
  return TactileEstimator::Prepare(changed);
}

void FingertipSense::Adopt(std::unique_ptr<Rebuilt> rebuilt, const Scene& changed) {
  estimator_.Adopt(std::unique_ptr<TactileBody>(static_cast<TactileBody*>(rebuilt.release())),
                   changed);
}

SenseInfo FingertipSense::info() const {
  SenseInfo info;
  info.source = source_->description();
  info.samples = "samples";
  info.tip_resolution = kPoseResolution;
  info.model.kind = "none";
  info.reason = "nothing says where the fingertips are, so nothing deforms";
  if (estimator_.body() != nullptr) {
    info.model = estimator_.body()->info();
    info.reason = ChooseModel(scene_).reason;
  }
  info.remarks.push_back(fmt::format(
      "rest values come from the first {} samples: nothing may touch the fingertips yet",
      scene_.sense.tactile->rest_samples));
  info.changeable = {ObjectClass::kVolume, 0, false, true};
  return info;
}

std::vector<StageTimes> FingertipSense::Stages() const {
  const TactileTimes& times = estimator_.times();
  return {TimesOf("tactile", times.tactile), TimesOf("contact", times.contact),
          TimesOf("mechanics", times.mechanics), TimesOf("total", times.total)};
}

TactileInbox* FingertipSense::inbox() {
  return dynamic_cast<TactileInbox*>(source_.get());
}

}  // namespace palpate
