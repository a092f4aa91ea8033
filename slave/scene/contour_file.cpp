#include "slave/scene/contour_file.h"

#include <cstddef>
#include <stdexcept>
#include <string>
#include <system_error>

#include "shared/text/csv.h"

namespace palpate {
namespace {

std::vector<Eigen::Vector2d> ReadPoints(const std::filesystem::path& file) {
  std::vector<Eigen::Vector2d> points;
  CsvTable table(file, {{"x", true, Quantity::kLength}, {"y", true, Quantity::kLength}},
                 CsvTable::Header::kOptional);
  while (table.Next()) points.emplace_back(table.Number("x"), table.Number("y"));
  return points;
}

}  // namespace

std::vector<Eigen::Vector2d> ReadContourFile(const std::filesystem::path& file) {
  constexpr std::uintmax_t kMaxContourFile = 1 << 20;  // [bytes]
  const auto refuse = [&](const std::string& what) {
    throw std::invalid_argument(file.string() + ": " + what);
  };
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    refuse("cannot be read: expected a CSV file of x,y");
  }
  if (std::filesystem::file_size(file, error) > kMaxContourFile) {
    refuse("too large: expected at most 1 MiB");
  }
  std::vector<Eigen::Vector2d> points;
  try {
    points = ReadPoints(file);
  } catch (const InputError& wrong) {
    throw std::invalid_argument(wrong.what());
  }
  if (points.size() < 3 || points.size() > kMaxOutlinePoints) {
    refuse(std::to_string(points.size()) + " points: expected 3 to 4000");
  }
  return points;
}

}  // namespace palpate
