// Values of the checks in the last sample, besides the code of a failed check. Absent: the sensor
// has no such check, or it was not possible in this sample.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace palpate {

struct CheckDetails {
  std::optional<double> score;  // similarity of the tip to its template: correlation, -1 to 1
  std::optional<double>
      registration;  // measured rest surface at the start against the scene's, rms [px]
  std::optional<double>
      contour;  // measured edge against computed outline and indentation, rms [px]
  std::optional<double> epipolar;  // distance of stereo points from their epipolar lines, rms [px]
  std::optional<double> camera_motion;  // motion of camera or rig since the start [px]
  std::optional<double> misfit;      // measured surface against the computed one, rms in sigmas [-]
  std::optional<double> rest_drift;  // drift common to all electrodes since the baseline [counts]
};

// Their names as columns of states.csv, in order, and their values.
inline constexpr std::array<std::string_view, 7> kCheckColumns{
    "score",  "registration_px", "contour_px", "epipolar_px", "camera_motion_px",
    "misfit", "rest_drift"};
constexpr std::array<std::optional<double>, kCheckColumns.size()> ValuesOf(
    const CheckDetails& details) {
  return {details.score,         details.registration, details.contour,   details.epipolar,
          details.camera_motion, details.misfit,       details.rest_drift};
}

}  // namespace palpate
