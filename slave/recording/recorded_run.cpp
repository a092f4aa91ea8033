#include "slave/recording/recorded_run.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "palpate/v1/recording.pb.h"

#include "shared/program/program.h"
#include "shared/recording/recording_reader.h"
#include "shared/state/driven_clock.h"
#include "shared/text/text.h"
#include "slave/live/live_slave.h"
#include "slave/live/operator_port.h"
#include "slave/mechanics/factory/choose_model.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/offline/offline_report.h"
#include "slave/recording/recorded_samples.h"
#include "slave/recording/scene_files.h"
#include "slave/recording/sense_recording.h"
#include "slave/recording/step_messages.h"
#include "slave/scene/scene_loader.h"

namespace palpate {
namespace {

double Distance(const v1::Vec3& a, const v1::Vec3& b) {
  return std::hypot(a.x() - b.x(), a.y() - b.y(), a.z() - b.z());
}

void Compare(const v1::SenseStep::Estimate& now, const v1::SenseStep::Estimate& then,
             StateDifferences* differences) {
  ++differences->states;
  const v1::SlaveState &state = now.state(), &recorded = then.state();
  if (state.SerializeAsString() == recorded.SerializeAsString()) return;
  if (differences->different++ == 0) differences->first = now.sample();
  differences->force = std::max(differences->force, Distance(state.force(), recorded.force()));
  differences->tip = std::max(differences->tip, Distance(state.p_s_tip(), recorded.p_s_tip()));
  const bool is_as_valid =
      state.validity() == recorded.validity() && state.has_force() == recorded.has_force();
  if (!is_as_valid) ++differences->validity;
}

Scene SceneOf(const RecordedBeginning& beginning, const std::filesystem::path& folder) {
  return WithChosenModel(
      LoadScene(UnpackSceneFiles(beginning.files, folder), beginning.overrides()));
}

// Repeats the steps of a recording with a live slave and compares each new estimate.
class Again {
 public:
  Again(const std::filesystem::path& file, const std::filesystem::path& out)
      : beginning_(file),
        samples_(file),
        steps_(file),
        out_(out),
        scene_(SceneOf(beginning_, out / "scene")),
        slave_(MakeSlave()),
        sense_(slave_->sense()),
        offline_report_(sense_.OpenOfflineReport(nullptr)),
        states_(out, false) {}

  RecordedRun Run(const std::stop_token& stop, const std::function<void(std::uint64_t)>& progress) {
    v1::SenseStep step;
    while (!stop.stop_requested() && steps_.Next()) {
      if (steps_.topic() != kStepTopic) continue;
      steps_.Read(&step);
      if (!Do(step)) break;
      if (progress && step.has_estimate()) progress(run_.differences.states);
    }
    run_.version = beginning_.Value("version");
    run_.version_now = Version();
    run_.damage = samples_.gap().empty() ? steps_.damage() : samples_.gap();
    run_.scene = scene_.name;
    if (run_.differences.states == 0) {
      throw InputError((run_.damage.empty() ? "this recording" : run_.damage) +
                       ": contains no estimate: expected a recording with a sample");
    }
    WriteSummary();
    return std::move(run_);
  }

 private:
  std::unique_ptr<LiveSlave> MakeSlave() {
    auto manipulator = std::make_unique<PlayedManipulator>(scene_.manipulator.home);
    manipulator_ = manipulator.get();
    return MakePlayedSlave(scene_, samples_, std::move(manipulator));
  }
  // Returns false if the step's sample is missing because the recording is truncated.
  bool Do(const v1::SenseStep& step) {
    if (step.has_acquired()) return is_acquired_ = slave_->Acquire({});
    if (step.has_reset()) is_engaged_ = false;
    if (step.has_engaged()) is_engaged_ = true;
    if (step.has_reset() && is_acquired_) sense_.Reset([this] { return !is_engaged_; });
    if (step.has_estimate()) Estimate(step.estimate());
    if (has_estimate_) DoBetween(step);
    return true;
  }

