#include "slave/pipeline/fingertips/tactile_run.h"

#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "slave/capture/tactile_recording.h"
#include "slave/pipeline/offline/states_file.h"
#include "slave/site/fingertips/scripted_touch.h"

namespace palpate {
namespace {

using SteadyClock = std::chrono::steady_clock;
using Eigen::Vector3d;
using Truths = std::array<FingerTruth, kMaxFingers>;

constexpr double kContactShare = 0.01;  // of the peak: below it a sample does not count as contact

// Where the samples come from, and the truth where it is known.
struct Origin {
  explicit Origin(const Scene& scene, int presses) {
    switch (scene.sense.tactile->source) {
      case Tactile::Source::kSimulated: {
        auto scripted = std::make_unique<ScriptedTouch>(scene, presses);
        touch = scripted.get();
        source = std::move(scripted);
        break;
      }
      case Tactile::Source::kRecording:
        source = OpenTactileRecording(scene, false);
        break;
      case Tactile::Source::kStream:
        throw std::invalid_argument(
            scene.file.string() +
            ": sense.tactile.source = stream: accepted here is a recording, or simulated");
    }
  }
  std::unique_ptr<TactileSource> source;
  const ScriptedTouch* touch = nullptr;  // of a simulated site
};

// One fingertip's forces in one sample [N].
struct Compared {
  double error, estimated, truth;
  double model_error;  // NaN: none
};

class Comparison {
 public:
  void Add(const TactileEstimator& estimator, const Truths& truths) {
    for (int i = 0; i < estimator.finger_count(); ++i) {
      const FingerEstimate& felt = estimator.finger(i);
      const FingerTruth& truth = truths[static_cast<std::size_t>(i)];
      peak_ = std::fmax(peak_, truth.force.norm());
      if (!felt.force) continue;
      rows_.push_back({(*felt.force - truth.force).norm(), felt.force->norm(), truth.force.norm(),
                       i == 0 ? ModelError(estimator.felt().local_model, truth)
                              : std::numeric_limits<double>::quiet_NaN()});
    }
  }
  [[nodiscard]] TouchError Result() const {
    TouchError result;
    result.true_peak = peak_;
    double sum = 0, model_sum = 0;
    std::uint64_t model_count = 0;
    for (const Compared& row : rows_) {
      if (std::fmax(row.estimated, row.truth) <= kContactShare * peak_) continue;
      ++result.count;
      sum += row.error * row.error;
      result.peak = std::fmax(result.peak, row.error);
      if (!std::isfinite(row.model_error)) continue;
      ++model_count;
      model_sum += row.model_error * row.model_error;
    }
    result.rms = result.count > 0 ? std::sqrt(sum / static_cast<double>(result.count)) : 0;
    result.model_rms =
        model_count > 0 ? std::sqrt(model_sum / static_cast<double>(model_count)) : 0;
    return result;
  }

 private:
  static double ModelError(const LocalModel& local, const FingerTruth& truth) {
    return (local.stiffness * local.normal * truth.depth).norm() - truth.force.norm();
  }

  std::vector<Compared> rows_;
  double peak_ = 0;
};

Vector3d OrUnknown(bool known, const Vector3d& p) {
  return known ? p : Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
}

StateRow RowOf(const FingerEstimate& finger, const std::string& name, const ContactEstimate& felt,
               Time start) {
  return {SecondsBetween(start, felt.sensed_at),
          felt.sequence,
          name,
          OrUnknown(finger.has_pose, finger.p_S_apex),
          finger.p_S_contact.value_or(OrUnknown(false, {})),
          finger.force,
          finger.sigma,
          finger.validity,
          std::nullopt};
}

nlohmann::ordered_json ErrorJson(const TouchError& error) {
  if (error.count == 0) return nullptr;
  return {{"rms_N", error.rms},
          {"peak_N", error.peak},
          {"contact_samples", error.count},
          {"true_peak_N", error.true_peak},
          {"model_rms_N", error.model_rms}};
}

void WriteSummary(const TactileSummary& s, const Scene& scene, const std::filesystem::path& file) {
  nlohmann::ordered_json json = SummaryJson(s, scene.name,
                                            {{"tactile", s.times.tactile},
                                             {"contact", s.times.contact},
                                             {"mechanics", s.times.mechanics},
                                             {"total", s.times.total}},
                                            s.has_truth ? ErrorJson(s.error) : nullptr);
  json["fingers"] = scene.sense.tactile->fingers.size();
  json["network"] = s.network;
  json["localiser"] = s.localiser;
  WriteJson(json, file);
}

void Count(const TactileEstimator& estimator, TactileSummary* summary) {
  ++summary->frames;
  for (int i = 0; i < estimator.finger_count(); ++i) {
    summary->Count(estimator.finger(i).validity);
  }
}

void Describe(const TactileEstimator& estimator, TactileSummary* summary) {
  summary->model.kind = "none";
  if (estimator.body() != nullptr) summary->model = estimator.body()->deformation->info();
  if (estimator.network() != nullptr) summary->network = estimator.network()->info().architecture;
  summary->localiser = estimator.localiser().name();
}

}  // namespace

TactileSummary RunTactile(const Scene& scene, const TactileRunOptions& options,
                          const std::stop_token& stop) {
  Origin origin(scene, options.presses);
  TactileSummary summary;
  summary.has_truth = origin.touch != nullptr;
  TactileEstimator estimator(scene);
  Describe(estimator, &summary);
  StatesFile states(options.out, summary.has_truth);
  Comparison comparison;
  std::optional<Time> start;
  const auto began = SteadyClock::now();
  for (;;) {
    const auto fetch = SteadyClock::now();
    const std::optional<TactileFrame> frame = origin.source->Next(stop);
    summary.capture.Add(
        std::chrono::duration<double, std::micro>(SteadyClock::now() - fetch).count());
    if (!frame) break;
    if (!start) start = frame->sensed_at;
    const ContactEstimate& felt = estimator.Feel(*frame, scene.manipulator.home);
    const Truths truths = origin.touch != nullptr ? origin.touch->site().truth() : Truths{};
    for (int i = 0; i < estimator.finger_count(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      StateRow row = RowOf(estimator.finger(i), scene.sense.tactile->fingers[k].name, felt, *start);
      if (summary.has_truth) row.true_force = truths[k].force;
      states.Write(row);
    }
    if (summary.has_truth) comparison.Add(estimator, truths);
    Count(estimator, &summary);
    if (options.progress) options.progress(summary.frames);
  }
  if (!start && !stop.stop_requested()) {
    throw std::runtime_error(origin.source->description() + ": no sample came");
  }
  summary.seconds = std::chrono::duration<double>(SteadyClock::now() - began).count();
  const int rest = scene.sense.tactile->rest_samples;
  if (!stop.stop_requested() && summary.frames < static_cast<std::uint64_t>(rest)) {
    throw std::runtime_error(
        fmt::format("{}: {} samples are fewer than the {} of `rest`: nothing "
                    "can be said",
                    origin.source->description(), summary.frames, rest));
  }
  summary.times = estimator.times();
  summary.error = comparison.Result();
  WriteSummary(summary, scene, options.out / "summary.json");
  return summary;
}

}  // namespace palpate
