#include "slave/live/patch_publisher.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace palpate {
namespace {

constexpr double kLeaves = 0.5;    // of a patch's reach, where another is made
constexpr double kSigmas = 2;      // of a force, that say nothing
constexpr double kChanged = 0.01;  // of a law's ratios, that is worth telling
constexpr double kAstray = 0.01;   // of a patch's depth, that a surface is from where it is shown

double SecondsOf(Time t) {
  return SecondsBetween(Time{}, t);
}

// Whether the force changes anywhere by more than this share.
bool IsOther(const PatchLaw& law, const PatchLaw& told, double share) {
  for (std::size_t i = 0; i < law.ratios.size(); ++i) {
    if (std::abs(law.ratios[i] - told.ratios[i]) > share * told.ratios[i]) return true;
  }
  return false;
}

bool IsElsewhere(const PatchLaw& law, const PatchLaw& told) {
  return (law.offset - told.offset).norm() > 0;
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

void PatchPublisher::Update(const ContactEstimate& felt, std::uint32_t settings_revision,
                            SensingPipeline* sense, Time now) {
  const bool is_felt = IsForceKnown(felt) && felt.validity != Validity::kPunctured;
  if (is_felt) felt_law_.AddSample(felt.p_S_tip, *felt.force, felt.sigma);
  if (SecondsBetween(asked_at_, now) > kWanted || !felt.p_S_tip.allFinite()) return;
  const SurfacePatch& patch = shown_.patch();
  const bool is_old = !patch.known() || patch.settings_revision != settings_revision;
  const bool is_outgrown =
      sense->HasOutgrownPatch() && !(SecondsBetween(told_at_, now) < kShortest);
  if (is_outgrown) told_at_ = now;
  if (is_old || is_outgrown || IsLeft(felt.p_S_tip)) Renew(felt, settings_revision, sense);
  if (shown_.patch().known() && is_felt) Compare(felt, sense, now);
}

// Past the middle between where it was made and where it ends.
bool PatchPublisher::IsLeft(const Eigen::Vector3d& p_S) const noexcept {
  const SurfacePatch& patch = shown_.patch();
  if (patch.vertices_per_cell == 1) return false;
  const Eigen::Vector3d p_rest = p_S - shown_.law().offset + patch.tools[0].centre;
  const Eigen::Vector3d p = NearestPlace(patch, p_rest).p;
  return (p - centre_).norm() > kLeaves * reach_;
}

void PatchPublisher::Renew(const ContactEstimate& felt, std::uint32_t settings_revision,
                           SensingPipeline* sense) {
  auto patch = std::make_unique<SurfacePatch>();
  PatchLaw law;
  is_felt_ = !sense->MakePatch(felt.p_S_tip, patch.get());
  if (is_felt_ && !felt_law_.known()) return;
  FillLaw(felt, sense, patch.get(), &law);
  patch->epoch = law.epoch = shown_.patch().epoch + 1;
  patch->settings_revision = settings_revision;
  law.revision = 1;
  centre_ = NearestPlace(*patch, felt.p_S_tip - law.offset + patch->tools[0].centre).p;
  reach_ = 0;
  for (int i = 0; i < patch->vertex_count; ++i) {
    const auto& vertex = patch->vertices[static_cast<std::size_t>(i)];
    reach_ = std::max(reach_, (vertex.cast<double>() - centre_).norm());
  }
  Put(*patch, law);
}

void PatchPublisher::FillLaw(const ContactEstimate& felt, SensingPipeline* sense,
                             SurfacePatch* plane, PatchLaw* law) const {
  law->sensed_at = felt.sensed_at;
  if (is_felt_) {
    felt_law_.Export(plane, law);
  } else {
    sense->LearnLaw(law);
    Move(sense->motion(), law);
  }
}

void PatchPublisher::Compare(const ContactEstimate& felt, SensingPipeline* sense, Time now) {
  const double t = SecondsOf(felt.sensed_at);
  const Eigen::Vector3d shown = shown_.ForceAt(felt.p_S_tip, t, t);
  const double felt_size = felt.force->norm();
  const double unknown = kSigmas * felt.sigma;
  const bool presses = felt_size > unknown;
  const bool is_noticed =
      (shown - *felt.force).norm() > options_.weber_fraction * felt_size + unknown;
  const bool lets_go = pressed_ && !presses;
  pressed_ = pressed_ || presses;
  // One force is not sure; what many of them taught may differ from what is shown by more.
  const bool may_have_learnt = presses && !is_felt_;
  // Before the touch, too: where it begins depends on it.
  const Eigen::Vector3d astray = sense->motion().offset - shown_.ShiftAt(t, t);
  const bool moves = !is_felt_ && astray.norm() > kAstray * shown_.patch().full_depth;
  if (!is_noticed && !lets_go && !may_have_learnt && !moves) return;
  if (SecondsBetween(told_at_, now) < kShortest) return;
  PatchLaw law = shown_.law();
  const SurfacePatch& before = shown_.patch();
  if (is_felt_) {
    auto plane = std::make_unique<SurfacePatch>(before);
    FillLaw(felt, sense, plane.get(), &law);
    // The compliance stays what was sent; the law takes up the difference, the offset the surface.
    const double scale = static_cast<double>(before.compliance(0, 0) / plane->compliance(0, 0));
    for (double& ratio : law.ratios) ratio *= scale;
    law.offset = (plane->vertices[0] - before.vertices[0]).cast<double>();
  } else {
    FillLaw(felt, sense, nullptr, &law);
  }
  const bool is_told = is_noticed || lets_go;
  if (is_told) pressed_ = presses;
  const bool is_elsewhere = is_felt_ ? IsElsewhere(law, shown_.law()) : moves;
  if (!is_elsewhere && !IsOther(law, shown_.law(), is_told ? kChanged : options_.weber_fraction)) {
    return;
  }
  ++law.revision;
  told_at_ = now;
  Put(before, law);
}

void PatchPublisher::Put(const SurfacePatch& patch, PatchLaw law) {
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
