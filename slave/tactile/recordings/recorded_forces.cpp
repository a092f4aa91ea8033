#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "shared/text/csv.h"
#include "slave/capture/tactile_recording.h"
#include "slave/tactile/recordings/recordings.h"

namespace palpate {
namespace {

constexpr double kOffsetTime = 0.5;       // [s]
constexpr double kLargestForceGap = 0.1;  // [s]
constexpr double kLargestForce = 1e6;     // beyond, the number is no force [N]
constexpr const char* kAccepted = "accepted is fx, fy, fz or fx_N, fy_N, fz_N, finite numbers [N]";

using Names = std::array<std::string, 3>;
const std::array<Names, 2> kNames{Names{"fx", "fy", "fz"}, Names{"fx_N", "fy_N", "fz_N"}};

// What a force sensor recorded, its offset taken off: the mean of the first half second.
class ForceCurve {
 public:
  // Columns fx, fy, fz or fx_N, fy_N, fz_N among those of a tactile recording; `file` is for
  // errors. Throws std::runtime_error: there are none, or `file:line: ...` what is no number.
  ForceCurve(const std::filesystem::path& file, const TactileRecording& recording)
      : t_(recording.t) {
    const auto& columns = recording.others;
    for (const Names& names : kNames) {
      for (const std::string& name : names) {
        const auto refused = recording.refused.find(name);
        if (refused != recording.refused.end()) throw std::runtime_error(refused->second);
      }
      if (!std::ranges::all_of(names, [&](const auto& n) { return columns.contains(n); })) continue;
      const auto &x = columns.at(names[0]), &y = columns.at(names[1]), &z = columns.at(names[2]);
      for (std::size_t i = 0; i < t_.size(); ++i) force_.emplace_back(x[i], y[i], z[i]);
      TakeOffset();
      return;
    }
    throw std::runtime_error(file.string() + ": no force columns: " + kAccepted +
                             ", or a file with them: TACTILE.csv+WRENCH.csv");
  }
  // A file of its own with a time and these columns. Throws std::runtime_error `file:line: ...`.
  explicit ForceCurve(const std::filesystem::path& file) {
    CsvRows rows(file);
    const std::size_t time = FindTimeColumn(rows);
    std::array<std::optional<std::size_t>, 3> columns;
    for (const Names& names : kNames) {
      for (std::size_t i = 0; i < 3; ++i) {
        if (!columns[i]) columns[i] = rows.Find(names[i]);
      }
    }
    if (!columns[0] || !columns[1] || !columns[2]) {
      rows.Fail(std::string("no force columns: ") + kAccepted);
    }
    while (rows.Next()) {
      const double t = ReadTime(rows, time, t_.empty() ? nullptr : &t_.back());
      if (!t_.empty() && t == t_.back()) continue;
      t_.push_back(t);
      force_.emplace_back(rows.Number(*columns[0], kLargestForce),
                          rows.Number(*columns[1], kLargestForce),
                          rows.Number(*columns[2], kLargestForce));
    }
    if (t_.empty()) rows.Fail("no samples: accepted is a header and one row or more");
    TakeOffset();
  }

  // Linear between samples [N]; nullopt before the first, behind the last, and in gaps of more than
  // a tenth of a second.
  [[nodiscard]] std::optional<Eigen::Vector3d> At(double t) const {
    const auto after = std::ranges::lower_bound(t_, t);
    if (after == t_.end()) return std::nullopt;
    const auto i = static_cast<std::size_t>(after - t_.begin());
    if (*after == t) return force_[i];
    if (i == 0 || t_[i] - t_[i - 1] > kLargestForceGap) return std::nullopt;
    const double share = (t - t_[i - 1]) / (t_[i] - t_[i - 1]);
    return (1 - share) * force_[i - 1] + share * force_[i];
  }

 private:
  void TakeOffset() {
    Eigen::Vector3d sum(0, 0, 0);
    std::size_t count = 0;
    for (; count < t_.size() && t_[count] - t_.front() < kOffsetTime; ++count) sum += force_[count];
    const Eigen::Vector3d offset = sum / static_cast<double>(count);
    for (Eigen::Vector3d& f : force_) f -= offset;
  }

  std::vector<double> t_;  // [s], rising
  std::vector<Eigen::Vector3d> force_;
};

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
                             " samples: too few for a baseline from the first " +
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
