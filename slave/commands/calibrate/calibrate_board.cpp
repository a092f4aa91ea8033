#include "slave/commands/calibrate/calibrate_board.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace palpate {
namespace {

// Fits the boards that were found. `rows`: one per image or pair; views[k] is of rows[row_of[k]].
CalibrationReport ReportOn(const Board& board, const std::vector<BoardView>& views,
                           const std::vector<std::size_t>& row_of, const ImageSizes& sizes,
                           CalibrationReport report) {
  if (views.size() < 3) {
    std::string words = fmt::format(
        "{} of {} images or pairs show the board: expected 3 or more, 4 or more to be trusted",
        views.size(), report.rows.size());
    for (const CalibrationReport::Row& row : report.rows) {
      if (!row.why_not.empty()) words += "; " + row.name + ": " + row.why_not;
    }
    throw std::runtime_error(words);
  }
  report.calibration = Calibrate(board, views, sizes);
  const Calibration& found = report.calibration;
  for (std::size_t k = 0; k < found.used.size(); ++k) {
    const auto& [left, right] = found.rms_px[k];
    report.rows[row_of[found.used[k]]].rms_px = found.is_pair
                                                    ? fmt::format("{:9.3f}  {:10.3f}", left, right)
                                                    : fmt::format("{:9.3f}", left);
  }
  for (const auto& [view, miss_px] : found.dropped) {
    report.rows[row_of[view]].why_not = fmt::format(
        "deviates by {:.2f} px from the others: blurred, bent, of another board or camera{}",
        miss_px, found.is_pair ? ", or the board moved between the exposures of a pair" : "");
  }
  return report;
}

CalibrationReport CalibrateInOrder(const Board& board, const DetectedBoards& left,
                                   const DetectedBoards& right) {
  CalibrationReport report;
  std::vector<BoardView> views;
  std::vector<std::size_t> row_of;
  std::set<std::string> alone;
  for (const DetectedBoards* side : {&left, &right}) {
    for (const BoardImage& image : side->images) alone.insert(image.name);
  }
  for (const auto& [i, j] : MatchImages(left, right)) {
    const BoardImage &a = left.images[i], &b = right.images[j];
    alone.erase(a.name), alone.erase(b.name);
    CalibrationReport::Row& row = report.rows.emplace_back();
    row.name = a.name + " " + b.name;
    if (a.corners && b.corners) {
      views.push_back({*a.corners, *b.corners});
      row_of.push_back(report.rows.size() - 1);
    } else {
      row.why_not = a.corners ? b.name + ": " + b.why_not : a.name + ": " + a.why_not;
    }
  }
  if (!alone.empty()) {
    report.notes.push_back(fmt::format("images without a partner on the other side: {} ({})",
                                       alone.size(), fmt::join(alone, ", ")));
  }
  return ReportOn(board, views, row_of, {left.size, right.size}, std::move(report));
}

std::string LensWords(const char* side, const Lens& lens) {
  const auto& d = lens.distortion;
  return fmt::format(
      "{}: {} x {}, focal {:.2f} {:.2f} px, centre {:.2f} {:.2f} px, distortion {:.4f} {:.4f} "
      "{:.5f} {:.5f}\n",
      side, lens.size[0], lens.size[1], lens.fx, lens.fy, lens.cx, lens.cy, d[0], d[1], d[2], d[3]);
}

std::string PairWords(const StereoRig& rig) {
  const Eigen::Vector3d at = 1e3 * rig.X_RL.inverse().translation();
  const Eigen::AngleAxisd turn(rig.X_RL.linear());
  return fmt::format(
      "baseline {:.4f} mm: the right camera is at [{:.3f}, {:.3f}, {:.3f}] mm in the frame of the "
      "left camera, rotated by {:.3f} deg\n",
      1e3 * rig.baseline(), at.x(), at.y(), at.z(), turn.angle() * 180 / std::numbers::pi);
}

// Formats sizes that can be checked with a ruler, because a wrong --square has no other symptom.
std::string ScaleWords(const Calibration& calibration) {
  const auto [nearest, farthest] = std::ranges::minmax(
      calibration.X_LB, {}, [](const Eigen::Isometry3d& X_LB) { return X_LB.translation().z(); });
  const cv::Size2d extent = BoardExtent(calibration.board);
  return fmt::format(
      "the board ({:.4g} x {:.4g} mm between outer corners) was {:.4g} to {:.4g} mm from the "
      "camera\n",
      1e3 * extent.width, 1e3 * extent.height, 1e3 * nearest.translation().z(),
      1e3 * farthest.translation().z());
}

}  // namespace

CalibrationReport CalibrateOneCamera(const Board& board, const DetectedBoards& side) {
  CalibrationReport report;
  std::vector<BoardView> views;
  std::vector<std::size_t> row_of;
  for (const BoardImage& image : side.images) {
    report.rows.push_back({image.name, image.why_not, ""});
    if (!image.corners) continue;
    views.push_back({*image.corners, {}});
    row_of.push_back(report.rows.size() - 1);
  }
  return ReportOn(board, views, row_of, {side.size, {}}, std::move(report));
}

CalibrationReport CalibrateTwoCameras(const Board& board, const DetectedBoards& left,
                                      const DetectedBoards& right) {
  CalibrationReport report = CalibrateInOrder(board, left, right);
  if (report.calibration.reasons.empty() && AreSidesExchanged(report.calibration.rig)) {
    report = CalibrateInOrder(board, right, left);
    report.notes.emplace_back(
        "left and right are exchanged: the camera given as --left is to the right of the other (or "
        "both are upside down). The rig is written with corrected sides: exchange the images in "
        "the scene as well");
  }
  return report;
}

std::string Words(const CalibrationReport& report) {
  const Calibration& found = report.calibration;
  std::size_t width = 8;
  for (const CalibrationReport::Row& row : report.rows) width = std::max(width, row.name.size());
  std::string words = fmt::format("{:<{}}  {}\n", found.is_pair ? "pair" : "image", width,
                                  found.is_pair ? "left [px]  right [px]" : " rms [px]");
  for (const CalibrationReport::Row& row : report.rows) {
    words += fmt::format("{:<{}}  {}\n", row.name, width,
                         row.why_not.empty() ? row.rms_px : "not used: " + row.why_not);
  }
  words += LensWords(found.is_pair ? "left" : "camera", found.rig.left);
  if (found.is_pair) words += LensWords("right", found.rig.right) + PairWords(found.rig);
  words += fmt::format("reprojection rms {:.4f} px over {} {}\n", found.rig.rms_px,
                       found.used.size(), found.is_pair ? "pairs (joint)" : "images");
  words += ScaleWords(found);
  words += fmt::format(
      "one sigma of the {} from halves of {} different images: {:.3g} %; of the focal length in "
      "the "
      "fit: {:.2g} %\ncoverage:",
      found.is_pair ? "baseline" : "focal length", found.distinct, 100 * found.sigma,
      100 * found.sigma_focal);
  for (const double coverage : found.coverage) words += fmt::format(" {:.0f} %", 100 * coverage);
  words += "\n";
  for (const std::string& note : report.notes) words += note + "\n";
  for (const std::string& warning : found.warnings) words += "weak: " + warning + "\n";
  for (const std::string& reason : found.reasons) words += "rejected: " + reason + "\n";
  return words;
}

}  // namespace palpate
