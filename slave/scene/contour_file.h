// An outline from a file of points.
#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Core>

namespace palpate {

// Reads rows `x,y` [m] of a CSV, after a header row if the first row is not numbers; further
// columns, empty rows and # comments are ignored. Throws std::invalid_argument as
// `file:line: row: accepted is ...`: unreadable, larger than 1 MiB, a row that is not numbers,
// fewer than 3 or more than 4000 points.
std::vector<Eigen::Vector2d> ReadContourFile(const std::filesystem::path& file);

}  // namespace palpate
