#include "slave/capture/tactile_recording.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "shared/text/csv.h"

namespace palpate {
namespace {

constexpr double kMaxPosition = 10;      // [m]; beyond, these are millimetres
constexpr double kUnitTolerance = 0.01;  // of a quaternion's norm

constexpr std::array kPoseNames{"x", "y", "z", "qw", "qx", "qy", "qz"};
using PoseColumns = std::array<std::size_t, kPoseNames.size()>;

// Columns of one finger in the file.
struct FingerColumns {
  std::string prefix;  // of its columns: empty, or `rf_`
  std::vector<std::size_t> channels;
  std::optional<std::size_t> pac, pdc;
  std::optional<PoseColumns> pose;
};

// The number of `E7`, `ele7` or `c7`, 1 or more; 0: no channel.
int ChannelNumber(std::string_view name, const TactileChannels& channels) {
  const bool are_electrodes = channels.are_electrodes();
  if (are_electrodes && name.starts_with("ele")) {
    name.remove_prefix(3);
  } else if (name.starts_with(are_electrodes ? 'E' : 'c')) {
    name.remove_prefix(1);
  } else {
    return 0;
  }
  if (!are_electrodes) name = name.substr(0, name.find(' '));
  if (name.empty() || name.size() > 3 || name.front() == '0') return 0;
  int number = 0;
  for (const char c : name) {
    if (c < '0' || c > '9') return 0;
    number = 10 * number + (c - '0');
  }
  return number;
}

// The prefixes of all columns that name a channel, in the file's order.
std::vector<std::string> PrefixesIn(const CsvTable& rows, const TactileChannels& channels) {
  std::vector<std::string> prefixes;
  for (const std::string& name : rows.header()) {
    const std::size_t begin = name.rfind('_') + 1;  // 0 where there is none
    if (ChannelNumber(std::string_view(name).substr(begin), channels) == 0) continue;
    const std::string prefix = name.substr(0, begin);
    if (std::ranges::find(prefixes, prefix) == prefixes.end()) prefixes.push_back(prefix);
  }
  return prefixes;
}

std::string NameOf(std::string_view prefix) {
  return std::string(prefix.substr(0, prefix.size() - (prefix.empty() ? 0 : 1)));
}

// Chooses the prefixes of the `wanted` fingers. A file of one finger without a name serves every
// wanted finger.
std::vector<std::string> ChoosePrefixes(const CsvTable& rows, std::span<const std::string> wanted,
                                        const TactileChannels& channels) {
  auto prefixes = PrefixesIn(rows, channels);
  if (prefixes.empty()) {
    rows.Fail((channels.are_electrodes() ? "no electrodes: expected columns "
                                         : "no channels: expected columns ") +
              channels.Names() + " or NAME_" + channels.NameOf(0) + " to NAME_" +
              channels.NameOf(channels.count - 1));
  }
  if (wanted.empty()) return prefixes;
  if (wanted.size() == 1 && prefixes.size() == 1 && prefixes[0].empty()) return prefixes;
  std::vector<std::string> chosen;
  for (const std::string& name : wanted) {
    chosen.push_back(name.empty() ? name : name + "_");
    if (std::ranges::find(prefixes, chosen.back()) != prefixes.end()) continue;
    std::string there;
    for (const auto& prefix : prefixes) {
      there +=
          (there.empty() ? "" : ", ") + (prefix.empty() ? "one without a name" : NameOf(prefix));
    }
    rows.Fail("finger = " + name + ": expected a finger of this recording: " + there);
  }
  return chosen;
}

// The columns of the finger's pose; nullopt: it has none.
std::optional<PoseColumns> FindPose(const CsvTable& rows, const std::string& prefix) {
  if (!rows.Find(prefix + "qw")) return std::nullopt;
  PoseColumns columns{};
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto found = rows.Find(prefix + kPoseNames[i]);
    if (!found) {
      rows.Fail("column " + prefix + kPoseNames[i] + " is missing: expected x, y, z, qw, qx, qy, " +
                "qz of the pose");
    }
    columns[i] = *found;
  }
  return columns;
}

Eigen::Isometry3d ReadPose(const CsvTable& rows, const PoseColumns& columns) {
  std::array<double, kPoseNames.size()> v{};
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = rows.Number(columns[i]);
  if (const double far = Eigen::Vector3d(v[0], v[1], v[2]).cwiseAbs().maxCoeff();
      far > kMaxPosition) {
    rows.Fail(
        fmt::format("x,y,z is {:.6g} m from the origin: expected up to {:g} m", far, kMaxPosition));
  }
  const Eigen::Quaterniond q_SF(v[3], v[4], v[5], v[6]);
  if (!(std::abs(q_SF.norm() - 1) <= kUnitTolerance)) {
    rows.Fail("qw,qx,qy,qz of length " + std::to_string(q_SF.norm()) +
              ": expected a unit quaternion");
  }
  Eigen::Isometry3d X_SF = Eigen::Isometry3d::Identity();
  X_SF.translate(Eigen::Vector3d(v[0], v[1], v[2])).rotate(q_SF.normalized());
  return X_SF;
}

FingerColumns FindFinger(const CsvTable& rows, const std::string& prefix,
                         const TactileChannels& channels) {
  FingerColumns columns;
  columns.prefix = prefix;
  columns.pose = FindPose(rows, prefix);
  const auto find = [&](int channel) {
    const std::string name = prefix + channels.NameOf(channel);
    if (!channels.are_electrodes()) {
      const auto column = rows.Find(name);
      return column ? column : rows.Find(name + " [" + channels.unit + "]");
    }
    const auto column = rows.Find(name);
    return column ? column : rows.Find(prefix + "ele" + std::to_string(channel + 1));
  };
  const std::string before = prefix + (channels.are_electrodes() ? "E0" : "c0");
  if (rows.Has(before)) {
    rows.Fail("column " + before + ": channels are counted from 1: expected " + prefix +
              channels.NameOf(0));
  }
  const std::string all =
      prefix + channels.NameOf(0) + " to " + prefix + channels.NameOf(channels.count - 1);
  const std::string kind = channels.are_electrodes() ? "electrode " : "channel ";
  for (int i = 0; i < channels.count; ++i) {
    const auto column = find(i);
    if (!column) {
      rows.Fail(kind + prefix + channels.NameOf(i) + " is missing: expected " + all);
    }
    columns.channels.push_back(*column);
  }
  if (find(channels.count)) {
    rows.Fail(kind + prefix + channels.NameOf(channels.count) + ": expected " + all);
  }
  if (!channels.are_electrodes()) return columns;
  columns.pac = rows.Find(prefix + "pac0");
  // With electrodes named `ele1` the first pac is `pac1`; with `E1` this is the second one.
  if (!columns.pac && rows.Find(prefix + "ele1")) columns.pac = rows.Find(prefix + "pac1");
  columns.pdc = rows.Find(prefix + "pdc");
  return columns;
}

// A recording in another unit would give another force. Throws std::runtime_error `file:line: ...`.
void RequireUnit(const std::filesystem::path& file, const TactileChannels& channels) {
  if (channels.are_electrodes()) return;
  CsvLines lines(file);
  if (!lines.Next()) return;
  for (const std::string_view title : lines.cells()) {
    const std::size_t open = title.find_first_of("[(");
    if (open == std::string_view::npos || !(title.ends_with(']') || title.ends_with(')'))) continue;
    const std::string_view name = Trimmed(title.substr(0, open));
    if (ChannelNumber(name.substr(name.rfind('_') + 1), channels) == 0) continue;
    if (title.substr(open + 1, title.size() - open - 2) == channels.unit) continue;
    lines.Fail("column " + Shown(title) + ": expected " + Shown(name) + " [" + channels.unit +
               "], the unit of the scene");
  }
}

std::vector<FingerColumns> FindFingers(const CsvTable& rows, std::span<const std::string> wanted,
                                       const TactileChannels& channels) {
  std::vector<FingerColumns> fingers;
  for (const std::string& prefix : ChoosePrefixes(rows, wanted, channels)) {
    fingers.push_back(FindFinger(rows, prefix, channels));
  }
  return fingers;
}

RecordedFinger Described(const FingerColumns& columns) {
  return {NameOf(columns.prefix), columns.pac.has_value(), columns.pdc.has_value(), {}};
}

FingerReading ReadSample(const CsvTable& rows, const FingerColumns& columns) {
  const auto counts = [&](std::size_t column) {  // in the file's unit
    return static_cast<float>(rows.Number(column, kMaxCounts) / rows.to_si(column));
  };
  FingerReading reading;
  reading.present = true;
  reading.channels.resize(columns.channels.size());
  for (std::size_t i = 0; i < columns.channels.size(); ++i) {
    reading.channels[i] = counts(columns.channels[i]);
  }
  if (columns.pac) reading.pac = counts(*columns.pac);
  if (columns.pdc) reading.pdc = counts(*columns.pdc);
  if (columns.pose) reading.X_SF = ReadPose(rows, *columns.pose);
  return reading;
}

constexpr std::array kNames{"rel_time_s", "time_s", "t_s", "t", "time", "timestamp"};
constexpr double kLatest = 9e9;  // the year 2255; times in milliseconds are larger

}  // namespace

