#include "tests/slave/pipeline/press/press_recording.h"

#include <cmath>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>

#include "tests/support/csv_columns.h"

namespace palpate {
namespace {

constexpr int kRestFirst = 40, kRestLast = 58;

// The force is its change against the rest frames.
std::vector<RecordedPress::Row> ReadRows(const std::filesystem::path& file) {
  const CsvColumns columns = ReadColumns(file);
  const auto fx = NumbersOf(columns, "fx_N"), fy = NumbersOf(columns, "fy_N"),
             fz = NumbersOf(columns, "fz_N");
  std::vector<RecordedPress::Row> rows;
  for (std::size_t k = 0; k < fx.size(); ++k) rows.push_back({{fx[k], fy[k], fz[k]}});
  RecordedPress::Row rest;
  for (int k = kRestFirst; k <= kRestLast; ++k) {
    rest.force += rows.at(static_cast<std::size_t>(k)).force;
  }
  for (auto& row : rows) {
    row.force -= rest.force / (kRestLast - kRestFirst + 1);
  }
  return rows;
}

}  // namespace

DepthPoints::Params RecordedPressCamera() {
  DepthPoints::Params params;
  params.camera.unit = 1e-4;
  params.camera.fx = 434.34;
  params.camera.fy = 433.36;
  params.camera.cx = 313.71;
  params.camera.cy = 247.54;
  params.camera.sigma = 0.08e-3;
  params.farthest = 0.115;
  return params;
}

RecordedPress ReadRecordedPress(const std::filesystem::path& folder) {
  RecordedPress press;
  press.rows = ReadRows(folder / "robot_pressure_wrench.csv");
  DepthPoints cameras(RecordedPressCamera());
  double squares = 0;
  double scaled_squares = 0;
  int rest_points = 0;
  for (int number = 0; number < static_cast<int>(press.rows.size()); ++number) {
    const auto file = folder / fmt::format("depth_{:03d}.png", number);
    if (!std::filesystem::exists(file)) continue;
    const cv::Mat image = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
    const auto& seen = cameras.Observe(image);
    if (!seen.found) continue;
    press.frames.push_back({number, seen.points});
    for (std::size_t i = 0; i < seen.points.size() && number <= kRestLast; ++i) {
      const SurfacePoint& point = seen.points[i];
      const Eigen::Vector3d n = cameras.normal_S(i);
      const double way = n.dot(point.p_S - point.p_S_rest);
      if (!point.seen || std::abs(way) > 1e-3) continue;  // cells on the edge of a hole
      squares += way * way;
      scaled_squares += way * way / n.dot(point.covariance * n);
      ++rest_points;
    }
  }
  press.rest_rms = std::sqrt(squares / rest_points);
  press.rest_scatter = std::sqrt(scaled_squares / rest_points);
  return press;
}

}  // namespace palpate
