// An outline from a file of points.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include <Eigen/Core>

namespace palpate {

// Points of an outline at most: the largest number of elements of a model.
inline constexpr std::size_t kMaxOutlinePoints = 4000;

// Reads the columns x and y [m, or the unit in their titles] of a table by name, or the two of one
// without a header; empty rows and # comments are ignored.
// Throws std::invalid_argument as `file:line: row: expected ...`: unreadable, larger than 1 MiB,
// a row that is not numbers, fewer than 3 or more than 4000 points.
std::vector<Eigen::Vector2d> ReadContourFile(const std::filesystem::path& file);

}  // namespace palpate
