#include "slave/tactile/recordings/recorded_forces.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "slave/capture/tactile_instants.h"
#include "slave/tactile/recordings/force_curve.h"
#include "slave/tactile/recordings/recorded_finger.h"

namespace palpate {
namespace {

constexpr double kPeriod = 1 / kNetworkRate;  // [s]
constexpr double kSamePeriod = 0.1;           // parts by which a sample period may differ
constexpr double kLargestGap = 3;             // periods

std::vector<TactileInstant> InstantsOf(const DataArgument& data,
                                       const TactileRecording& recording) {
  const double period = MedianPeriod(recording.t);
  RefuseSlow(data.tactile, period, kNetworkRate);
  if (std::abs(period - kPeriod) <= kSamePeriod * kPeriod) {
    return InstantsOfSamples(recording.t, period, kLargestGap * kPeriod);
  }
  return SteadyInstants(recording.t, kNetworkRate, kLargestGap * std::max(period, kPeriod));
}

void SetWanted(const DataArgument& data, LabelledRecording* recording) {
  const auto index = [&](double t) {
    return static_cast<std::size_t>(std::ranges::lower_bound(recording->t, t) -
                                    recording->t.begin());
  };
  recording->begin = index(data.from);
  recording->end = index(data.to);
}

}  // namespace

std::vector<LabelledRecording> ReadRecordedForces(const DataArgument& data,
                                                  const RecordedForceOptions& options) {
  const TactileRecording recording = ReadRecordedFinger(data, options.finger);
  const ForceCurve curve =
      data.wrench.empty() ? ForceCurve(data.tactile, recording) : ForceCurve(data.wrench);
  const std::vector<TactileInstant> instants = InstantsOf(data, recording);
  RestValues rest(options.rest_samples);
  for (const TactileInstant& i : instants) rest.Take(FrameAt(recording, i).fingers[0]);
  if (!rest.known()) {
    throw std::runtime_error(data.tactile.string() + ": " + std::to_string(instants.size()) +
                             " samples: too few for rest values from the first " +
                             std::to_string(options.rest_samples));
  }
  std::vector<LabelledRecording> labelled;
  bool joined = false;  // to the sample before
  for (const TactileInstant& i : instants) {
    const std::optional<Eigen::Vector3d> force = curve.At(i.t);
    if (i.after_gap || !force) joined = false;
    if (!force) continue;
    if (!joined) {
      labelled.push_back({.name = data.text,
                          .file = data.tactile,
                          .missing_column = recording.fingers[0].MissingColumn()});
    }
    joined = true;
    labelled.back().t.push_back(i.t);
    labelled.back().change.push_back(rest.Change(FrameAt(recording, i).fingers[0]));
    labelled.back().force.push_back(force->cast<float>());
  }
  if (labelled.empty()) {
    throw std::runtime_error(data.text + ": the force's times and the samples' do not overlap");
  }
  for (LabelledRecording& r : labelled) SetWanted(data, &r);
  std::erase_if(labelled, [](const LabelledRecording& r) { return r.begin >= r.end; });
  if (labelled.empty()) {
    throw std::runtime_error(data.text + ": no samples between these times: the recording has " +
                             std::to_string(recording.t.front()) + " to " +
                             std::to_string(recording.t.back()) + " s");
  }
  return labelled;
}

bool Overlap(const LabelledRecording& a, const LabelledRecording& b) {
  std::error_code missing;
  if (a.file.empty() || !std::filesystem::equivalent(a.file, b.file, missing)) return false;
  return a.t[a.begin] <= b.t[b.end - 1] && b.t[b.begin] <= a.t[a.end - 1];
}

}  // namespace palpate
