#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "slave/commands/calibrate/calibrate_report.h"

namespace palpate {
namespace {

std::string LensWords(const char* side, const Lens& lens) {
  const auto& d = lens.distortion;
  return fmt::format(
      "{}: {} x {}, focal {:.2f} {:.2f} px, centre {:.2f} {:.2f} px, distortion {:.4f} {:.4f} "
      "{:.5f} {:.5f}\n",
      side, lens.size[0], lens.size[1], lens.fx, lens.fy, lens.cx, lens.cy, d[0], d[1], d[2], d[3]);
}

std::string Table(const CalibrationReport& report) {
  std::size_t width = 8;
  for (const CalibrationRow& row : report.rows) width = std::max(width, row.full_name().size());
  std::string table =
      fmt::format("{:<{}}  {}  pixel on the board [mm]\n", report.is_pair ? "pair" : "image", width,
                  report.is_pair ? "left [px]  right [px]" : "rms [px]");
  for (const CalibrationRow& row : report.rows) {
    table += fmt::format("{:<{}}  ", row.full_name(), width);
    if (!row.used) {
      table += "not used: " + row.why_not + "\n";
    } else if (report.is_pair) {
      table +=
          fmt::format("{:9.3f}  {:10.3f}  {:.4f}\n", row.left_px, row.right_px, 1e3 * row.pixel);
    } else {
      table += fmt::format("{:8.3f}  {:.4f}\n", row.left_px, 1e3 * row.pixel);
    }
  }
  return table;
}

std::string PairWords(const StereoRig& rig) {
  const Eigen::Vector3d at = 1e3 * rig.X_RL.inverse().translation();
  const Eigen::AngleAxisd turn(rig.X_RL.linear());
  return fmt::format(
      "baseline {:.4f} mm: the right camera is at [{:.3f}, {:.3f}, {:.3f}] mm in the frame of the "
      "left camera, rotated by {:.3f} deg\n",
      1e3 * rig.baseline(), at.x(), at.y(), at.z(), turn.angle() * 180 / std::numbers::pi);
}

// Numbers that a ruler can check: a wrong --square shows here and nowhere else.
std::string ScaleWords(const CalibrationReport& report) {
  double nearest = HUGE_VAL, farthest = 0;
  for (const CalibrationRow& row : report.rows) {
    if (!row.used) continue;
    const double z = row.X_LB.translation().z();
    nearest = std::min(nearest, z), farthest = std::max(farthest, z);
  }
  const cv::Size2d extent = BoardExtent(report.board);
  std::string words = fmt::format(
      "the board ({:.4g} x {:.4g} mm between outer corners) was {:.4g} to {:.4g} mm from the "
      "camera\n",
      1e3 * extent.width, 1e3 * extent.height, 1e3 * nearest, 1e3 * farthest);
  if (report.distance > 0) {
    const Lens& lens = report.rig.left;
    words +=
        fmt::format("on the optical axis at {:.4g} mm one pixel covers {:.5g} mm\n",
                    1e3 * report.distance, 1e3 * report.distance / std::sqrt(lens.fx * lens.fy));
  }
  return words;
}

std::string HalvesWords(const CalibrationEvidence& question) {
  const HalvesCheck& halves = question.halves;
  if (halves.random.empty()) return "";
  std::string words = fmt::format(
      "repeatability of the {} between halves of the images: odd and even differ by {:.3g} %, {} "
      "random halves by {:.3g} % (median) and {:.3g} % (largest); one sigma from all {:.3g} %",
      question.quantity, 100 * halves.odd_even, halves.random.size(),
      100 * halves.random[halves.random.size() / 2], 100 * halves.worst(), 100 * halves.sigma());
  if (halves.failed > 0) words += fmt::format("; {} halves give no result", halves.failed);
  return words + "\n";
}

}  // namespace

std::string Words(const CalibrationReport& report) {
  std::string words = Table(report);
  words += LensWords(report.is_pair ? "left" : "camera", report.rig.left);
  if (report.is_pair) words += LensWords("right", report.rig.right) + PairWords(report.rig);
  words += fmt::format("reprojection rms {:.4f} px over {} {}\n", report.rig.rms_px,
                       report.question.used, report.is_pair ? "pairs (joint)" : "images");
  words += ScaleWords(report);
  words += HalvesWords(report.question);
  words += "coverage:";
  for (const double coverage : report.question.coverage) {
    words += fmt::format(" {:.0f} %", 100 * coverage);
  }
  words += fmt::format("; focal length one sigma {:.2g} %\n", 100 * report.question.sigma_focal);
  for (const std::string& note : report.notes) words += note + "\n";
  for (const std::string& warning : report.verdict.warnings) words += "weak: " + warning + "\n";
  for (const std::string& reason : report.verdict.reasons) {
    words += "rejected: " + reason + "\n";
  }
  return words;
}

std::string StandingWords(const Eigen::Isometry3d& X_SC) {
  const Eigen::Vector3d at = 1e3 * X_SC.translation(), forward = X_SC.linear().col(2);
  int axis = 0;
  forward.cwiseAbs().maxCoeff(&axis);
  return fmt::format(
      "the camera is at [{:.1f}, {:.1f}, {:.1f}] mm in S and looks along [{:.2f}, {:.2f}, {:.2f}], "
      "towards {}{}",
      at.x(), at.y(), at.z(), forward.x(), forward.y(), forward.z(), forward[axis] > 0 ? '+' : '-',
      "xyz"[axis]);
}

std::string Words(const CameraRegistration& registration) {
  const double scale = registration.in_pixels ? 1 : 1e3;
  const char* unit = registration.in_pixels ? "px" : "mm";
  std::string words = fmt::format("row  error [{}]\n", unit);
  for (std::size_t i = 0; i < registration.residuals.size(); ++i) {
    const double off = registration.residuals[i];
    words += fmt::format("{:5}  {}{}\n", i + 1,
                         std::isfinite(off) ? fmt::format("{:.4f}", scale * off) : "no ray",
                         registration.used[i] ? "" : "  not used");
  }
  words +=
      fmt::format("rms {:.4f} {}; one sigma of the direction {:.3g} deg", scale * registration.rms,
                  unit, registration.sigma_angle * 180 / std::numbers::pi);
  if (registration.sigma_place > 0) {
    words += fmt::format(", of the camera position {:.3g} mm", 1e3 * registration.sigma_place);
  }
  words += "\n";
  if (registration.pixel == 0) words += StandingWords(registration.X_SC) + "\n";
  for (const std::string& warning : registration.warnings) words += "check: " + warning + "\n";
  for (const std::string& reason : registration.reasons) {
    words += "rejected: " + reason + "\n";
  }
  return words;
}

}  // namespace palpate
