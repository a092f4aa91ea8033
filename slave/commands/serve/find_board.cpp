// A printed board in images of the set-up.
#include <cmath>
#include <stdexcept>
#include <utility>

#include <Eigen/Dense>
#include <spdlog/fmt/fmt.h>

#include "slave/capture/bounded_image.h"
#include "slave/commands/serve/setup_session.h"
#include "slave/vision/calibration/calibration.h"
#include "slave/vision/stereo/lens_warp.h"

namespace palpate {
namespace {

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

// Sets lens and remark.
void FitLens(const Board& board, const std::vector<BoardView>& views, const cv::Mat& image,
             FoundBoard* found) {
  Calibration calibration;
  try {
    calibration = Calibrate(board, views, {{image.cols, image.rows}, {}});
  } catch (const std::runtime_error& error) {
    found->remark = error.what();
    return;
  }
  if (!calibration.reasons.empty()) {
    found->remark = calibration.reasons.front();
    return;
  }
  const Lens& lens = calibration.rig.left;
  found->lens = RigText(calibration.rig);
  found->straight = LensWarp::Straightening(lens).Apply(image);
  for (Eigen::Vector2d& p : found->corners) p = Straight(lens, p).value_or(p);
}

}  // namespace

FoundBoard SetupSession::FindBoard(const BoardImages& images, Progress* progress) {
  RequireBounded(images.images);
  const Board board{images.columns, images.rows, images.square};
  const std::size_t count = std::max<std::size_t>(images.images.size(), 1);
  cv::Mat image;  // one at a time: together they may need gigabytes
  std::optional<Corners> corners;
  std::vector<std::pair<cv::Size, BoardView>> seen;
  for (std::size_t i = 0; i < count; ++i) {
    ReportProgress(progress, "images", static_cast<double>(i) / static_cast<double>(count));
    image = images.images.empty() ? StartImage(StopOf(progress)) : DecodeBounded(images.images[i]);
    corners = palpate::FindBoard(image, board);
    if (corners) seen.push_back({image.size(), {*corners, {}}});
  }
  if (!corners) {
    throw std::runtime_error(fmt::format("{}: expected all {} x {} inner corners in the last image",
                                         seen.empty()
                                             ? fmt::format("none of {} images shows a board", count)
                                             : "the last image does not show the board",
                                         board.columns, board.rows));
  }
  std::vector<BoardView> views;
  for (const auto& [size, view] : seen) {
    if (size == image.size()) views.push_back(view);
  }
  FoundBoard found;
  for (const cv::Point2f& p : *corners) found.corners.emplace_back(p.x, p.y);
  FitLens(board, views, image, &found);
  FitGrid(images, &found);
  return found;
}

}  // namespace palpate
