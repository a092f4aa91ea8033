// Point clouds in files (PCD).
#pragma once

#include <cstddef>
#include <filesystem>

#include "slave/study/clouds/point_cloud.h"

namespace palpate::study {

struct PcdCloud {
  PointCloud::Ptr cloud;
  std::size_t dropped = 0;  // points without a finite position, or farther away than 500 m
};

// Reads fields x, y, z and, if they are there, rgb or rgba and label. Throws std::invalid_argument,
// which names the file: unreadable, no PCD file, cut off, x, y or z missing, a field of another
// type, no finite point, or more than half of the points farther away than 20 m.
PcdCloud ReadPcd(const std::filesystem::path& file);

// Binary. False: cannot be written.
bool WritePcd(const std::filesystem::path& file, const PointCloud& cloud);

}  // namespace palpate::study
