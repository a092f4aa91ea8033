// The input images of `calibrate`: detection of the board in each, and pairing.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "slave/commands/progress_bar.h"
#include "slave/vision/calibration/lens_calibration.h"

namespace palpate {

// In the order of Board::Pattern.
inline constexpr std::array<std::string_view, 3> kPatternNames{"chessboard", "circles",
                                                               "asymmetric-circles"};

struct BoardPicture {
  std::string name;  // of the file
  std::optional<Corners> corners;
  std::string why_not;  // where there are none
  bool is_readable = true;
};

struct BoardPictures {
  std::vector<BoardPicture> pictures;  // in the order of the glob
  std::array<int, 2> size{};           // of most of them [px]
};

// Reads and searches every image. An image that is unreadable, has another size than most, or shows
// no board keeps the reason. Throws std::invalid_argument if the pattern matches nothing, and
// std::runtime_error if no image shows the board (with the count of corners that would fit) or on a
// stop.
BoardPictures FindBoards(const std::string& option, const std::string& pattern, const Board& board,
                         ProgressBar* bar);

// Indices of images that form pairs: by the last number of their names if some numbers match,
// otherwise by order. Unreadable files without a usable name have no partner. Throws
// std::invalid_argument if neither names nor order define pairs.
std::vector<std::pair<std::size_t, std::size_t>> MatchPictures(const BoardPictures& left,
                                                               const BoardPictures& right);

// The files of a pattern, glob or folder from the working directory. Throws std::invalid_argument
// that begins with `option`.
std::vector<std::filesystem::path> ListedPictures(const std::string& option,
                                                  const std::string& pattern);

}  // namespace palpate
