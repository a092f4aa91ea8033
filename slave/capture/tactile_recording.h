// Tactile recordings: CSV files of raw counts.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "slave/capture/tactile_frame.h"
#include "slave/scene/scene.h"

namespace palpate {

struct RecordedFinger {
  std::string name;  // empty where the file has one finger without a name
  bool has_pac = false, has_pdc = false;
  std::vector<FingerReading> samples;  // one per instant
  // The column pac0 or pdc that the file does not have, `rf_pdc` say; empty: it has both.
  [[nodiscard]] std::string MissingColumn() const;
};
struct TactileRecording {
  std::vector<double> t;  // [s], rising, as in the file
  std::vector<RecordedFinger> fingers;
  std::map<std::string, std::vector<double>> others;  // every other numeric column by its name
  std::map<std::string, std::string>
      refused;  // the others: where they are no numbers, `file:line: ...`
};

// Columns: a time in seconds (`time_s`, `t`, `rel_time_s`, `timestamp`, the first that is there;
// `rel_time_s` before the others), per finger `NAME_E1` to `NAME_E19`, `NAME_pac0`, `NAME_pdc`, or
// without `NAME_` where there is one finger; `ele1` and `pac1` are understood too. A header row;
// lines that begin with # are comments. `wanted`: the fingers to read, empty: all. Throws
// std::runtime_error `file:line: ...`: unreadable, a finger or an electrode missing (which), a row
// with more or fewer columns than the header, not a finite number, a clock that goes back.
TactileRecording ReadTactileRecording(const std::filesystem::path& file,
                                      std::span<const std::string> wanted);

// The fingers that ReadTactileRecording would read, without their samples: the header alone is
// read. Throws as it does.
std::vector<RecordedFinger> ReadTactileFingers(const std::filesystem::path& file,
                                               std::span<const std::string> wanted);

// `recording` at a steady `rate` [Hz], linear between samples; gaps longer than `largest_gap` [s]
// are left out and the instant after one is marked. Linear over O(samples).
std::vector<TactileFrame> Resample(const TactileRecording& recording, double rate,
                                   double largest_gap);

// The recording that the scene names, at the scene's rate (samples within a tenth of a period of it
// are taken as they are, others resampled; a quarter of it is the slowest), with its fingertip
// poses. A finger's first pose counts for three periods before its time and its last one for three
// after it; beyond, the finger has no pose, and whoever feels says so. `paced`: in the pace in
// which it was recorded; otherwise as fast as it is read. Throws std::runtime_error like
// ReadTactileRecording, and where not one pose falls into the recording's time.
std::unique_ptr<TactileSource> OpenTactileRecording(const Scene& scene, bool paced);

}  // namespace palpate
