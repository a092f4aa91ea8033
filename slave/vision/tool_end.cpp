#include "slave/vision/tool_end.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "slave/statistics/robust.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

// Distance of the end, and of a side, from its stated place [px]. [tuned:
// IsNotFoundWhereTheToolContinues]
constexpr double kEndReach = 8;
// Distance beside the tool at which the background is measured [px]. [tuned:
// AWidthWrongByAFifthIsDetected]
constexpr double kSideWidth = 6;
// Distance behind the tip from which the sides are measured [px]. [tuned:
// IsNotFoundWhereTheToolContinues]
constexpr double kBehind = 4;
constexpr double kLength = 24;     // length over which the sides are compared [px]
constexpr double kLineStep = 0.5;  // of a line [px]
// Length of background required beyond the end [px]. [tuned: IsFoundIndependentOfTheReportedTip]
constexpr double kStays = 2;
// Smallest difference of a mark from the background, relative to the usual one.
constexpr double kFaintest = 0.2;
// Smallest step between tool and background [1/255 of full scale].
constexpr double kMinToolStep = 12;
constexpr double kPlain = 0.25;    // largest scatter of the background relative to that step
constexpr double kMaxLost = 0.25;  // largest fraction of lines without an end
constexpr double kBlunt = 1;       // largest scatter of the lines [px]
constexpr double kAsStraight = 2;  // largest deviation of a side that continues [px]

class Lines {
 public:
  Lines(const cv::Mat& first, const GreyFormat& format) {
    format.Read(first, cv::Rect(0, 0, first.cols, first.rows), image_);
  }

  // Interpolates bilinearly; outside the image the border value is used.
  [[nodiscard]] double At(const Vector2d& p) const {
    const double x = std::clamp(p.x(), 0.0, image_.width - 1.001);
    const double y = std::clamp(p.y(), 0.0, image_.height - 1.001);
    const int left = static_cast<int>(x), top = static_cast<int>(y);
    return Bilinear(image_.Row(top) + left, image_.width, static_cast<float>(x - left),
                    static_cast<float>(y - top));
  }

  // Returns the distance from `p` along the unit vector `out` at which the tool ends, searched from
  // outside; `step`: usual difference of tool and background. nullopt: no background within `most`,
  // or no tool.
  [[nodiscard]] std::optional<double> Crossing(const Vector2d& p, const Vector2d& out,
                                               double ground, double step, double most) const {
    const Vector2d aside(-out.y(), out.x());
    const auto contrast = [&](double s) {
      const Vector2d at = p + s * out;
      return std::abs((At(at - aside) + At(at) + At(at + aside)) / 3 - ground);
    };
    double plain = 0;  // length of visible background
    for (double s = most; s >= 0; s -= kLineStep) {
      double inside = 0;
      for (const double back : {3.0, 4.0, 5.0}) inside += contrast(s - back) / 3;
      const double here = contrast(s), half = 0.5 * inside;
      const bool is_tool = inside > kFaintest * step && here >= half;
      if (!is_tool) {
        plain += kLineStep;
        continue;
      }
      if (plain < kStays) return std::nullopt;
      const double beyond = contrast(s + kLineStep);
      return s + kLineStep * std::clamp((here - half) / std::max(here - beyond, 1e-9), 0.0, 1.0);
    }
    return std::nullopt;
  }

 private:
  GreyPatch image_;
};

// Returns the mean of all lines; nullopt: too many lines have no end, or they scatter.
std::optional<double> Together(const std::vector<std::optional<double>>& found) {
  std::vector<double> values;
  for (const auto& value : found) {
    if (value) values.push_back(*value);
  }
  const auto all = static_cast<double>(found.size());
  if (values.size() < 3 || static_cast<double>(values.size()) < (1 - kMaxLost) * all) {
    return std::nullopt;
  }
  if (SigmaAboutMedian(std::vector(values)) > kBlunt) return std::nullopt;
  return MedianOf(values);
}

