#include "slave/vision/tool_end.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace palpate {
namespace {

using Eigen::Vector2d;

constexpr double kReach = 8;        // of the end, and of a side, from where it is told [px]
constexpr double kBeside = 6;       // the ground is looked at so far beside the tool [px]
constexpr double kBehind = 4;       // the sides are looked at from so far behind the tip on [px]
constexpr double kLength = 24;      // over such a length [px]
constexpr double kStep = 0.5;       // of a line [px]
constexpr double kStays = 2;        // that it must be ground beyond the end [px]
constexpr double kFaintest = 0.2;   // a mark's difference from the ground, of the usual
constexpr double kLeastStep = 12;   // between tool and ground [1/255 of full scale]
constexpr double kPlain = 0.25;     // scatter of the ground, of that step
constexpr double kMostLost = 0.25;  // of the lines
constexpr double kBlunt = 1;        // scatter of the lines [px]

double MedianOf(std::vector<double> values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double ScatterOf(std::vector<double> values) {
  const double middle = MedianOf(values);
  for (double& value : values) value = std::abs(value - middle);
  return 1.4826 * MedianOf(std::move(values));
}

class Lines {
 public:
  Lines(const cv::Mat& first, const GreyFormat& format) {
    format.Read(first, cv::Rect(0, 0, first.cols, first.rows), picture_);
  }

  // Bilinear; outside the picture that of its border.
  [[nodiscard]] double At(const Vector2d& p) const {
    const double x = std::clamp(p.x(), 0.0, picture_.width - 1.001);
    const double y = std::clamp(p.y(), 0.0, picture_.height - 1.001);
    const int left = static_cast<int>(x), top = static_cast<int>(y);
    const double u = x - left, v = y - top;
    return (1 - v) * ((1 - u) * picture_.At(left, top) + u * picture_.At(left + 1, top)) +
           v * ((1 - u) * picture_.At(left, top + 1) + u * picture_.At(left + 1, top + 1));
  }

  // How far from `p` along the unit vector `out` the tool ends, seen from outside; `step`: usual
  // difference of tool and ground. nullopt: no ground within `most`, or no tool.
  [[nodiscard]] std::optional<double> Crossing(const Vector2d& p, const Vector2d& out,
                                               double ground, double step, double most) const {
    const Vector2d aside(-out.y(), out.x());
    const auto contrast = [&](double s) {
      const Vector2d at = p + s * out;
      return std::abs((At(at - aside) + At(at) + At(at + aside)) / 3 - ground);
    };
    double plain = 0;  // length of ground seen
    for (double s = most; s >= 0; s -= kStep) {
      double inside = 0;
      for (const double back : {3.0, 4.0, 5.0}) inside += contrast(s - back) / 3;
      const double here = contrast(s), half = 0.5 * inside;
      const bool is_tool = inside > kFaintest * step && here >= half;
      if (!is_tool) {
        plain += kStep;
        continue;
      }
      if (plain < kStays) return std::nullopt;
      const double beyond = contrast(s + kStep);
      return s + kStep * std::clamp((here - half) / std::max(here - beyond, 1e-9), 0.0, 1.0);
    }
    return std::nullopt;
  }

 private:
  GreyPatch picture_;
};

// Of all lines; nullopt: too many have none, or they scatter.
std::optional<double> Together(const std::vector<std::optional<double>>& found) {
  std::vector<double> values;
  for (const auto& value : found) {
    if (value) values.push_back(*value);
  }
  const auto all = static_cast<double>(found.size());
  if (values.size() < 3 || static_cast<double>(values.size()) < (1 - kMostLost) * all) {
    return std::nullopt;
  }
  if (ScatterOf(values) > kBlunt) return std::nullopt;
  return MedianOf(std::move(values));
}

}  // namespace

std::optional<ToolEnd> SeeToolEnd(const cv::Mat& first, const GreyFormat& format,
                                  const Vector2d& p_I_tip, const Vector2d& d_I, double width) {
  const Vector2d across(-d_I.y(), d_I.x());
  const Lines lines(first, format);
  std::vector<double> ground, tool;
  for (double behind = kReach + kBehind; behind < kReach + kLength; ++behind) {
    const Vector2d axis = p_I_tip - behind * d_I;
    for (const double side : {-1.0, 1.0}) {
      ground.push_back(lines.At(axis + side * (0.5 * width + kBeside) * across));
      tool.push_back(lines.At(axis + side * 0.2 * width * across));
    }
  }
  const double level = MedianOf(ground);
  const double step = std::abs(MedianOf(tool) - level);
  if (step < kLeastStep * format.levels_per_255() || ScatterOf(ground) > kPlain * step) {
    return std::nullopt;
  }
  std::vector<std::optional<double>> ends, left, right;
  for (double c = -0.35 * width; c <= 0.35 * width; ++c) {
    const Vector2d from = p_I_tip + c * across - kReach * d_I;
    ends.push_back(lines.Crossing(from, d_I, level, step, 2 * kReach));
  }
  for (double behind = kReach + kBehind; behind < kReach + kLength; ++behind) {
    const Vector2d axis = p_I_tip - behind * d_I;
    left.push_back(lines.Crossing(axis, across, level, step, 0.5 * width + kBeside));
    right.push_back(lines.Crossing(axis, -across, level, step, 0.5 * width + kBeside));
  }
  const auto end = Together(ends), one = Together(left), other = Together(right);
  if (!end || !one || !other) return std::nullopt;
  return ToolEnd{*end - kReach, (*one - *other) / 2, *one + *other};
}

}  // namespace palpate
