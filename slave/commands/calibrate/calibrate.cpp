#include "slave/commands/calibrate/calibrate.h"

#include <cstdio>
#include <map>
#include <stdexcept>

#include <fmt/format.h>

#include "shared/text/text.h"
#include "slave/capture/image_files.h"
#include "slave/commands/progress_bar.h"
#include "slave/scene/units.h"
#include "slave/vision/calibration/calibration.h"

namespace palpate {
namespace {

using Reasons = std::map<std::string, std::string>;  // why an image or a pair is not used, by name

struct Side {
  std::array<int, 2> size{};             // of the first image that shows the board [px]
  std::map<std::string, Corners> views;  // by the last number in the name, of one camera by name
};

// Throws std::runtime_error if no image shows the board; Interrupted.
Side FindBoards(const CalibrateOptions& options, const std::string& pattern, const Board& board,
                ProgressBar* bar, Reasons* reasons) {
  const auto files = ListImages(pattern, std::filesystem::current_path());
  RequireOtherThan("--out", options.out, files);
  Side side;
  for (std::size_t i = 0; i < files.size(); ++i) {
    ReportProgress(bar, "boards of " + pattern,
                   static_cast<double>(i) / static_cast<double>(files.size()));
    const std::string name = files[i].filename().string();
    std::string& why = (*reasons)[name];
    try {
      const cv::Mat image = ReadImage(files[i], i + 1);
      const auto corners = FindBoard(image, board);
      if (side.views.empty()) side.size = {image.cols, image.rows};
      const std::string key = options.right.empty() ? name : LastNumber(files[i]);
      if (!corners) {
        why = "the board is not completely visible";
      } else if (side.size != std::array{image.cols, image.rows}) {
        why = "its size is not that of the first image with a board";
      } else if (key.empty() || !side.views.emplace(key, *corners).second) {
        why = "its name has no number, or that of another image";
      } else {
        reasons->erase(name);
      }
    } catch (const std::runtime_error& error) {
      why = error.what();
    }
  }
  if (!side.views.empty()) return side;
  throw std::runtime_error(fmt::format(
      "{}: none of {} images shows a board of {} x {}: --board counts the inner corners of a "
      "chessboard, one fewer than squares; {}: {}",
      pattern, files.size(), board.columns, board.rows, reasons->begin()->first,
      reasons->begin()->second));
}

std::string LensWords(const char* side, const Lens& lens) {
  const auto& d = lens.distortion;
  return fmt::format(
      "{}: {} x {}, focal {:.2f} {:.2f} px, centre {:.2f} {:.2f} px, distortion {:.4f} {:.4f} "
      "{:.5f} {:.5f}\n",
      side, lens.size[0], lens.size[1], lens.fx, lens.fy, lens.cx, lens.cy, d[0], d[1], d[2], d[3]);
}

// `names`: of the views.
std::string Words(const Calibration& found, const std::vector<std::string>& names) {
  std::string words;
  for (const auto& [view, why] : found.dropped) {
    words += fmt::format("{}: not used: {}\n", names[view], why);
  }
  for (std::size_t k = 0; k < found.used.size(); ++k) {
    const auto& [left, right] = found.rms_px[k];
    words += fmt::format("{}: {:.3f} px rms", names[found.used[k]], left);
    words += found.is_pair ? fmt::format(" left, {:.3f} px right\n", right) : "\n";
  }
  words += LensWords(found.is_pair ? "left" : "camera", found.rig.left);
  if (found.is_pair) {
    const Eigen::Vector3d at = 1e3 * found.rig.X_RL.inverse().translation();
    words += LensWords("right", found.rig.right);
    words += fmt::format(
        "baseline {:.4f} mm: the right camera is at [{:.3f}, {:.3f}, {:.3f}] mm in the frame of "
        "the left one\n",
        at.norm(), at.x(), at.y(), at.z());
  }
  words += fmt::format(
      "reprojection rms {:.4f} px over {} {}\none sigma of the {}, from fits without one of them "
      "each: {:.3g} %\n",
      found.rig.rms_px, found.used.size(), found.is_pair ? "pairs" : "images",
      found.is_pair ? "baseline" : "focal length", 100 * found.sigma);
  for (const std::string& reason : found.reasons) words += "rejected: " + reason + "\n";
  return words;
}

Calibration CalibrateImages(const CalibrateOptions& options, const std::stop_token& stop) {
  const auto square = ParseQuantity(options.square, Dimension::kLength);
  if (!square || !(*square >= 1e-6 && *square <= 1)) {
    throw std::invalid_argument(fmt::format("--square {}: expected {}", options.square,
                                            ExpectedQuantity(Dimension::kLength, "1 um to 1 m")));
  }
  const Board board{options.board[0], options.board[1], *square};
  const bool is_pair = !options.right.empty();
  ProgressBar bar("calibrate", stop);
  Reasons reasons;
  const Side left = FindBoards(options, options.left, board, &bar, &reasons);
  const Side right = is_pair ? FindBoards(options, options.right, board, &bar, &reasons) : Side();
  std::vector<BoardView> views;
  std::vector<std::string> names;
  for (const auto& [name, corners] : left.views) {
    const auto other = right.views.find(name);
    if (is_pair && other == right.views.end()) {
      reasons["pair " + name] = "only the left image shows the board";
      continue;
    }
    views.push_back({corners, is_pair ? other->second : Corners()});
    names.push_back(is_pair ? "pair " + name : name);
  }
  bar.Clear();
  for (const auto& [name, why] : reasons) {
    std::printf("%s: not used: %s\n", name.c_str(), why.c_str());
  }
  bar.Report("fit", 0);
  const Calibration found = Calibrate(board, views, {left.size, right.size});
  bar.Clear();
  std::fputs(Words(found, names).c_str(), stdout);
  return found;
}

}  // namespace

int RunCalibrate(const CalibrateOptions& options, const std::stop_token& stop) {
  if (options.left.empty() && options.tip_places.empty()) {
    throw std::invalid_argument("calibrate: expected --left or --register");
  }
  RequireWritable(options.out);  // found now, not after minutes of work
  if (options.left.empty()) return RunRegister(options);
  const Calibration found = CalibrateImages(options, stop);
  if (!found.reasons.empty()) {
    std::fprintf(stderr, "calibrate: rejected, %s is not written\n", options.out.c_str());
    return 1;
  }
  WriteRig(options.out, found.rig);
  return 0;
}

}  // namespace palpate
