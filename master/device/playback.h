// Recorded motion: positions from a CSV file, played in real time.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "master/device/haptic_device.h"

namespace palpate {

class Playback final : public HapticDevice {
 public:
  // Reads a CSV file with a header row and the columns `time_s` [s], `x`, `y`, `z` [m, frame M], in
  // any order; other columns are ignored. Accepted are two or more rows of finite numbers, strictly
  // rising times and positions within 100 m. Throws std::runtime_error with file:line otherwise.
  explicit Playback(const std::filesystem::path& file);

  [[nodiscard]] bool finished() const noexcept override { return finished_; }
  [[nodiscard]] std::string description() const override;

 protected:
  // Interpolates linearly between rows. The recording starts at the first call, which returns a
  // disengaged reading, so that the next one engages. The reading after the last row is disengaged.
  DeviceReading DoRead(Time now) noexcept override;
  // A force has no effect.
  DeviceOutput DoWrite(const Wrench& /*wrench*/) noexcept override { return DeviceOutput::kOk; }

 private:
  struct Row {
    double t = 0;                // [s]
    Eigen::Vector3d p{0, 0, 0};  // M [m]
  };
  std::filesystem::path file_;
  std::vector<Row> rows_;
  double max_gap_ = 0;  // between rows [s]
  std::optional<Time> start_;
  std::size_t piece_ = 0;  // the row before the current time
  bool finished_ = false;
};

}  // namespace palpate
