#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "shared/text/svg.h"
#include "shared/text/text.h"
#include "slave/commands/calibrate/calibrate_report.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPanel = 380, kGap = 40, kTop = 60, kLine = 18;
constexpr double kBars = 150;    // height
constexpr double kLetter = 5.5;  // width of a small one
constexpr const char* kStyle =
    "text{font:12px sans-serif;fill:#222}.title{font-size:13px;font-weight:bold}"
    ".bad{fill:#b02a30;font-weight:bold}.good{fill:#2b7a3d;font-weight:bold}.small{font-size:10px}"
    ".frame{fill:none;stroke:#999}.cell{fill:#eef3ea}.tick{stroke:#ddd}.bar{stroke:#222}"
    ".median{stroke:#b02a30;stroke-dasharray:4 3}"
    ".board{fill:#4878a830;stroke:#4878a8}.camera{fill:#c44e5240;stroke:#c44e52}"
    ".left{fill:#4878a8}.right{fill:#d98a3d}\n";

// 1, 2 or 5 times a power of ten, at most `value`.
double RoundBelow(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  const double head = value / power;
  return power * (head >= 5 ? 5 : head >= 2 ? 2 : 1);
}

// The left camera's x and z, from above, z up.
class PosesPanel {
 public:
  explicit PosesPanel(const CalibrationReport& report) {
    const cv::Size2d extent = BoardExtent(report.board);
    int number = 0;
    for (const CalibrationRow& row : report.rows) {
      ++number;
      if (!row.used) continue;
      Shape board{row.full_name(), std::to_string(number), {}};
      for (const auto& [x, y] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}}) {
        board.outline.push_back(Above(row.X_LB * Vector3d(x * extent.width, y * extent.height, 0)));
      }
      boards_.push_back(std::move(board));
    }
    const double reach = 0.08 * (high_ - low_).norm();
    AddCamera(Eigen::Isometry3d::Identity(), reach, report.is_pair ? "left" : "camera");
    if (report.is_pair) AddCamera(report.rig.X_RL.inverse(), reach, "right");
  }

  void Draw(const Vector2d& at, Svg* svg) const {
    const double size = std::max((high_ - low_).maxCoeff(), 1e-9);
    const double scale = (kPanel - 50) / size;
    const auto place = [&](const Vector2d& p) {
      return Vector2d(at.x() + 15 + scale * (p.x() - low_.x()),
                      at.y() + kPanel - 30 - scale * (p.y() - low_.y()));
    };
    const auto draw = [&](const Shape& shape, const char* style) {
      std::vector<Vector2d> outline;
      Vector2d middle(0, 0);
      for (const Vector2d& p : shape.outline) {
        outline.push_back(place(p));
        middle += outline.back() / static_cast<double>(shape.outline.size());
      }
      svg->Polygon(outline, style, shape.name);
      svg->Text(middle, shape.label, "small", Svg::Anchor::kMiddle);
    };
    svg->Text(at - Vector2d(0, 10), "boards and cameras from above", "title");
    svg->Rectangle(at, {kPanel, kPanel}, "frame");
    for (const Shape& board : boards_) draw(board, "board");
    for (const Shape& camera : cameras_) draw(camera, "camera");
    const double bar = RoundBelow(0.3 * size);
    const Vector2d end = at + Vector2d(kPanel - 15, kPanel - 12);
    svg->Line(end - Vector2d(scale * bar, 0), end, "bar");
    svg->Text(end - Vector2d(0.5 * scale * bar, 4), fmt::format("{:g} mm", 1e3 * bar), "small",
              Svg::Anchor::kMiddle);
  }

 private:
  struct Shape {
    std::string name, label;
    std::vector<Vector2d> outline;  // [m]
  };

  Vector2d Above(const Vector3d& p_L) {
    const Vector2d p(p_L.x(), p_L.z());
    low_ = low_.cwiseMin(p), high_ = high_.cwiseMax(p);
    return p;
  }
  void AddCamera(const Eigen::Isometry3d& X_LC, double reach, const char* name) {
    cameras_.push_back({name,
                        name,
                        {Above(X_LC.translation()), Above(X_LC * Vector3d(-reach / 2, 0, reach)),
                         Above(X_LC * Vector3d(reach / 2, 0, reach))}});
  }

  std::vector<Shape> boards_, cameras_;
  Vector2d low_{0, 0}, high_{0, 0};
};

void DrawCoverage(const CalibrationReport& report, bool right, const Vector2d& at, Svg* svg) {
  const auto& size = right ? report.rig.right.size : report.rig.left.size;
  const double scale = kPanel / size[0];
  const double height = scale * size[1];
  std::set<CoverageCell> seen;
  for (const CalibrationRow& row : report.rows) {
    if (row.used) CoverCells(right ? row.right : row.left, size, &seen);
  }
  const char* side = !report.is_pair ? "" : right ? "right " : "left ";
  svg->Text(at - Vector2d(0, 10),
            fmt::format("corners in {:.0f} % of the {}image",
                        100 * report.question.coverage[right ? 1 : 0], side),
            "title");
  const Vector2d cell(kPanel / kCoverageColumns, height / kCoverageRows);
  for (const auto& [i, j] : seen) {
    svg->Rectangle(at + cell.cwiseProduct(Vector2d(i, j)), cell, "cell");
  }
  svg->Rectangle(at, {kPanel, height}, "frame");
  for (const CalibrationRow& row : report.rows) {
    if (!row.used) continue;
    for (const cv::Point2f& p : right ? row.right : row.left) {
      svg->Circle(at + scale * Vector2d(p.x, p.y), 1.5, right ? "right" : "left");
    }
  }
}

