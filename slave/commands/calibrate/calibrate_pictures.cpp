#include "slave/commands/calibrate/calibrate_pictures.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <stdexcept>

#include <fmt/format.h>

#include "slave/capture/picture_files.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

// Most frequent; the larger among equals.
std::array<int, 2> MostFrequent(const std::vector<std::array<int, 2>>& sizes) {
  std::map<std::array<int, 2>, int> counts;
  for (const auto& size : sizes) ++counts[size];
  const auto most =
      std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) {
        return a.second != b.second ? a.second < b.second : a.first < b.first;
      });
  return most == counts.end() ? std::array<int, 2>{0, 0} : most->first;
}

// What the user may have meant: squares instead of inner corners, one fewer of either, columns for
// rows, or another pattern.
std::string OtherBoard(const cv::Mat& grey, const Board& board) {
  const auto is_seen = [&](const Board& other) {
    return other.columns >= 3 && other.rows >= 3 && FindBoard(grey, other).has_value();
  };
  for (const auto& [columns, rows] : {std::pair{1, 1}, {1, 0}, {0, 1}, {-1, -1}}) {
    Board other = board;
    other.columns -= columns, other.rows -= rows;
    if (board.pattern == Board::Pattern::kChessboard && is_seen(other)) {
      return fmt::format("; {}x{} was found: --board counts inner corners, not squares",
                         other.columns, other.rows);
    }
  }
  for (const auto pattern : {Board::Pattern::kChessboard, Board::Pattern::kCircles,
                             Board::Pattern::kAsymmetricCircles}) {
    for (const bool is_transposed : {false, true}) {
      Board other = board;
      other.pattern = pattern;
      if (is_transposed) std::swap(other.columns, other.rows);
      if (pattern == board.pattern && !is_transposed) continue;
      if (is_seen(other)) {
        return fmt::format("; --pattern {} --board {}x{} was found",
                           kPatternNames[static_cast<std::size_t>(pattern)], other.columns,
                           other.rows);
      }
    }
  }
  return "";
}

// Number -> index; empty where a picture's name has none or two share one. An unreadable file takes
// part if its number is its own: a damaged picture, not a file that a wide glob names by chance.
std::map<std::string, std::size_t> Numbered(const BoardPictures& side) {
  std::map<std::string, std::size_t> numbers;
  for (const bool is_readable : {true, false}) {
    for (std::size_t i = 0; i < side.pictures.size(); ++i) {
      if (side.pictures[i].is_readable != is_readable) continue;
      const std::string number = LastNumber(side.pictures[i].name);
      const bool is_own = !number.empty() && numbers.emplace(number, i).second;
      if (is_readable && !is_own) return {};
    }
  }
  return numbers;
}

std::vector<std::size_t> Readable(const BoardPictures& side) {
  std::vector<std::size_t> readable;
  for (std::size_t i = 0; i < side.pictures.size(); ++i) {
    if (side.pictures[i].is_readable) readable.push_back(i);
  }
  return readable;
}

}  // namespace

std::vector<std::filesystem::path> ListedPictures(const std::string& option,
                                                  const std::string& pattern) {
  try {
    return ListPictures(pattern, fs::current_path());
  } catch (const std::runtime_error& error) {
    throw std::invalid_argument(option + " " + error.what());
  }
}

BoardPictures FindBoards(const std::string& option, const std::string& pattern, const Board& board,
                         ProgressBar* bar) {
  const std::vector<fs::path> files = ListedPictures(option, pattern);
  BoardPictures out;
  std::vector<std::array<int, 2>> sizes;
  std::vector<std::array<int, 2>> read;
  cv::Mat first;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (!bar->Report("boards of " + option,
                     static_cast<double>(i) / static_cast<double>(files.size()))) {
      throw std::runtime_error("stopped before completion");
    }
    BoardPicture picture;
    picture.name = files[i].filename().string();
    std::array<int, 2> size{0, 0};
    try {
      const cv::Mat grey = BoardGrey(ReadPicture(files[i], i + 1));
      size = {grey.cols, grey.rows};
      read.push_back(size);
      picture.corners = FindBoard(grey, board);
      if (!picture.corners) picture.why_not = "the board is not completely visible";
      if (first.empty()) first = grey;
    } catch (const std::runtime_error& error) {
      picture.why_not = error.what();
      picture.is_readable = false;
    }
    sizes.push_back(size);
    out.pictures.push_back(std::move(picture));
  }
  out.size = MostFrequent(read);
  bool any = false;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    if (out.pictures[i].corners && sizes[i] != out.size) {
      out.pictures[i].corners.reset();
      out.pictures[i].why_not = fmt::format("its size is {} x {}, that of most images {} x {}",
                                            sizes[i][0], sizes[i][1], out.size[0], out.size[1]);
    }
    any = any || out.pictures[i].corners.has_value();
  }
  if (!any) {
    throw std::runtime_error(fmt::format(
        "{} {}: none of {} images shows a board of {}x{}{}{}", option, pattern, out.pictures.size(),
        board.columns, board.rows, first.empty() ? ": " + out.pictures.front().why_not : "",
        first.empty() ? "" : OtherBoard(first, board)));
  }
  return out;
}

std::vector<std::pair<std::size_t, std::size_t>> MatchPictures(const BoardPictures& left,
                                                               const BoardPictures& right) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  const auto of_left = Numbered(left), of_right = Numbered(right);
  for (const auto& [number, i] : of_left) {
    const auto twin = of_right.find(number);
    if (twin != of_right.end()) pairs.emplace_back(i, twin->second);
  }
  std::sort(pairs.begin(), pairs.end());
  if (!pairs.empty()) return pairs;
  if (left.pictures.size() == right.pictures.size()) {
    for (std::size_t i = 0; i < left.pictures.size(); ++i) pairs.emplace_back(i, i);
    return pairs;
  }
  const auto lefts = Readable(left), rights = Readable(right);
  if (lefts.size() != rights.size()) {
    throw std::invalid_argument(
        fmt::format("--left matches {} images, --right {}, and their names have no numbers to pair "
                    "them by: expected the same count of both, or numbered names",
                    lefts.size(), rights.size()));
  }
  for (std::size_t k = 0; k < lefts.size(); ++k) pairs.emplace_back(lefts[k], rights[k]);
  return pairs;
}

}  // namespace palpate
