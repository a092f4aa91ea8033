// A measured force over time.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "slave/capture/tactile_recording.h"

namespace palpate {

// What a force sensor recorded, its offset taken off: the mean of the first half second.
class ForceCurve {
 public:
  // Columns fx, fy, fz or fx_N, fy_N, fz_N among those of a tactile recording; `file` is for
  // errors. Throws std::runtime_error: there are none, or `file:line: ...` what is no number.
  ForceCurve(const std::filesystem::path& file, const TactileRecording& recording);
  // A file of its own with a time and these columns. Throws std::runtime_error `file:line: ...`.
  explicit ForceCurve(const std::filesystem::path& file);

  // Linear between samples [N]; nullopt before the first, behind the last, and in gaps of more than
  // a tenth of a second.
  [[nodiscard]] std::optional<Eigen::Vector3d> At(double t) const;

 private:
  void TakeOffset();
  std::vector<double> t_;  // [s], rising
  std::vector<Eigen::Vector3d> force_;
};

}  // namespace palpate
