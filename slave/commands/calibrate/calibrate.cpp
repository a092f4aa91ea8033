#include "slave/commands/calibrate/calibrate.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <stdexcept>

#include <fmt/format.h>

#include "shared/text/text.h"
#include "slave/commands/calibrate/board_images.h"
#include "slave/commands/calibrate/calibrate_board.h"
#include "slave/scene/units.h"

namespace palpate {
namespace {

double Length(const char* option, const std::string& text, double most) {
  const auto length = ParseQuantity(text, Dimension::kLength);
  if (!length || !(*length >= 1e-6 && *length <= most)) {
    const std::string range = fmt::format("1 um to {:g} m", most);
    throw std::invalid_argument(fmt::format("{} {}: expected {}", option, text,
                                            ExpectedQuantity(Dimension::kLength, range)));
  }
  return *length;
}

Board BoardOf(const CalibrateOptions& options) {
  if (options.board.empty() || options.square.empty()) {
    throw std::invalid_argument(
        "--left: needs --board, for example 9x6, and --square, for example 25mm");
  }
  Board board;
  if (options.pattern == "circles") {
    board.pattern = Board::Pattern::kCircles;
  } else if (options.pattern == "asymmetric-circles") {
    board.pattern = Board::Pattern::kAsymmetricCircles;
  } else if (options.pattern != "chessboard") {
    throw std::invalid_argument("--pattern " + options.pattern +
                                ": expected chessboard, circles or asymmetric-circles");
  }
  const auto counts = TwoCounts("--board", options.board, 3, 100, "9x6");
  board.columns = counts[0], board.rows = counts[1];
  board.square = Length("--square", options.square, 1);
  return board;
}

void RequireUsable(const CalibrateOptions& options) {
  const auto require = [](bool usable, const char* words) {
    if (!usable) throw std::invalid_argument(words);
  };
  if (!options.unquoted.empty()) {
    throw std::invalid_argument(options.unquoted.front() +
                                ": expected options only; put the patterns of --left and "
                                "--right in quotes, otherwise the shell expands them");
  }
  const bool has_left = !options.left.empty(), registers = !options.tip_places.empty();
  require(has_left || registers, "calibrate: expected --left, --register, or both");
  require(
      has_left || (options.right.empty() && options.distance.empty() && options.corners.empty()),
      "--right, --distance, --corners: only with --left");
  require(!has_left || !options.out.empty(), "--left: needs --out, the file to write");
  require(!has_left || (options.rig.empty() && options.size.empty()),
          "--rig, --size: only without --left, which computes a rig");
  require(options.rig.empty() || options.size.empty(),
          "--size: only without --rig, which has a size");
  require(registers || (options.rig.empty() && options.size.empty() && !options.plane),
          "--rig, --size, --plane: only with --register");
  if (has_left) BoardOf(options);  // before the search for images
}

// Rejects output files that would overwrite an input.
void RequireOtherThanInputs(const CalibrateOptions& options) {
  std::vector<std::filesystem::path> inputs{options.rig, options.tip_places};
  for (const auto& [option, pattern] :
       {std::pair{"--left", options.left}, {"--right", options.right}}) {
    if (!pattern.empty())
      std::ranges::move(ListedImages(option, pattern), std::back_inserter(inputs));
  }
  RequireOtherThan("--out", options.out, inputs);
}

void WriteCorners(const std::filesystem::path& file, const DetectedBoards& side) {
  const BoardImage& last = side.images.back();
  if (!last.corners) throw std::runtime_error(last.name + ": " + last.why_not);
  std::string table = "u,v\n";
  for (const cv::Point2f& p : *last.corners) table += fmt::format("{},{}\n", p.x, p.y);
  WriteWholeFile(file, table);
}

CalibrationReport CalibrateImages(const CalibrateOptions& options, const std::stop_token& stop) {
  const Board board = BoardOf(options);
  ProgressBar bar("calibrate", stop);
  const DetectedBoards left = FindBoards("--left", options.left, board, &bar);
  if (!options.corners.empty()) WriteCorners(options.corners, left);
  if (options.right.empty()) {
    bar.Report("lens", 0);
    return CalibrateOneCamera(board, left);
  }
  const DetectedBoards right = FindBoards("--right", options.right, board, &bar);
  bar.Report("rig", 0);
  return CalibrateTwoCameras(board, left, right);
}

}  // namespace

std::array<int, 2> TwoCounts(const std::string& option, const std::string& text, int least,
                             int most, const char* example) {
  const auto cross = text.find_first_of("xX");
  if (cross != std::string::npos) {
    const auto a = ParseInteger(text.substr(0, cross)), b = ParseInteger(text.substr(cross + 1));
    if (a && b && *a >= least && *a <= most && *b >= least && *b <= most) {
      return {static_cast<int>(*a), static_cast<int>(*b)};
    }
  }
  throw std::invalid_argument(fmt::format("{} {}: expected two counts of {} to {}, for example {}",
                                          option, text, least, most, example));
}

int RunCalibrate(const CalibrateOptions& options, const std::stop_token& stop) {
  RequireUsable(options);
  RequireOtherThanInputs(options);
  RequireWritable(options.out);  // found now, not after minutes of work
  if (options.left.empty()) {
    if (options.rig.empty()) return RunRegister(options, nullptr, {}, options.out);
    StereoRig rig;
    try {
      rig = ReadRig(options.rig);
    } catch (const std::runtime_error& error) {
      throw std::invalid_argument(std::string("--rig ") + error.what());
    }
    return RunRegister(options, &rig, options.rig, options.out);
  }
  const double distance = options.distance.empty() ? 0 : Length("--distance", options.distance, 10);
  const CalibrationReport report = CalibrateImages(options, stop);
  const StereoRig& rig = report.calibration.rig;
  std::fputs(Words(report).c_str(), stdout);
  if (distance > 0) {
    std::fputs(fmt::format("on the optical axis at {:.4g} mm one pixel covers {:.5g} mm\n",
                           1e3 * distance, 1e3 * distance / std::sqrt(rig.left.fx * rig.left.fy))
                   .c_str(),
               stdout);
  }
  const bool is_trusted = report.calibration.reasons.empty();
  if (!is_trusted && !options.force) {
    std::fprintf(stderr, "calibrate: rejected, %s is not written (--force writes it): %s\n",
                 options.out.c_str(), report.calibration.reasons.front().c_str());
    return 1;
  }
  const bool is_pair = report.calibration.is_pair;
  WriteRig(options.out, rig, !is_pair, is_pair ? Rectification(rig) : std::vector<NamedMatrix>());
  const int registered =
      options.tip_places.empty() ? 0 : RunRegister(options, &rig, options.out, {});
  return is_trusted ? registered : 1;
}

}  // namespace palpate
