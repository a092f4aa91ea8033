#include "slave/live/live_settings.h"

#include <stdexcept>
#include <utility>

namespace palpate {
LiveSettings::LiveSettings(const Scene& scene, SensingPipeline* sense,
                           PriorityInheritanceMutex* sense_mutex, OperatorPort* port,
                           LatestEstimate* newest)
    : sense_(sense),
      sense_mutex_(sense_mutex),
      port_(port),
      newest_(newest),
      scene_(scene),
      info_(sense->info()) {}

SenseInfo LiveSettings::info() const {
  const std::lock_guard lock(mutex_);
  return info_;
}

void LiveSettings::ReadInfo() {
  {
    const std::scoped_lock lock(*sense_mutex_, mutex_);
    info_ = sense_->info();
  }
  ++revision_;
}

Scene LiveSettings::scene() const {
  const std::lock_guard lock(mutex_);
  return scene_;
}

double LiveSettings::FullScale() const {
  const std::lock_guard lock(mutex_);
  return scene_.operator_options.force_limit / port_->transform().force_scale;
}

std::unique_ptr<PreparedModel> LiveSettings::Prepare(const Scene& changed,
                                                     Progress* progress) const {
  std::unique_ptr<PreparedModel> prepared = sense_->Prepare(changed, progress);
  ReportProgress(progress, "ready", 1);
  return prepared;
}

// Call with *sense_mutex_ and mutex_ locked.
void LiveSettings::Adopt(const Scene& changed, std::unique_ptr<PreparedModel> prepared) {
  if (prepared) info_.model = prepared->info();
  sense_->Adopt(std::move(prepared), changed);
  scene_ = changed;
  newest_->Add(Event::kModelChanged);
}

void LiveSettings::SetModel(const ModelChange& change, Progress* progress) {
  const std::lock_guard one_at_a_time(change_mutex_);
  RefuseUnlessFree();
  Scene changed = scene();
  changed.model = Changed(changed.model, change, info().object);
  std::unique_ptr<PreparedModel> prepared = Prepare(changed, progress);
  const std::scoped_lock lock(*sense_mutex_, mutex_);
  RefuseUnlessFree();  // an operator may have engaged meanwhile
  ++revision_;         // first: who engages from now on with the former settings is held
  Adopt(changed, std::move(prepared));
  info_.reason = "set by SetModel";
}

void LiveSettings::SetParameters(const ParameterChange& change, Progress* progress) {
  CheckRanges(change);
  const std::lock_guard one_at_a_time(change_mutex_);
  RefuseUnlessFree();
  Scene changed = scene();
  std::unique_ptr<PreparedModel> prepared;
  if (change.young_modulus) {
    changed.object.material.young_modulus = *change.young_modulus;
    prepared = Prepare(changed, progress);
  }
  if (change.force_limit) changed.operator_options.force_limit = *change.force_limit;
  // Everything that may fail is done before the first change.
  const std::scoped_lock lock(*sense_mutex_, mutex_);
  RefuseUnlessFree();  // an operator may have engaged meanwhile
  ++revision_;         // first, as in SetModel
  if (change.position_scale || change.force_scale) {
    port_->SetScales(change.position_scale, change.force_scale);
  }
  if (change.young_modulus) {
    Adopt(changed, std::move(prepared));
  } else {
    scene_ = changed;
  }
}

void LiveSettings::RefuseUnlessFree() const {
  palpate::RefuseUnlessFree(*port_, newest_->TouchesAsFarAsKnown());
}

}  // namespace palpate
