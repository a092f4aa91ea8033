// Points as a depth camera measures them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace palpate::study {

// Every point is finite; `colours` and `labels` have one entry per point, or none at all.
struct PointCloud {
  std::vector<Eigen::Vector3d> points;               // [m], in whose frame the user of it says
  std::vector<std::array<std::uint8_t, 3>> colours;  // red, green, blue
  std::vector<std::uint32_t> labels;                 // which object a point is said to belong to

  [[nodiscard]] std::size_t size() const { return points.size(); }
};

}  // namespace palpate::study
