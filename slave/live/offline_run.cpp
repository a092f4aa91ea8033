#include "slave/live/offline_run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "shared/state/driven_clock.h"
#include "shared/text/text.h"
#include "shared/wire/enum_names.h"
#include "slave/capture/codecs/codecs.h"
#include "slave/capture/simulated_samples.h"
#include "slave/live/live_slave.h"
#include "slave/live/simulated_drivers.h"
#include "slave/pipeline/base/sense_recorder.h"

namespace palpate {
namespace {

constexpr int kJpegQuality = 90;

// [us]
nlohmann::ordered_json StageJson(const StageTimes& times) {
  return {{"p50", times.p50_us}, {"p99", times.p99_us}, {"max", times.max_us}};
}

nlohmann::ordered_json ToJson(const OfflineSummary& s, const Scene& scene) {
  nlohmann::ordered_json json;
  json["scene"] = scene.name;
  json["frames"] = s.frames;
  json["fps"] = s.rate();
  json["stages"]["capture"] = StageJson(TimesOf("capture", s.capture));
  for (const StageTimes& stage : s.stages) json["stages"][stage.stage] = StageJson(stage);
  json["tracking_lost"] = s.tracking_lost;
  json["force_error"] = ToJson(s.budget, s.sense.samples == "samples" ? "samples" : "frames");
  json["validity"] = s.validity;
  json["checks"] = s.checks;
  const ModelInfo& model = s.sense.model;
  json["model"] = {{"kind", model.kind},
                   {"elements", model.elements},
                   {"dof", model.dof},
                   {"precompute_s", model.precompute_s},
                   {"reason", s.sense.reason}};
  json.update(s.own);
  return json;
}

// Puncture of a simulated target. Samples count from 1; 0: none.
struct Insertion {
  // Smallest distance from tip to target after the puncture [m].
  double closest = std::numeric_limits<double>::infinity();
  std::uint64_t punctured = 0, detected = 0;  // first sample

