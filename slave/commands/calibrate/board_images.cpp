#include "slave/commands/calibrate/board_images.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <stdexcept>

#include <fmt/format.h>

#include "slave/capture/image_files.h"

namespace palpate {
namespace {

// Returns the map from the number in a name to the index. It is empty if an image of the board has
// no number, or two have the same. Other files are included if their number is unique, because they
// may be damaged images.
std::map<std::string, std::size_t> Numbered(const DetectedBoards& side) {
  std::map<std::string, std::size_t> numbers;
  for (const bool has_board : {true, false}) {
    for (std::size_t i = 0; i < side.images.size(); ++i) {
      if (side.images[i].corners.has_value() != has_board) continue;
      const std::string number = LastNumber(side.images[i].name);
      const bool is_own = !number.empty() && numbers.emplace(number, i).second;
      if (has_board && !is_own) return {};
    }
  }
  return numbers;
}

}  // namespace

std::vector<std::filesystem::path> ListedImages(const std::string& option,
                                                const std::string& pattern) {
  try {
    return ListImages(pattern, std::filesystem::current_path());
  } catch (const std::runtime_error& error) {
    throw std::invalid_argument(option + " " + error.what());
  }
}

DetectedBoards FindBoards(const std::string& option, const std::string& pattern, const Board& board,
                          ProgressBar* bar) {
  const std::vector<std::filesystem::path> files = ListedImages(option, pattern);
  DetectedBoards out;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (!bar->Report("boards of " + option,
                     static_cast<double>(i) / static_cast<double>(files.size()))) {
      throw std::runtime_error("stopped before completion");
    }
    BoardImage& image = out.images.emplace_back();
    image.name = files[i].filename().string();
    try {
      const cv::Mat pixels = ReadImage(files[i], i + 1);
      const std::array<int, 2> size{pixels.cols, pixels.rows};
      image.corners = FindBoard(pixels, board);
      if (!image.corners) {
        image.why_not = "the board is not completely visible";
      } else if (out.size[0] == 0) {
        out.size = size;
      } else if (size != out.size) {
        image.corners.reset();
        image.why_not = fmt::format("its size is {} x {}, that of the first board {} x {}", size[0],
                                    size[1], out.size[0], out.size[1]);
      }
    } catch (const std::runtime_error& error) {
      image.why_not = error.what();
    }
  }
  if (out.size[0] > 0) return out;
  throw std::runtime_error(fmt::format(
      "{} {}: none of {} images shows a board of {} x {}: --board counts the inner corners of a "
      "chessboard, one fewer than squares, or circles per row and rows; {}: {}",
      option, pattern, out.images.size(), board.columns, board.rows, out.images.front().name,
      out.images.front().why_not));
}

std::vector<std::pair<std::size_t, std::size_t>> MatchImages(const DetectedBoards& left,
                                                             const DetectedBoards& right) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  const auto of_right = Numbered(right);
  for (const auto& [number, i] : Numbered(left)) {
    const auto twin = of_right.find(number);
    if (twin != of_right.end()) pairs.emplace_back(i, twin->second);
  }
  std::ranges::sort(pairs);
  if (!pairs.empty()) return pairs;
  if (left.images.size() != right.images.size()) {
    throw std::invalid_argument(
        fmt::format("--left matches {} images, --right {}, and their names have no numbers to pair "
                    "them by: expected the same count of both, or numbered names",
                    left.images.size(), right.images.size()));
  }
  for (std::size_t i = 0; i < left.images.size(); ++i) pairs.emplace_back(i, i);
  return pairs;
}

}  // namespace palpate
