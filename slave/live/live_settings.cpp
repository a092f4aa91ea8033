#include "slave/live/live_settings.h"

#include <stdexcept>
#include <thread>
#include <utility>
#include <variant>

namespace palpate {
namespace {

// What `auto` decides about.
bool IsSameModel(const ModelOptions& a, const ModelOptions& b) {
  return a.kind == b.kind && a.elements == b.elements && a.order == b.order && a.modes == b.modes &&
         a.refinements == b.refinements && a.fem.element == b.fem.element &&
         a.fem.law == b.fem.law && a.fem.residual == b.fem.residual;
}

// Senses number the nodes of a volume; an outline is divided anew for any model.
bool IsSameMesh(const Scene& a, const Scene& b) {
  const auto* box = std::get_if<BoxGeometry>(&a.object.geometry);
  const bool has_same_cells =
      box == nullptr || box->cells == std::get<BoxGeometry>(b.object.geometry).cells;
  return has_same_cells && a.model.refinements == b.model.refinements;
}

}  // namespace

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

// Under *sense_mutex_ and mutex_.
void LiveSettings::Adopt(const Scene& changed, std::unique_ptr<PreparedModel> prepared) {
  if (prepared) info_.model = prepared->info();
  sense_->Adopt(std::move(prepared), changed);
  scene_ = changed;
  newest_->Add(Event::kModelChanged);
}

std::string LiveSettings::RechooseModel(double depth, const ModelChooser& choose,
                                        const std::stop_token& stop) try {
  constexpr std::chrono::milliseconds kLookAgain(20);
  const std::uint32_t revision = revision_;
  Scene changed = scene();
  if (changed.model.decision.reason.empty())
    return "the model is unchanged: it was set by SetModel";
  Scene asked = changed;
  asked.operator_options.press_depth = depth;
  const auto decided = choose(asked, stop);
  if (!decided) return "the model is unchanged: no model has a known error";
  changed.model = decided->model;
  const std::string& why = changed.model.decision.reason;
  if (IsSameModel(changed.model, asked.model)) return "the model is unchanged; " + why;
  if (!IsSameMesh(*decided, asked)) {
    return "the model is unchanged: a mesh can change only at a start (operator.press.depth); " +
           why;
  }
  std::unique_ptr<PreparedModel> prepared = sense_->Prepare(changed, nullptr);
  while (!stop.stop_requested() && !TryAdopt(changed, revision, &prepared)) {
    std::this_thread::sleep_for(kLookAgain);
  }
  return IsSameModel(scene().model, changed.model)
             ? why
             : "the model is unchanged: settings have changed";
} catch (const std::exception& error) {
  return error.what();
}

bool LiveSettings::TryAdopt(const Scene& changed, std::uint32_t revision,
                            std::unique_ptr<PreparedModel>* prepared) {
  const std::unique_lock one_at_a_time(change_mutex_, std::try_to_lock);
  if (!one_at_a_time) return false;
  if (revision_ != revision) return true;
  const std::scoped_lock lock(*sense_mutex_, mutex_);  // no estimate is made meanwhile
  if (port_->view().phase == Phase::kFollowing || newest_->Touches()) return false;
  Adopt(changed, std::move(*prepared));
  info_.reason = changed.model.decision.reason;
  ++revision_;
  return true;
}

void LiveSettings::SetModel(const ModelChange& change, Progress* progress) {
  const std::lock_guard one_at_a_time(change_mutex_);
  RefuseUnlessFree();
  Scene changed = scene();
  changed.model = Changed(changed.model, change, info().object);
  std::unique_ptr<PreparedModel> prepared = Prepare(changed, progress);
  const std::scoped_lock lock(*sense_mutex_, mutex_);
  RefuseUnlessFree();  // an operator may have engaged meanwhile
  Adopt(changed, std::move(prepared));
  info_.reason = "set by SetModel";
  ++revision_;
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
  // All or nothing: what may fail comes before the first change.
  const std::scoped_lock lock(*sense_mutex_, mutex_);
  RefuseUnlessFree();  // an operator may have engaged meanwhile
  if (change.position_scale || change.force_scale) {
    port_->SetScales(change.position_scale, change.force_scale);
  }
  if (change.young_modulus) {
    Adopt(changed, std::move(prepared));
  } else {
    scene_ = changed;
  }
  ++revision_;
}

void LiveSettings::RefuseUnlessFree() const {
  palpate::RefuseUnlessFree(*port_, newest_->TouchesSurely());
}

}  // namespace palpate
