#include <algorithm>
#include <fstream>
#include <stdexcept>

#include <fmt/format.h>

#include "slave/commands/calibrate_report.h"
#include "slave/study/svg.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPanel = 380, kGap = 30, kTop = 40;
constexpr const char* kStyle =
    "text{font:12px sans-serif;fill:#222}.frame{fill:none;stroke:#999}"
    ".board{fill:#4878a830;stroke:#4878a8}.camera{fill:#c44e5240;stroke:#c44e52}"
    ".left{fill:#4878a8}.right{fill:#d98a3d}.limit{stroke:#c44e52;stroke-dasharray:4 3}\n";

// From above: x of the left camera to the right, z up.
void DrawPoses(const CalibrationReport& report, Svg* svg) {
  const double width = (report.board.columns - 1) * report.board.square;
  const double height = (report.board.rows - 1) * report.board.square;
  std::vector<std::pair<std::string, std::vector<Vector2d>>> boards;
  const auto above = [](const Vector3d& p) { return Vector2d(p.x(), p.z()); };
  Vector2d low(0, 0), high(0, 0);
  const auto widen = [&](const Vector2d& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); };
  for (const CalibrationRow& row : report.rows) {
    if (!row.used) continue;
    std::vector<Vector2d> outline;
    for (const Vector3d& p : {Vector3d(0, 0, 0), Vector3d(width, 0, 0), Vector3d(width, height, 0),
                              Vector3d(0, height, 0)}) {
      outline.push_back(above(row.X_LB * p));
      widen(outline.back());
    }
    boards.emplace_back(row.name, outline);
  }
  const double reach = 0.08 * (high - low).norm();
  std::vector<std::vector<Vector2d>> cameras;
  const auto add_camera = [&](const Eigen::Isometry3d& X_LC) {
    cameras.push_back({above(X_LC.translation()), above(X_LC * Vector3d(-reach / 2, 0, reach)),
                       above(X_LC * Vector3d(reach / 2, 0, reach))});
    for (const Vector2d& p : cameras.back()) widen(p);
  };
  add_camera(Eigen::Isometry3d::Identity());
  if (report.is_pair) add_camera(report.rig.X_RL.inverse());
  const double scale = (kPanel - 20) / std::max((high - low).maxCoeff(), 1e-9);
  const auto to_panel = [&](std::vector<Vector2d> points) {
    for (Vector2d& p : points) {
      p = Vector2d(kGap + 10 + scale * (p.x() - low.x()),
                   kTop + kPanel - 10 - scale * (p.y() - low.y()));
    }
    return points;
  };
  svg->Text({kGap, kTop - 10}, "boards and cameras from above", "");
  svg->Rectangle({kGap, kTop}, {kPanel, kPanel}, "frame");
  for (const auto& [name, outline] : boards) svg->Polygon(to_panel(outline), "board", name);
  for (const auto& camera : cameras) svg->Polygon(to_panel(camera), "camera", "camera");
}

void DrawCoverage(const CalibrationReport& report, bool right, const Vector2d& at, Svg* svg) {
  const auto& size = right ? report.rig.right.size : report.rig.left.size;
  const double scale = kPanel / size[0];
  svg->Text(at - Vector2d(0, 10),
            right ? "corners in the right picture" : "corners in the left picture", "");
  svg->Rectangle(at, {kPanel, scale * size[1]}, "frame");
  for (const CalibrationRow& row : report.rows) {
    if (!row.used) continue;
    for (const cv::Point2f& p : right ? row.right : row.left) {
      svg->Circle(at + scale * Vector2d(p.x, p.y), 1.5, right ? "right" : "left");
    }
  }
}

void DrawResiduals(const CalibrationReport& report, const Vector2d& at, double width, Svg* svg) {
  constexpr double kHeight = 160;
  double most = 0.1;
  for (const CalibrationRow& row : report.rows) most = std::max({most, row.left_px, row.right_px});
  svg->Text(at - Vector2d(0, 10), fmt::format("rms per picture, full height {:.2f} px", most), "");
  svg->Rectangle(at, {width, kHeight}, "frame");
  const double step = width / static_cast<double>(report.rows.size());
  for (std::size_t i = 0; i < report.rows.size(); ++i) {
    const CalibrationRow& row = report.rows[i];
    const double x = at.x() + step * (static_cast<double>(i) + 0.2);
    const auto bar = [&](double shift, double px, const char* style) {
      const double height = kHeight * px / most;
      svg->Rectangle({x + shift * step, at.y() + kHeight - height}, {0.28 * step, height}, style);
    };
    if (row.used) bar(0, row.left_px, "left");
    if (row.used && report.is_pair) bar(0.3, row.right_px, "right");
    svg->Text({x, at.y() + kHeight + 12}, row.used ? row.name : row.name + " (left out)", "",
              Svg::Anchor::kStart, 30);
  }
}

}  // namespace

void WriteDrawing(const std::filesystem::path& file, const CalibrationReport& report) {
  const double width = (report.is_pair ? 3 : 2) * (kPanel + kGap) + kGap;
  Svg svg(width, kTop + 2 * kPanel, "Calibration", kStyle);
  DrawPoses(report, &svg);
  DrawCoverage(report, false, {2 * kGap + kPanel, kTop}, &svg);
  if (report.is_pair) DrawCoverage(report, true, {3 * kGap + 2 * kPanel, kTop}, &svg);
  DrawResiduals(report, {kGap, 2 * kTop + kPanel}, width - 2 * kGap, &svg);
  std::ofstream stream(file);
  stream << svg.Document();
  stream.close();
  if (!stream) throw std::runtime_error("--drawing " + file.string() + ": cannot be written");
}

}  // namespace palpate
