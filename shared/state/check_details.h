// What a sense's own checks measured in the last sample, beside the one code that says which of
// them failed. Absent: this sense has no such check, or it could not be made in this sample.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace palpate {

struct CheckDetails {
  std::optional<double> score;          // how much the tip looks as it did: correlation, -1 to 1
  std::optional<double> registration;   // rest surface seen at first against the scene's, rms [px]
  std::optional<double> contour;        // edge seen against outline and dent computed, rms [px]
  std::optional<double> epipolar;       // points of two eyes off their epipolar lines, rms [px]
  std::optional<double> camera_motion;  // of camera or rig since the start [px]
  std::optional<double> misfit;         // surface seen against the one computed, rms in sigmas [-]
  std::optional<double> rest_drift;     // of all electrodes together since the rest values [counts]
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