  // Queries that need an estimate.
  void DoBetween(const v1::SenseStep& step) {
    switch (step.step_case()) {
      case v1::SenseStep::kSettings:
        return Adopt(step.settings());
      case v1::SenseStep::kPlaneAt:
        sense_.LocalModelAt(RecordedPosition(step.plane_at()));
        return;
      case v1::SenseStep::kPatchAt:
        sense_.MakePatch(RecordedPosition(step.patch_at()), patch_.get());
        return;
      case v1::SenseStep::kLaw: {
        PatchLaw law;
        return sense_.LearnLaw(&law);
      }
      case v1::SenseStep::kShape:
        sense_.Shape({.nodal_forces = step.shape()});
        return;
      default:
        return;
    }
  }

  void Estimate(const v1::SenseStep::Estimate& recorded) {
    if (!std::exchange(is_acquired_, false)) {
      throw InputError("a recorded estimate without its sample");
    }
    std::optional<std::uint32_t> frame;
    if (recorded.has_arm_frame()) frame = recorded.arm_frame();
    manipulator_->Play(RecordedPosition(recorded.p_s_arm()), frame);
    const ContactEstimate estimate = slave_->Estimate();
    v1::SenseStep::Estimate now;
    ToProto(estimate, &now);
    Compare(now, recorded, &run_.differences);
    if (!std::exchange(has_estimate_, true)) start_ = estimate.sensed_at;
    for (const StateRow& row : offline_report_->Add(start_, nullptr)) states_.Write(row);
  }

  void Adopt(const v1::SenseStep::Settings& settings) {
    Scene changed = scene_;
    if (settings.kind() != scene_.model.kind) {
      changed.model = Changed(changed.model, {settings.kind()}, sense_.info().object);
    }
    CheckRanges({.young_modulus = settings.young_modulus()});
    changed.object.material.young_modulus = settings.young_modulus();
    sense_.Adopt(sense_.Prepare(changed, nullptr), changed);
    scene_ = changed;
  }

  void WriteSummary() const {
    const StateDifferences& d = run_.differences;
    nlohmann::ordered_json json;
    json["scene"] = run_.scene;
    json["recorded_by"] = run_.version;
    json["processed_by"] = run_.version_now;
    json["states"] = d.states;
    json["different"] = d.different;
    json["first_different"] =
        d.first > 0 ? nlohmann::ordered_json(d.first) : nlohmann::ordered_json();
    json["largest"] = {{"force_N", d.force}, {"tip_m", d.tip}, {"validity", d.validity}};
    json["damage"] = run_.damage;
    WriteWholeFile(out_ / "summary.json", json.dump(2) + "\n");
  }

  const DrivenClock clock_;
  const RecordedBeginning beginning_;
  RecordedSamples samples_;
  RecordingReader steps_;
  const std::filesystem::path out_;
  Scene scene_;
  PlayedManipulator* manipulator_ = nullptr;  // of the slave
  std::unique_ptr<LiveSlave> slave_;
  SensingPipeline& sense_;
  std::unique_ptr<OfflineReport> offline_report_;
  StatesFile states_;
  std::unique_ptr<SurfacePatch> patch_ = std::make_unique<SurfacePatch>();
  bool is_acquired_ = false, has_estimate_ = false;
  bool is_engaged_ = false;  // an operator, since the last reset
  Time start_{};
  RecordedRun run_;
};

}  // namespace

RecordedRun ProcessRecording(const std::filesystem::path& file, const std::filesystem::path& out,
                             const std::stop_token& stop,
                             const std::function<void(std::uint64_t)>& progress) {
  return Again(file, out).Run(stop, progress);
}

std::vector<std::string> InWords(const RecordedRun& run) {
  const StateDifferences& d = run.differences;
  std::vector<std::string> lines{fmt::format("{}: {} states, recorded by {}, processed by {}",
                                             run.scene, d.states, Shown(run.version, 80),
                                             run.version_now)};
  if (d.different == 0) {
    lines.push_back("all are equal to the recorded states, bit for bit");
  } else {
    lines.push_back(
        fmt::format("{} differ from the recorded states, first at sample {}: by up to {:.3g} N and "
                    "{:.3g} m; {} have another validity",
                    d.different, d.first, d.force, d.tip, d.validity));
  }
  if (!run.damage.empty()) lines.push_back("incomplete: " + run.damage);
  return lines;
}

}  // namespace palpate
