// Tactile recordings: CSV files of raw counts.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "slave/capture/tactile_frame.h"
#include "slave/scene/scene.h"

namespace palpate {

struct RecordedFinger {
  std::string name;  // empty where the file has one finger without a name
  bool has_pac = false, has_pdc = false;
  std::vector<FingerReading> samples;  // one per instant
  // The missing column pac0 or pdc, for example `rf_pdc`; empty: none is missing.
  [[nodiscard]] std::string MissingColumn() const;
};
struct TactileRecording {
  std::vector<double> t;  // [s], rising, as in the file
  std::vector<RecordedFinger> fingers;
};

// Columns: a time in seconds (the first of `rel_time_s`, `time_s`, `t_s`, `t`, `timestamp`), per
// finger `NAME_E1` to `NAME_E19`, `NAME_pac0`, `NAME_pdc`, or without `NAME_` for a single finger;
// `ele1` and `pac1` are accepted too. Other sensors: `NAME_c1` to `NAME_cN`; a unit in brackets
// behind the name must be that of `channels`. One header row; lines that begin with # are comments.
// `wanted`: the fingers to read, empty: all. Throws std::runtime_error `file:line: ...`:
// unreadable, a finger or a channel missing or beyond the last (which), a row with more or fewer
// columns than the header, not a finite number, a time that does not increase.
TactileRecording ReadTactileRecording(const std::filesystem::path& file,
                                      std::span<const std::string> wanted,
                                      const TactileChannels& channels = {});

// The fingers that ReadTactileRecording would read; only the header is read. Throws as it does.
std::vector<RecordedFinger> ReadTactileFingers(const std::filesystem::path& file,
                                               std::span<const std::string> wanted,
                                               const TactileChannels& channels = {});

// The recording of the scene. A rate within a tenth of the scene's is taken as it is, another one
// down to a quarter is resampled, linear between samples. The first frame behind more than three
// periods without a sample is marked. `paced`: at the recorded rate; otherwise as fast as it is
// read. Throws std::runtime_error like ReadTactileRecording.
std::unique_ptr<TactileSource> OpenTactileRecording(const Scene& scene, bool paced);

// `share` of the way from one reading to another, 0 to 1; a pose where both have one, linear in
// place and spherically linear in rotation.
FingerReading Between(const FingerReading& from, const FingerReading& to, double share) noexcept;
}  // namespace palpate
