// The pictures `calibrate` is given: the board in each, and which belong together.
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

// Reads and searches every picture; what cannot be read, has another size than most, or shows no
// board stays with its reason. Throws std::invalid_argument where the pattern names nothing, and
// std::runtime_error where no picture shows the board (with the count that would) or on a stop.
BoardPictures FindBoards(const std::string& option, const std::string& pattern, const Board& board,
                         ProgressBar* bar);

// Indices of pictures that belong together: by the last number of their names where these have some
// in common, else by order. Unreadable files whose names do not tell are left without a partner.
// Throws std::invalid_argument where neither tells.
std::vector<std::pair<std::size_t, std::size_t>> MatchPictures(const BoardPictures& left,
                                                               const BoardPictures& right);

// The files of a pattern, glob or folder from the working directory. Throws std::invalid_argument
// that begins with `option`.
std::vector<std::filesystem::path> ListedPictures(const std::string& option,
                                                  const std::string& pattern);

}  // namespace palpate
