// Point clouds in files: PCD, as cameras' drivers and the Point Cloud Library write them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "slave/study/clouds/point_cloud.h"

namespace palpate::study {

// LZF, the compression of PCD files: a sequence of runs. A control byte below 32 is followed by
// that many and one more literal bytes. Any other gives in its upper three bits the number of
// repeated bytes, and in its lower five and the next byte their distance (seven: one more byte adds
// to the length). nullopt: the stream does not make exactly `size` bytes. Allocates no more than
// `size`.
std::optional<std::string> DecompressLzf(std::string_view stream, std::size_t size);

// The range of depth cameras: larger values are not measurements.
inline constexpr double kFarthestPoint = 500;  // [m]

struct PcdCloud {
  PointCloud cloud;         // in the file's frame, that of the camera: z forward, x right, y down
  std::size_t dropped = 0;  // points without a finite position, or farther away than 500 m
  std::size_t too_far = 0;  // of these, the latter
};

// Reads PCD 0.7 and older: ascii, binary and compressed, with fields x, y, z and, if they are
// there, rgb or rgba and label; a point of an ascii file is a line. Throws std::invalid_argument,
// which names the file and, where there is one, the line: unreadable, no PCD file, cut off, a line
// of too few or too many numbers, x, y or z missing or not floating point.
PcdCloud ReadPcd(const std::filesystem::path& file);

// Writes x, y, z, with colours rgb and with labels label, binary. False: cannot be written.
bool WritePcd(const std::filesystem::path& file, const PointCloud& cloud);

}  // namespace palpate::study