// A bar with its stated end at `p_tip`, and the background beside it.
class Bar {
 public:
  Bar(const cv::Mat& first, const GreyFormat& format, const Vector2d& p_tip, const Vector2d& d,
      const ToolEndSize& tool)
      : lines_(first, format),
        p_tip_(p_tip),
        d_(d),
        across_(-d.y(), d.x()),
        width_(tool.width),
        radius_(tool.radius) {
    std::vector<double> ground, inside;
    for (double behind = first_behind(); behind < last_behind(); ++behind) {
      const Vector2d axis = p_tip - behind * d;
      for (const double side : {-1.0, 1.0}) {
        ground.push_back(lines_.At(axis + side * (0.5 * width_ + kSideWidth) * across_));
        inside.push_back(lines_.At(axis + side * 0.2 * width_ * across_));
      }
    }
    level_ = MedianOf(ground);
    step_ = std::abs(MedianOf(inside) - level_);
    is_prominent_ = step_ >= kMinToolStep * format.levels_per_255() &&
                    SigmaAboutMedian(ground) <= kPlain * step_;
  }

  [[nodiscard]] bool is_prominent() const { return is_prominent_; }
  // Range in which the sides must be straight [px behind the stated tip].
  [[nodiscard]] double first_behind() const { return kEndReach + kBehind + radius_; }
  [[nodiscard]] double last_behind() const { return kEndReach + kLength + radius_; }
  // Returns the distance of the end beyond the reported tip [px].
  [[nodiscard]] std::optional<double> End() const {
    std::vector<std::optional<double>> ends;
    for (double c = -0.35 * width_; c <= 0.35 * width_; ++c) {
      const Vector2d from = p_tip_ + c * across_ - (kEndReach + RecessAt(c)) * d_;
      ends.push_back(lines_.Crossing(from, d_, level_, step_, 2 * kEndReach));
    }
    const auto end = Together(ends);
    return end ? std::optional(*end - kEndReach) : std::nullopt;
  }
  // Returns the median distance of a side from the axis between `first` and `last` behind the
  // reported tip, negative beyond it [px].
  [[nodiscard]] std::optional<double> Side(double side, double first, double last) const {
    std::vector<std::optional<double>> found;
    for (double behind = first; behind < last; ++behind) {
      found.push_back(lines_.Crossing(p_tip_ - behind * d_, side * across_, level_, step_,
                                      0.5 * width_ + kSideWidth));
    }
    return Together(found);
  }

 private:
  // Returns the recess of the end at the distance `aside` from the axis [px].
  [[nodiscard]] double RecessAt(double aside) const {
    return radius_ - std::sqrt(std::max(0.0, radius_ * radius_ - aside * aside));
  }

  Lines lines_;
  Vector2d p_tip_, d_, across_;
  double width_, radius_, level_ = 0, step_ = 0;
  bool is_prominent_ = false;
};

}  // namespace

ToolEndSize EndSizeOf(const Tool& tool, double pixel) {
  const double radius = tool.shape == Tool::Shape::kRound ? tool.radius : 0;
  return {tool.width / pixel, radius / pixel};
}

std::optional<ToolEnd> DetectToolEnd(const cv::Mat& first, const GreyFormat& format,
                                     const Vector2d& p_I_tip, const Vector2d& d_I,
                                     const ToolEndSize& tool) {
  const Bar bar(first, format, p_I_tip, d_I, tool);
  if (!bar.is_prominent()) return std::nullopt;
  const auto end = bar.End(), one = bar.Side(1, bar.first_behind(), bar.last_behind()),
             other = bar.Side(-1, bar.first_behind(), bar.last_behind());
  if (!end || !one || !other) return std::nullopt;
  return ToolEnd{*end, (*one - *other) / 2, *one + *other};
}

bool ToolGoesOn(const cv::Mat& first, const GreyFormat& format, const Vector2d& p_I_tip,
                const Vector2d& d_I, const ToolEndSize& tool) {
  const Bar bar(first, format, p_I_tip, d_I, tool);
  if (!bar.is_prominent()) return false;
  for (const double side : {-1.0, 1.0}) {
    const auto behind = bar.Side(side, bar.first_behind(), bar.last_behind()),
               past = bar.Side(side, -kEndReach, -kBehind);
    if (!behind || !past || std::abs(*past - *behind) > kAsStraight) return false;
  }
  return true;
}

}  // namespace palpate
