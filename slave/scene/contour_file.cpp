#include "slave/scene/contour_file.h"

#include <cstddef>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

#include "slave/scene/units.h"

namespace palpate {
namespace {

constexpr std::uintmax_t kLargestFile = 1 << 20;  // [bytes]
constexpr std::size_t kMostPoints = 4000;         // as many elements a model may have
constexpr std::size_t kLongestQuote = 60;

std::optional<Eigen::Vector2d> ParseRow(std::string_view row) {
  const auto comma = row.find(',');
  if (comma == std::string_view::npos) return std::nullopt;
  const std::string_view rest = row.substr(comma + 1);
  const auto x = ParseNumber(row.substr(0, comma));
  const auto y = ParseNumber(rest.substr(0, rest.find(',')));
  if (!x || !y) return std::nullopt;
  return Eigen::Vector2d(*x, *y);
}

}  // namespace

std::vector<Eigen::Vector2d> ReadContourFile(const std::filesystem::path& file) {
  const auto refuse = [&](const std::string& where, const std::string& what) {
    throw std::invalid_argument(file.string() + where + ": " + what);
  };
  std::error_code error;
  const bool is_file = std::filesystem::is_regular_file(file, error);
  std::ifstream stream(file);
  if (!is_file || !stream) refuse("", "cannot be read: accepted is a CSV file of x,y");
  if (std::filesystem::file_size(file, error) > kLargestFile) {
    refuse("", "too large: accepted is at most 1 MiB");
  }
  std::vector<Eigen::Vector2d> points;
  std::string row;
  for (int line = 1; std::getline(stream, row); ++line) {
    if (row.find_first_not_of(" \t\r") == std::string::npos) continue;
    if (const auto point = ParseRow(row)) {
      points.push_back(*point);
    } else if (line > 1) {
      refuse(std::string(":").append(std::to_string(line)),
             row.substr(0, kLongestQuote) + ": accepted is two numbers x,y [m]");
    }
  }
  if (points.size() < 3 || points.size() > kMostPoints) {
    refuse("", std::to_string(points.size()) + " points: accepted is 3 to 4000");
  }
  return points;
}

}  // namespace palpate
