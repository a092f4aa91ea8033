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

}  // namespace palpate
