#include "slave/live/patch_publisher.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "shared/validation/validation.h"

namespace palpate {
namespace {

constexpr double kLeaves = 0.5;    // fraction of a patch's reach at which another one is made
constexpr double kSigmas = 2;      // sigmas of a force below which it gives no information
constexpr double kChanged = 0.01;  // change of a law's ratios that is published
// Error of the shown surface position, relative to the patch's depth.
constexpr double kAstray = 0.01;

double SecondsOf(Time t) {
  return SecondsBetween(Time{}, t);
}

// Returns whether the force changes anywhere by more than this share.
bool IsOther(const PatchLaw& law, const PatchLaw& published, double share) {
  for (std::size_t i = 0; i < law.ratios.size(); ++i) {
    if (std::abs(law.ratios[i] - published.ratios[i]) > share * published.ratios[i]) return true;
  }
  return false;
}

bool IsElsewhere(const PatchLaw& law, const PatchLaw& published) {
  return (law.offset - published.offset).norm() > 0;
}

void Move(const SurfaceMotion& motion, PatchLaw* law) {
  law->offset = motion.offset;
  law->velocity = motion.velocity;
  law->velocity_error = motion.velocity_error;
}

}  // namespace

PatchSnapshot PatchPublisher::Get(Time now) {
  asked_at_ = now;
  const std::lock_guard lock(mutex_);
  return news_;
}

void PatchPublisher::Update(const ContactEstimate& estimate, std::uint32_t settings_revision,
                            SensingPipeline* sense, Time now) {
  const bool is_known = IsForceKnown(estimate) && estimate.validity != Validity::kPunctured;
  if (is_known) learnt_law_.AddSample(estimate.p_S_tip, *estimate.force, estimate.sigma);
  if (SecondsBetween(asked_at_, now) > kWanted || !estimate.p_S_tip.allFinite()) return;
  const SurfacePatch& patch = shown_.patch();
  const bool is_old = !patch.known() || patch.settings_revision != settings_revision;
  const bool is_outgrown =
      sense->HasOutgrownPatch() && !(SecondsBetween(published_at_, now) < kMinPeriod);
  if (is_outgrown) published_at_ = now;
  if (is_old || is_outgrown || IsLeft(estimate.p_S_tip)) Renew(estimate, settings_revision, sense);
  if (shown_.patch().known() && is_known) Compare(estimate, sense, now);
}

// Returns whether the tip is past the midpoint between the patch's centre and its edge.
bool PatchPublisher::IsLeft(const Eigen::Vector3d& p_S) const noexcept {
  const SurfacePatch& patch = shown_.patch();
  if (patch.vertices_per_cell == 1) return false;
  const Eigen::Vector3d p_rest = p_S - shown_.law().offset + patch.tools[0].centre;
  const Eigen::Vector3d p = NearestPlace(patch, p_rest).p;
  return (p - centre_).norm() > kLeaves * reach_;
}

void PatchPublisher::Renew(const ContactEstimate& estimate, std::uint32_t settings_revision,
                           SensingPipeline* sense) {
  auto patch = std::make_unique<SurfacePatch>();
  PatchLaw law;
  is_learnt_ = !sense->MakePatch(estimate.p_S_tip, patch.get());
  if (is_learnt_ && !learnt_law_.known()) return;
  FillLaw(estimate, sense, patch.get(), &law);
  patch->epoch = law.epoch = shown_.patch().epoch + 1;
  patch->settings_revision = settings_revision;
  law.revision = 1;
  centre_ = NearestPlace(*patch, estimate.p_S_tip - law.offset + patch->tools[0].centre).p;
  reach_ = 0;
  for (int i = 0; i < patch->vertex_count; ++i) {
    const auto& vertex = patch->vertices[static_cast<std::size_t>(i)];
    reach_ = std::max(reach_, (vertex.cast<double>() - centre_).norm());
  }
  Put(*patch, law);
}

void PatchPublisher::FillLaw(const ContactEstimate& estimate, SensingPipeline* sense,
                             SurfacePatch* plane, PatchLaw* law) const {
  law->sensed_at = estimate.sensed_at;
  if (is_learnt_) {
    learnt_law_.Export(plane, law);
  } else {
    sense->LearnLaw(law);
    Move(sense->motion(), law);
  }
}

void PatchPublisher::Compare(const ContactEstimate& estimate, SensingPipeline* sense, Time now) {
  const double t = SecondsOf(estimate.sensed_at);
  const Eigen::Vector3d shown = shown_.ForceAt(estimate.p_S_tip, t, t);
  const double force_size = estimate.force->norm();
  const double unknown = kSigmas * estimate.sigma;
  const bool presses = force_size > unknown;
  const bool is_noticed =
      (shown - *estimate.force).norm() > options_.weber_fraction * force_size + unknown;
  const bool lets_go = pressed_ && !presses;
  pressed_ = pressed_ || presses;
  // A single force is uncertain; a curve learnt from many may differ by more from the published
  // one.
  const bool may_have_learnt = presses && !is_learnt_;
  // This also applies before contact, because the start of the contact depends on it.
  const Eigen::Vector3d astray = sense->motion().offset - shown_.ShiftAt(t, t);
  const bool moves = !is_learnt_ && astray.norm() > kAstray * shown_.patch().full_depth;
  if (!is_noticed && !lets_go && !may_have_learnt && !moves) return;
  if (SecondsBetween(published_at_, now) < kMinPeriod) return;
  PatchLaw law = shown_.law();
  const SurfacePatch& before = shown_.patch();
  if (is_learnt_) {
    auto plane = std::make_unique<SurfacePatch>(before);
    FillLaw(estimate, sense, plane.get(), &law);
    // The sent compliance is kept; curve and surface offset include the difference.
    const double scale = static_cast<double>(before.compliance(0, 0) / plane->compliance(0, 0));
    for (double& ratio : law.ratios) ratio *= scale;
    law.offset = (plane->vertices[0] - before.vertices[0]).cast<double>();
  } else {
    FillLaw(estimate, sense, nullptr, &law);
  }
  const bool is_reported = is_noticed || lets_go;
  if (is_reported) pressed_ = presses;
  const bool is_elsewhere = is_learnt_ ? IsElsewhere(law, shown_.law()) : moves;
  if (!is_elsewhere &&
      !IsOther(law, shown_.law(), is_reported ? kChanged : options_.weber_fraction)) {
    return;
  }
  ++law.revision;
  published_at_ = now;
  Put(before, law);
}

void PatchPublisher::Put(const SurfacePatch& patch, PatchLaw law) {
  Validate(patch, "PatchPublisher::Put");
  Validate(law, "PatchPublisher::Put");
  const double t = SecondsOf(law.sensed_at);
  if (patch.epoch == shown_.patch().epoch) {
    shown_.TakeLaw(law, t, t);
  } else {
    shown_.Take(patch, law, t, t);
  }
  const std::lock_guard lock(mutex_);
  if (!news_.patch || news_.patch->epoch != patch.epoch) {
    news_.patch = std::make_shared<const SurfacePatch>(patch);
  }
  news_.law = law;
}

}  // namespace palpate
