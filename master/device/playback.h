// A recorded hand: positions from a CSV file, played at true time.
#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <optional>
#include <vector>

#include "master/device/device.h"

namespace palpate {

class Playback final : public Device {
 public:
  // A CSV file with the columns `time_s` [s], `x`, `y`, `z` [m, frame M] named in its first row, in
  // any order; others are ignored. At least two rows, time strictly rising, all finite, positions
  // within 100 m. Throws std::runtime_error with file:line and what is accepted.
  explicit Playback(const std::filesystem::path& file);

  // Linear between rows, the recording beginning with the first call, which still is disengaged:
  // closing the clutch is an act. Velocity is that of the piece. Disengaged after the last row.
  DeviceReading Read(Time now) noexcept override;
  void WriteForce(const Eigen::Vector3d&) noexcept override {}  // a recording feels nothing
  void Guide(const DeviceGuide&) noexcept override {}
  [[nodiscard]] bool finished() const noexcept override { return finished_; }
  [[nodiscard]] std::string description() const override;
  [[nodiscard]] double force_limit() const override {
    return std::numeric_limits<double>::infinity();
  }

 private:
  struct Row {
    double t = 0;                // [s]
    Eigen::Vector3d p{0, 0, 0};  // M [m]
  };
  std::filesystem::path file_;
  std::vector<Row> rows_;
  double longest_gap_ = 0;  // between rows [s]
  std::optional<Time> start_;
  std::size_t piece_ = 0;  // the row before the current time
  bool finished_ = false;
};

}  // namespace palpate
