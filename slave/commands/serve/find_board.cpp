// A printed board in images of the set-up, found by palpate-calibrate: the slave does not contain
// OpenCV's calib3d.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>

#include <Eigen/Dense>
#include <spdlog/fmt/fmt.h>

#include "shared/program/program.h"
#include "shared/text/csv.h"
#include "shared/text/text.h"
#include "slave/capture/bounded_image.h"
#include "slave/capture/codecs/codecs.h"
#include "slave/commands/serve/setup_session.h"
#include "slave/program/private_folder.h"
#include "slave/program/run_program.h"
#include "slave/vision/stereo/lens_warp.h"

namespace palpate {
namespace {

constexpr std::chrono::seconds kMaxTime(60);

std::vector<Eigen::Vector2d> ReadCorners(const std::filesystem::path& file) {
  CsvTable table(file, {{"u"}, {"v"}});
  std::vector<Eigen::Vector2d> corners;
  while (table.Next()) corners.emplace_back(table.Number("u"), table.Number("v"));
  return corners;
}

// Fits an affine grid to the corners by least squares: pixel size and residual.
void FitGrid(const BoardImages& board, FoundBoard* found) {
  const auto count = static_cast<Eigen::Index>(found->corners.size());
  Eigen::MatrixX3d places(count, 3);
  Eigen::MatrixX2d corners(count, 2);
  for (Eigen::Index i = 0; i < count; ++i) {
    places.row(i) << static_cast<double>(i % board.columns), static_cast<double>(i / board.columns),
        1;
    corners.row(i) = found->corners[static_cast<std::size_t>(i)];
  }
  const Eigen::Matrix<double, 3, 2> grid = places.colPivHouseholderQr().solve(corners);
  found->pixel = board.square / std::sqrt(std::abs(grid.topRows<2>().determinant()));
  found->rms_px = (places * grid - corners).norm() / std::sqrt(static_cast<double>(count));
}

// The last line of a program's output, which says why it failed.
std::string LastLine(std::string output) {
  while (!output.empty() && output.back() == '\n') output.pop_back();
  return output.substr(output.rfind('\n') + 1);
}

}  // namespace

FoundBoard SetupSession::FindBoard(const BoardImages& board, Progress* progress) {
  const auto program = FindPart("palpate-calibrate");
  if (program.empty()) {
    throw std::runtime_error(
        "a board needs the part `calibration`: expected deploy/install.sh calibration");
  }
  RequireBounded(board.images);
  const PrivateFolder folder;
  cv::Mat image;  // one at a time: together they may need gigabytes
  for (std::size_t i = 0; i < std::max<std::size_t>(board.images.size(), 1); ++i) {
    ReportProgress(progress, "images", 0);
    image = board.images.empty() ? StartImage(StopOf(progress)) : DecodeBounded(board.images[i]);
    WriteWholeFile(folder.path() / fmt::format("{:03}.png", i), EncodePng(image));
  }
  const ProgramEnd end = RunProgram(
      program,
      {"--left", "*.png", "--board", fmt::format("{}x{}", board.columns, board.rows), "--square",
       fmt::format("{} mm", 1e3 * board.square), "--out", "lens.yaml", "--corners", "corners.csv"},
      folder.path(), kMaxTime, StopOf(progress));
  const auto corners = folder.path() / "corners.csv", lens = folder.path() / "lens.yaml";
  if (!std::filesystem::exists(corners)) throw std::runtime_error(LastLine(end.output));
  FoundBoard found;
  found.corners = ReadCorners(corners);
  if (end.status == 0 && std::filesystem::exists(lens)) {
    constexpr std::uintmax_t kMaxBytes = 1 << 20;
    found.lens = ReadWholeFile(lens, kMaxBytes, "a lens");
    const Lens calibrated = ReadLens(lens);
    found.straight = LensWarp::Straightening(calibrated).Apply(image);
    for (Eigen::Vector2d& p : found.corners) p = Straight(calibrated, p).value_or(p);
  } else {
    found.remark = LastLine(end.output);
  }
  FitGrid(board, &found);
  return found;
}

}  // namespace palpate
