// The input images of `calibrate`: detection of the board in each, and pairing.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "slave/commands/progress_bar.h"
#include "slave/vision/calibration/board.h"

namespace palpate {

struct BoardImage {
  std::string name;  // of the file
  std::optional<Corners> corners;
  std::string why_not;  // why there are no corners
};

struct DetectedBoards {
  std::vector<BoardImage> images;  // in the order of the glob
  std::array<int, 2> size{};       // of the first one that shows the board [px]
};

// Reads and searches every image. An image that is unreadable, has another size than the first
// board's, or shows no board keeps the reason. Throws std::invalid_argument if the pattern matches
// nothing, and std::runtime_error if no image shows the board or on a stop.
DetectedBoards FindBoards(const std::string& option, const std::string& pattern, const Board& board,
                          ProgressBar* bar);

// Indices of images that form pairs: by the last number of their names, or by order where names
// have none or share one. Throws std::invalid_argument if neither defines pairs.
std::vector<std::pair<std::size_t, std::size_t>> MatchImages(const DetectedBoards& left,
                                                             const DetectedBoards& right);

// The files of a pattern, glob or folder from the working directory. Throws std::invalid_argument
// that begins with `option`.
std::vector<std::filesystem::path> ListedImages(const std::string& option,
                                                const std::string& pattern);

}  // namespace palpate
