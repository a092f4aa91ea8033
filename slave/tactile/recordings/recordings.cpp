#include "slave/tactile/recordings/recordings.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string_view>

namespace palpate {
namespace {

// A number of seconds, or `otherwise` for nothing.
std::optional<double> Seconds(std::string_view text, double otherwise) {
  if (text.empty()) return otherwise;
  double value = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || rest != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

void TakeSlice(std::string_view slice, DataArgument* data) {
  const std::size_t colon = slice.find(':');
  std::optional<double> from, to;
  if (colon != std::string_view::npos) {
    from = Seconds(slice.substr(0, colon), data->from);
    to = Seconds(slice.substr(colon + 1), data->to);
  }
  if (!from || !to || !(*from < *to)) {
    throw std::invalid_argument(data->text + ": @" + std::string(slice) +
                                ": accepted is @FROM:TO in seconds, FROM < TO");
  }
  data->from = *from;
  data->to = *to;
}

constexpr double kRestShare = 0.02, kTopShare = 0.99;  // percentiles of pdc
constexpr double kContactShare = 0.05;                 // of pdc's range
constexpr double kLeastRange = 20;                     // below, pdc does not tell contact [counts]
constexpr double kUnitTolerance = 1e-2;

template <typename Number>
Number Quantile(std::vector<Number> values, double share) {
  const auto at = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(at));
  return values[at];
}

double FindContactPdc(const DataArgument& data, const std::vector<FingerReading>& samples) {
  std::vector<float> pdc;
  for (const FingerReading& s : samples) pdc.push_back(s.pdc);
  const auto rest = static_cast<double>(Quantile(pdc, kRestShare));
  const double range = static_cast<double>(Quantile(pdc, kTopShare)) - rest;
  if (range < kLeastRange) {
    throw std::runtime_error(
        data.tactile.string() + ": pdc varies by " + std::to_string(range) +
        " counts only: no contact, or set the start of contact with --contact-pdc");
  }
  return rest + kContactShare * range;
}

// Medians of the samples without contact, as a reading.
FingerReading RestOf(const DataArgument& data, const std::vector<FingerReading>& samples,
                     double contact_pdc) {
  std::array<std::vector<float>, kSignalCount> values;
  for (const FingerReading& s : samples) {
    if (static_cast<double>(s.pdc) > contact_pdc) continue;
    for (std::size_t i = 0; i < kElectrodeCount; ++i) values[i].push_back(s.electrodes[i]);
    values[kElectrodeCount].push_back(s.pac);
    values[kElectrodeCount + 1].push_back(s.pdc);
  }
  if (values[0].empty()) {
    throw std::runtime_error(data.tactile.string() + ": no sample without contact (pdc <= " +
                             std::to_string(contact_pdc) + "): the baseline is unknown");
  }
  FingerReading rest;
  for (std::size_t i = 0; i < kElectrodeCount; ++i) rest.electrodes[i] = Quantile(values[i], 0.5);
  rest.pac = Quantile(values[kElectrodeCount], 0.5);
  rest.pdc = Quantile(values[kElectrodeCount + 1], 0.5);
  return rest;
}

std::vector<Eigen::Vector3d> NormalsOf(const DataArgument& data,
                                       const TactileRecording& recording) {
  std::array<const std::vector<double>*, 3> columns{};
  const std::array<const char*, 3> names{"nx", "ny", "nz"};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto refused = recording.refused.find(names[i]);
    if (refused != recording.refused.end()) throw std::runtime_error(refused->second);
    const auto column = recording.others.find(names[i]);
    if (column == recording.others.end()) {
      throw std::runtime_error(data.tactile.string() +
                               ": no contact normals: accepted is columns nx, ny, nz of finite "
                               "numbers");
    }
    columns[i] = &column->second;
  }
  std::vector<Eigen::Vector3d> normals;
  for (std::size_t k = 0; k < recording.t.size(); ++k) {
    normals.emplace_back((*columns[0])[k], (*columns[1])[k], (*columns[2])[k]);
  }
  return normals;
}

}  // namespace

DataArgument ParseDataArgument(const std::string& text) {
  DataArgument data;
  data.text = text;
  std::string_view files = text;
  const auto is_file = [](std::string_view name) {
    std::error_code unreadable;
    return std::filesystem::exists(name, unreadable);
  };
  const std::size_t at = files.rfind('@');
  if (at != std::string_view::npos && !is_file(files) &&
      files.find('/', at) == std::string_view::npos) {
    TakeSlice(files.substr(at + 1), &data);
    files = files.substr(0, at);
  }
  std::size_t plus = is_file(files) ? std::string_view::npos : files.find('+');
  // A folder's name may contain the sign too: the tactile file is the longest that exists.
  for (std::size_t next = plus; next != std::string_view::npos; next = files.find('+', next + 1)) {
    if (is_file(files.substr(0, next))) plus = next;
  }
  data.tactile = files.substr(0, plus);
  if (plus != std::string_view::npos) data.wrench = files.substr(plus + 1);
  if (data.tactile.empty() || (plus != std::string_view::npos && data.wrench.empty())) {
    throw std::invalid_argument(text +
                                ": accepted is TACTILE.csv, TACTILE.csv+WRENCH.csv, either with "
                                "@FROM:TO, or simulated");
  }
  return data;
}

TactileRecording ReadRecordedFinger(const DataArgument& data, const std::string& finger) {
  const std::vector<std::string> wanted(finger.empty() ? 0 : 1, finger);
  TactileRecording recording = ReadTactileRecording(data.tactile, wanted);
  if (recording.fingers.size() == 1) return recording;
  std::string names;
  for (const RecordedFinger& f : recording.fingers) names += (names.empty() ? "" : ", ") + f.name;
  throw std::runtime_error(data.tactile.string() +
                           ": several fingers: choose one with --finger: " + names);
}

ContactNormals ReadContactNormals(const DataArgument& data, const std::string& finger,
                                  std::optional<double> contact_pdc) {
  const TactileRecording recording = ReadRecordedFinger(data, finger);
  const RecordedFinger& recorded = recording.fingers[0];
  if (!recorded.has_pdc) {
    throw std::runtime_error(data.tactile.string() +
                             ": no column pdc, which is needed to detect contact");
  }
  const std::vector<Eigen::Vector3d> normals = NormalsOf(data, recording);
  ContactNormals contact;
  contact.contact_pdc = contact_pdc ? *contact_pdc : FindContactPdc(data, recorded.samples);
  RestValues rest(1);
  rest.Take(RestOf(data, recorded.samples, contact.contact_pdc));
  for (std::size_t k = 0; k < recording.t.size(); ++k) {
    const bool wanted = recording.t[k] >= data.from && recording.t[k] < data.to;
    if (!wanted || !(static_cast<double>(recorded.samples[k].pdc) > contact.contact_pdc)) continue;
    if (!(std::abs(normals[k].norm() - 1) < kUnitTolerance)) {
      throw std::runtime_error(data.tactile.string() + ": at " + std::to_string(recording.t[k]) +
                               " s: nx, ny, nz of length " + std::to_string(normals[k].norm()) +
                               ": accepted is 1");
    }
    contact.change.push_back(rest.Change(recorded.samples[k]));
    contact.normals.push_back(normals[k].normalized());
  }
  return contact;
}

}  // namespace palpate