  void Add(std::uint64_t sample, const Truth& truth, const Eigen::Vector3d& p_S_target,
           const Events& events) {
    if (truth.punctured) closest = std::min(closest, (truth.p_S_tip - p_S_target).norm());
    if (truth.punctured && punctured == 0) punctured = sample;
    if (events.Has(Event::kPuncture) && detected == 0) detected = sample;
  }
};

nlohmann::ordered_json VectorJson(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

// Time from the beginning of a step to its sample.
class CaptureTimes final : public SenseRecorder {
 public:
  void BeginStep() { lap_.Lap(); }
  [[nodiscard]] const LatencyHistogram& times() const { return times_; }

  void Begin() override {}
  [[nodiscard]] std::string trouble() const override { return {}; }
  std::unique_ptr<SensingPipeline> Watch(std::unique_ptr<SensingPipeline> sense) override {
    return sense;
  }
  void Opened() override {}
  void OnSample(const Frame& /*frame*/) override { Add(); }
  void OnSample(const StereoPair& /*pair*/) override { Add(); }
  void OnSample(const TactileFrame& /*frame*/) override { Add(); }

 private:
  void Add() { times_.Add(lap_.Lap()); }

  Stopwatch lap_;
  LatencyHistogram times_;
};

void RequireEnd(const Scene& scene, const OfflineOptions& options) {
  if (IsSimulated(scene)) return;
  const auto* tactile = scene.sense.Find<Tactile>();
  if (tactile != nullptr && tactile->source == Tactile::Source::kStream) {
    throw std::invalid_argument(
        scene.file.string() +
        ": sense.tactile.source = stream: expected a recording, or simulated");
  }
  if (TakesImages(scene.sense)) {
    throw std::invalid_argument(
        "sense.camera.source = stream: expected recorded or simulated images");
  }
  if (options.duration > 0) {
    throw std::invalid_argument(fmt::format(
        "--duration: only for a simulated target that moves on a path; the files of {} end on "
        "their own",
        scene.file.string()));
  }
}

class Run {
 public:
  Run(const Scene& scene, const OfflineOptions& options)
      : scene_(scene),
        options_(options),
        simulation_(IsSimulated(scene) ? StartSimulation(scene, {.duration = options.duration})
                                       : nullptr),
        slave_(MakeLiveSlave(scene, {}, &capture_)),
        drivers_(*slave_) {
    summary_.has_truth = simulation_ != nullptr;
    summary_.sense = slave_->sense().info();
    states_.emplace(options.out, summary_.has_truth && summary_.sense.has_force_estimate);
    if (options.images) std::filesystem::create_directories(options.out / "images");
    OpenReport();
  }

  OfflineSummary Go(const std::stop_token& stop) {
    Stopwatch whole;
    while (Step(stop)) {
    }
    if (!stop.stop_requested()) RequireComplete();
    summary_.seconds = 1e-6 * whole.Lap();
    summary_.capture = capture_.times();
    summary_.stages = slave_->sense().Stages();
    if (offline_report_) {
      summary_.budget = BudgetOf(offline_report_->compared());
      offline_report_->Finish(&summary_);
    }
    ReportInsertion();
    WriteWholeFile(options_.out / "summary.json", ToJson(summary_, scene_).dump(2) + "\n");
    return std::move(summary_);
  }

 private:
  // Sensing of streamed images begins with the first image.
  void OpenReport() {
    if (offline_report_) return;
    offline_report_ = slave_->sense().OpenOfflineReport(simulation_.get());
    if (!offline_report_) return;
    summary_.sense = slave_->sense().info();
    if (options_.frames) offline_report_->OpenFrames(options_.out / "frames");
    if (options_.points) offline_report_->OpenPoints(options_.out / "points.csv");
  }

  // Returns false if there are no more samples.
  bool Step(const std::stop_token& stop) {
    capture_.BeginStep();
    if (simulation_) {
      const v1::SimulatedSample* sample = simulation_->Next(stop);
      if (sample == nullptr) return false;
      drivers_.Send(*sample);
    }
    if (slave_->Step(stop)) {
      OpenReport();
      Report();
      return true;
    }
    const auto cameras = slave_->sense().health();
    if (simulation_ && cameras && !cameras->trouble.empty()) {
      throw std::runtime_error(cameras->trouble);
    }
    return simulation_ != nullptr;
  }

  void Report() {
    const std::optional<Truth> truth =
        simulation_ ? std::optional(simulation_->truth()) : std::nullopt;
    const ContactEstimate estimate = slave_->Compose(Clock::now());
    if (summary_.frames++ == 0) start_ = estimate.sensed_at;
    if (const auto goal = simulation_ ? simulation_->goal() : std::nullopt; goal) {
      insertion_.Add(summary_.frames, *truth, *goal, slave_->TakeEvents());
    }
    for (const StateRow& row : offline_report_->Add(start_, truth ? &*truth : nullptr)) {
      ++summary_.validity[std::string(ToString(row.validity))];
      if (row.check != FailedCheck::kNone) ++summary_.checks[std::string(ToString(row.check))];
      if (row.validity == Validity::kTrackingLost) ++summary_.tracking_lost;
      states_->Write(row);
    }
    if (options_.frames) offline_report_->WriteFrame(options_.out / "frames");
    if (options_.images) WriteImage(estimate.sample);
    if (options_.progress) options_.progress(summary_.frames);
  }

  void WriteImage(std::uint64_t sequence) const {
    const OperatorOptions& hand = scene_.operator_options;
    const auto image = slave_->sense().Image(hand.force_limit / hand.transform.force_scale);
    if (!image) return;
    const auto file = options_.out / "images" / fmt::format("{:06}.jpg", sequence);
    WriteWholeFile(file, EncodeJpeg(image->draw(), kJpegQuality));
  }

  void ReportInsertion() {
    const auto goal = simulation_ ? simulation_->goal() : std::nullopt;
    if (!goal) return;
    const bool is_near = std::isfinite(insertion_.closest);
    auto& json = summary_.own["insertion"];
    json["home"] = VectorJson(scene_.manipulator.home);
    json["target"] = VectorJson(*goal);
    json["position_scale"] = scene_.operator_options.transform.position_scale;
    json["speed"] = scene_.operator_options.press_speed;
    json["punctured_sample"] = insertion_.punctured;
    json["detected_sample"] = insertion_.detected;
    json["closest_m"] =
        is_near ? nlohmann::ordered_json(insertion_.closest) : nlohmann::ordered_json();
    summary_.lines.push_back(
        is_near
            ? fmt::format(
                  "puncture in image {}, {}; {:.1f} um from the target", insertion_.punctured,
                  insertion_.detected > 0 ? fmt::format("detected in image {}", insertion_.detected)
                                          : "not detected (model.puncture)",
                  1e6 * insertion_.closest)
            : "no puncture");
  }

  void RequireComplete() const {
    if (summary_.frames == 0) {
      throw std::runtime_error(
          fmt::format("{}: no {} received", summary_.sense.source, summary_.sense.samples));
    }
    offline_report_->RequireComplete(summary_.frames);
  }

  const DrivenClock clock_;

  const Scene& scene_;
  const OfflineOptions& options_;
  std::unique_ptr<Simulation> simulation_;  // null: recorded samples
  CaptureTimes capture_;
  std::unique_ptr<LiveSlave> slave_;
  SimulatedDrivers drivers_;
  std::unique_ptr<OfflineReport> offline_report_;
  std::optional<StatesFile> states_;
  OfflineSummary summary_;
  Insertion insertion_;
  Time start_{};
};

}  // namespace

OfflineSummary RunOffline(const Scene& scene, const OfflineOptions& options,
                          const std::stop_token& stop) {
  RequireEnd(scene, options);
  return Run(scene, options).Go(stop);
}

}  // namespace palpate