class ResidualsPanel {
 public:
  explicit ResidualsPanel(const CalibrationReport& report) : report_(report) {
    for (const CalibrationRow& row : report.rows)
      most_ = std::max({most_, row.left_px, row.right_px});
    most_ *= 1.1;
  }

  // What the labels need beyond the last bar and below the bars.
  [[nodiscard]] Vector2d LabelSpace() const {
    std::size_t most = 0;
    for (std::size_t i = 0; i < report_.rows.size(); ++i) most = std::max(most, Label(i).size());
    return kLetter * static_cast<double>(most) * Vector2d(std::sqrt(0.75), 0.5) + Vector2d(0, 40);
  }
  void Draw(const Vector2d& at, double width, Svg* svg) const {
    svg->Text(at - Vector2d(0, 10), "rms residual of each image [px]", "title");
    DrawLegend(at, width, svg);
    const double tick = RoundBelow(0.5 * most_);
    for (double px = tick; px < most_; px += tick) {
      const double y = at.y() + kBars * (1 - px / most_);
      svg->Line({at.x(), y}, {at.x() + width, y}, "tick");
      svg->Text({at.x() - 4, y + 4}, fmt::format("{:g}", px), "small", Svg::Anchor::kEnd);
    }
    const double step = width / static_cast<double>(report_.rows.size());
    for (std::size_t i = 0; i < report_.rows.size(); ++i) {
      DrawRow(i, at + Vector2d(step * static_cast<double>(i), 0), step, svg);
    }
    const double y = at.y() + kBars * (1 - report_.rig.rms_px / most_);
    svg->Line({at.x(), y}, {at.x() + width, y}, "median");
    svg->Rectangle(at, {width, kBars}, "frame");
  }

 private:
  void DrawLegend(const Vector2d& at, double width, Svg* svg) const {
    Vector2d to(at.x() + width, at.y() - 10);
    svg->Text(to, fmt::format("dashed: all together, {:.3f} px", report_.rig.rms_px), "small",
              Svg::Anchor::kEnd);
    if (!report_.is_pair) return;
    for (const char* side : {"right", "left"}) {
      to.x() -= side[0] == 'r' ? 230 : 60;
      svg->Rectangle(to - Vector2d(14, 9), {10, 10}, side);
      svg->Text(to, side, "small");
    }
  }
  [[nodiscard]] std::string Label(std::size_t i) const {
    const CalibrationRow& row = report_.rows[i];
    return fmt::format("{}: {}{}", i + 1, row.full_name(), row.used ? "" : ", not used");
  }
  void DrawRow(std::size_t i, const Vector2d& at, double step, Svg* svg) const {
    const CalibrationRow& row = report_.rows[i];
    const double wide = std::min(0.3 * step, 40.0);
    const Vector2d middle = at + Vector2d(0.5 * step, kBars);
    const auto bar = [&](double shift, double px, const char* style) {
      const double height = kBars * px / most_;
      svg->Rectangle(middle + Vector2d(shift * wide, -height), {wide, height}, style);
    };
    if (row.used) bar(report_.is_pair ? -1 : -0.5, row.left_px, "left");
    if (row.used && report_.is_pair) bar(0, row.right_px, "right");
    svg->Text(middle + Vector2d(-4, 14), Label(i), row.used ? "small" : "small bad",
              Svg::Anchor::kStart, 30);
  }

  const CalibrationReport& report_;
  double most_ = 0.1;  // full height [px]
};

std::vector<std::pair<std::string, const char*>> Verdict(const CalibrationReport& report) {
  std::vector<std::pair<std::string, const char*>> lines;
  for (const std::string& reason : report.verdict.reasons) {
    lines.emplace_back("rejected: " + reason, "bad");
  }
  if (lines.empty()) lines.emplace_back("accepted", "good");
  for (const std::string& warning : report.verdict.warnings) {
    lines.emplace_back("weak: " + warning, "");
  }
  return lines;
}

}  // namespace

void WriteDrawing(const std::filesystem::path& file, const CalibrationReport& report) {
  const int panels = report.is_pair ? 3 : 2;
  const double inside = panels * kPanel + (panels - 1) * kGap;
  const auto verdict = Verdict(report);
  const double residuals = kTop + kPanel + kGap;
  const ResidualsPanel bars(report);
  const double words = residuals + kBars + bars.LabelSpace().y();
  Svg svg(inside + 1.5 * kGap + bars.LabelSpace().x(),
          words + kLine * static_cast<double>(verdict.size()) + 10, "Calibration", kStyle);
  svg.Text(
      {kGap, 24},
      fmt::format(
          "{}reprojection {:.3f} px rms",
          report.is_pair ? fmt::format("baseline {:.4g} mm, ", 1e3 * report.rig.baseline()) : "",
          report.rig.rms_px),
      "title");
  PosesPanel(report).Draw({kGap, kTop}, &svg);
  DrawCoverage(report, false, {2 * kGap + kPanel, kTop}, &svg);
  if (report.is_pair) DrawCoverage(report, true, {3 * kGap + 2 * kPanel, kTop}, &svg);
  bars.Draw({kGap, residuals}, inside, &svg);
  double y = words;
  for (const auto& [line, style] : verdict) {
    svg.Text({kGap, y}, line, style);
    y += kLine;
  }
  WriteWholeFile(file, svg.Document());
}

}  // namespace palpate
