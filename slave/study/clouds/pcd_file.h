// Point clouds in files: PCD, read and written by the Point Cloud Library.
#pragma once

#include <cstddef>
#include <filesystem>

#include "slave/study/clouds/point_cloud.h"

namespace palpate::study {

// The range of depth cameras: larger values are not measurements.
inline constexpr double kFarthestPoint = 500;  // [m]

struct PcdCloud {
  PointCloud cloud;         // in the file's frame, that of the camera: z forward, x right, y down
  std::size_t dropped = 0;  // points without a finite position, or farther away than 500 m
  std::size_t too_far = 0;  // of these, the latter
};

// Reads PCD 0.7 and older: ascii, binary and compressed, with fields x, y, z and, if they are
// there, rgb or rgba and label. Throws std::invalid_argument, which names the file: unreadable, no
// PCD file, cut off, x, y or z missing or not floating point.
PcdCloud ReadPcd(const std::filesystem::path& file);

// Writes x, y, z, with colours rgb and with labels label, binary. False: cannot be written.
bool WritePcd(const std::filesystem::path& file, const PointCloud& cloud);

}  // namespace palpate::study