std::string RecordedFinger::MissingColumn() const {
  if (has_pac && has_pdc) return {};
  return (name.empty() ? "" : name + "_") + (has_pac ? "pdc" : "pac0");
}

std::vector<RecordedFinger> ReadTactileFingers(const std::filesystem::path& file,
                                               std::span<const std::string> wanted,
                                               const TactileChannels& channels) {
  const CsvTable rows(file);
  std::vector<RecordedFinger> fingers;
  for (const FingerColumns& columns : FindFingers(rows, wanted, channels)) {
    fingers.push_back(Described(columns));
  }
  return fingers;
}

TactileRecording ReadTactileRecording(const std::filesystem::path& file,
                                      std::span<const std::string> wanted,
                                      const TactileChannels& channels) {
  RequireUnit(file, channels);
  CsvTable rows(file);
  const std::size_t time = FindTimeColumn(rows);
  TactileRecording recording;
  const std::vector<FingerColumns> fingers = FindFingers(rows, wanted, channels);
  for (const FingerColumns& columns : fingers) recording.fingers.push_back(Described(columns));
  while (rows.Next()) {
    const double t = ReadTime(rows, time, recording.t.empty() ? nullptr : &recording.t.back());
    recording.t.push_back(t);
    for (std::size_t i = 0; i < fingers.size(); ++i) {
      recording.fingers[i].samples.push_back(ReadSample(rows, fingers[i]));
    }
  }
  if (recording.t.empty()) rows.Fail("no samples: expected a header and one row or more");
  return recording;
}

std::size_t FindTimeColumn(const CsvTable& rows) {
  for (const char* name : kNames) {
    if (const auto column = rows.Find(name)) return *column;
  }
  rows.Fail("no time: expected a column rel_time_s, time_s, t_s, t, time or timestamp [s]");
}

double ReadTime(const CsvTable& rows, std::size_t column, const double* before) {
  const auto number = ParseFinite(rows.Text(column));
  const double t = number ? rows.to_si(column) * *number : 0;
  if (!number || std::abs(t) > kLatest)
    rows.Refuse(column, "a time in seconds, or its unit in the header, as in t (ns)");
  if (before != nullptr && t <= *before) {
    rows.Refuse(column, "a time that increases from row to row, after " + std::to_string(*before));
  }
  return t;
}

}  // namespace palpate
