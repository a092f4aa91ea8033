#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "slave/capture/image_files.h"
#include "slave/vision/tip_tracker.h"

namespace palpate {
namespace {

constexpr int kMinTemplateEdge = 5, kMaxTemplateEdge = 512;  // edge of a template [px]
constexpr int kSide = 6;                                     // background beside the tool [px]
constexpr int kTemplateReach = 10;  // search distance around the template [px]
// Margin before the tip, because the blurred end contains background [px].
constexpr double kBeforeTip = 1;
// Part beyond the tip that is included if the tool has no marks [px].
constexpr double kBeyondTip = 4;
// Largest predicted sigma of an accepted template [px], and for noisy images its growth with the
// noise [per level]: in contact the object below the tool's end shifts the tip by a pixel.
constexpr double kWorstSigma = 0.15, kWorstByNoise = 0.02;

// Search for the tool's direction: compared length of the sides [widths], distance across the side
// [px].
constexpr double kSideLength = 4, kSideStep = 2;
constexpr double kMaxTemplateTurn = 1.05, kTemplateTurnStep = 0.02;  // [rad]

bool HasContrast(const GreyPatch& pixels) {
  const auto [low, high] = std::minmax_element(pixels.levels.begin(), pixels.levels.end());
  return *high > *low;
}

// Returns the information of bands across the tool about its position along `d`, without that of
// their noise [levels^2/px^2]. The means of bands have little noise, so they contain information
// that single pixels do not.
double InformationOfBands(const TipTemplate& tip, const Eigen::Vector2d& d, double width,
                          double noise) {
  std::vector<double> sums, counts;
  for (int y = 0; y < tip.pixels.height; ++y) {
    for (int x = 0; x < tip.pixels.width; ++x) {
      const Eigen::Vector2d p = Eigen::Vector2d(x, y) - tip.anchor;
      const double aside = std::abs(p.x() * d.y() - p.y() * d.x()), behind = -p.dot(d);
      const auto pixel = static_cast<std::size_t>(y * tip.pixels.width + x);
      if (aside > 0.5 * width - kBeforeTip || behind < 0 || tip.weights[pixel] == 0) continue;
      const auto band = static_cast<std::size_t>(behind);
      if (band >= sums.size()) sums.resize(band + 1), counts.resize(band + 1);
      sums[band] += tip.pixels.At(x, y), counts[band] += 1;
    }
  }
  double information = 0;
  for (std::size_t k = 1; k + 1 < sums.size(); ++k) {
    if (counts[k - 1] == 0 || counts[k + 1] == 0) continue;
    const double change = (sums[k + 1] / counts[k + 1] - sums[k - 1] / counts[k - 1]) / 2;
    const double of_noise = noise * noise / 4 * (1 / counts[k + 1] + 1 / counts[k - 1]);
    information += counts[k] * (change * change - of_noise);
  }
  return information;
}

// Returns whether the template determines the tool's position along `d`. The gradients of noise are
// subtracted: a central difference of noise has half its variance.
bool LocatesAlong(const TipTemplate& tip, const Eigen::Vector2d& d, double width) {
  const PatchAligner aligner = tip.Aligner();
  if (!aligner.textured()) return false;
  const double noise = std::max(NoiseOf(tip.pixels), 0.5);
  double used = 0;
  for (const float w : tip.weights) used += w;
  const double of_pixels = d.dot(aligner.information() * d) - 0.5 * noise * noise * used;
  const auto least = [noise](double sigma) { return 2 * noise * noise / (sigma * sigma); };
  const double worst = std::max(kWorstSigma, kWorstByNoise * noise);
  return of_pixels > least(kWorstSigma) || InformationOfBands(tip, d, width, noise) > least(worst);
}

// Returns the axis-aligned box around a piece of the tool and kSide of background beside it. In
// direction `d` its farthest corner is `beyond` past the tip (negative: before it). Its longer
// side, nearest to the tool's direction, is `length`.
cv::Rect WindowAt(const Eigen::Vector2d& tip, const Eigen::Vector2d& d, double width, int length,
                  double beyond, const cv::Size& image) {
  const double half = 0.5 * width + kSide;
  const Eigen::Vector2d along = d.cwiseAbs(), across(along.y(), along.x());
  // Distance of the piece's end behind the tip.
  const double end = 2 * half * along.prod() - beyond;
  const double piece = std::max(12.0, (length - 2 * half * along.minCoeff()) / along.maxCoeff());
  const Eigen::Vector2d front = tip - end * d, back = tip - (end + piece) * d;
  const Eigen::Vector2d low = front.cwiseMin(back) - half * across;
  const Eigen::Vector2d high = front.cwiseMax(back) + half * across;
  const cv::Point first(static_cast<int>(std::ceil(low.x())), static_cast<int>(std::ceil(low.y())));
  const cv::Point last(static_cast<int>(std::floor(high.x())),
                       static_cast<int>(std::floor(high.y())));
  return cv::Rect(first, last + cv::Point(1, 1)) & cv::Rect(cv::Point(), image);
}

// Returns the weight of a template pixel. It is small beside the tool's end, and beyond the circle
// of a round end, where the indented object is visible.
float WeightAt(const Eigen::Vector2d& p_tip, const Eigen::Vector2d& d, const ToolEndSize& tool) {
  const double behind = -p_tip.dot(d);
  const double aside = std::abs(p_tip.x() * d.y() - p_tip.y() * d.x());
  const bool is_beyond = tool.radius > 0 && behind < tool.radius &&
                         std::hypot(aside, tool.radius - behind) > tool.radius - kBeforeTip;
  const bool is_beside = aside > 0.5 * tool.width && behind < std::max(3.0, 0.5 * tool.width);
  return is_beyond || is_beside ? 0.0F : 1.0F;
}

void SetWeights(const ToolEndSize& tool, TipTemplate* tip) {
  tip->weights.clear();
  for (int y = 0; y < tip->pixels.height; ++y) {
    for (int x = 0; x < tip->pixels.width; ++x) {
      tip->weights.push_back(WeightAt(Eigen::Vector2d(x, y) - tip->anchor, tip->along, tool));
    }
  }
}

TipTemplate CutTemplate(const cv::Mat& first, const GreyFormat& format, const cv::Rect& window,
                        const Eigen::Vector2d& tip, const Eigen::Vector2d& d,
                        const ToolEndSize& tool) {
  TipTemplate cut;
  format.Read(first, window, cut.pixels);
  cut.along = d;
  cut.anchor = tip - Eigen::Vector2d(window.x, window.y);
  SetWeights(tool, &cut);
  return cut;
}

// Returns the change across the weaker side of a bar that points along `d`, so that a single edge
// is not taken for a bar.
double SidesOf(const GreyPatch& image, const Eigen::Vector2d& p_tip, const Eigen::Vector2d& d,
               double width) {
  const Eigen::Vector2d across(-d.y(), d.x());
  const auto level = [&](const Eigen::Vector2d& p) {
    const int x = std::clamp(static_cast<int>(std::lround(p.x())), 0, image.width - 1);
    const int y = std::clamp(static_cast<int>(std::lround(p.y())), 0, image.height - 1);
    return static_cast<double>(image.At(x, y));
  };
  double weaker = std::numeric_limits<double>::infinity();
  for (const double side : {-1.0, 1.0}) {
    double sum = 0;
    for (double behind = 0.25 * width; behind < kSideLength * width; ++behind) {
      const Eigen::Vector2d p = p_tip - behind * d + side * 0.5 * width * across;
      sum += level(p + side * kSideStep * across) - level(p - side * kSideStep * across);
    }
    weaker = std::min(weaker, std::abs(sum));
  }
  return weaker;
}

}  // namespace

PatchAligner TipTemplate::Aligner() const {
  std::vector<float> inside;
  for (int y = 1; y + 1 < pixels.height; ++y) {
    const auto row = weights.begin() + y * pixels.width;
    inside.insert(inside.end(), row + 1, row + pixels.width - 1);
  }
  PatchAligner aligner({pixels.width - 2, pixels.height - 2}, inside);
  aligner.Cut(pixels.Mat(), {Eigen::Matrix2d::Identity(), Centre()}, PatchAligner::Freedom::kShift);
  return aligner;
}

Eigen::Vector2d TipTemplate::Centre() const {
  return 0.5 * Eigen::Vector2d(pixels.width - 1, pixels.height - 1);
}

Eigen::Vector2d FindToolDirection(const cv::Mat& first, const GreyFormat& format,
                                  const Eigen::Vector2d& p_I_tip, const Eigen::Vector2d& towards,
                                  double width) {
  GreyPatch image;
  format.Read(first, cv::Rect(cv::Point(), first.size()), image);
  const Eigen::Vector2d straight = towards.stableNormalized();
  Eigen::Vector2d best = straight;
  double most = 0;
  for (double angle = -kMaxTemplateTurn; angle <= kMaxTemplateTurn; angle += kTemplateTurnStep) {
    const Eigen::Vector2d d = Eigen::Rotation2Dd(angle) * straight;
    const double sides = SidesOf(image, p_I_tip, d, width);
    if (sides > most) most = sides, best = d;
  }
  return best;
}

TipTemplate LoadTipTemplate(const TipTracking& options, const Eigen::Vector2d& d_I,
                            const ToolEndSize& tool) {
  const auto refuse = [&](const std::string& why) {
    throw std::runtime_error("sense.tip.template = " + options.template_file.string() + ": " + why);
  };
  TipTemplate tip;
  try {
    const cv::Mat image = ReadImage(options.template_file, 1, [](const cv::Size& size) {
      const auto [smaller, larger] = std::minmax(size.width, size.height);
      if (smaller >= kMinTemplateEdge && larger <= kMaxTemplateEdge) return;
      throw std::runtime_error(std::to_string(size.width) + " x " + std::to_string(size.height) +
                               " px: expected edges of " + std::to_string(kMinTemplateEdge) +
                               " to " + std::to_string(kMaxTemplateEdge) + " px");
    });
    GreyFormat(image).Read(image, cv::Rect(cv::Point(), image.size()), tip.pixels);
  } catch (const std::runtime_error& error) {
    refuse(error.what());
  }
  if (!HasContrast(tip.pixels)) refuse("the template has no contrast");
  tip.anchor = options.anchor.value_or(
      Eigen::Vector2d(0.5 * (tip.pixels.width - 1), tip.pixels.height - 0.5));
  tip.weights.assign(tip.pixels.levels.size(), 1.0F);
  if (d_I.isZero(0) || !(tool.width > 0)) return tip;
  tip.along = d_I;
  for (const double radius : {tool.radius, 0.0}) {
    SetWeights({tool.width, radius}, &tip);
    if (LocatesAlong(tip, d_I, tool.width)) break;
  }
  return tip;
}

TipTemplate CutTipTemplate(const cv::Mat& first, const GreyFormat& format,
                           const Eigen::Vector2d& p_I_tip, const Eigen::Vector2d& d_I,
                           const ToolEndSize& tool, int roi) {
  const auto refuse = [&](const std::string& why) {
    std::ostringstream message;
    message << "template cut at the tool's position (" << p_I_tip.x() << ", " << p_I_tip.y()
            << ") px in the first image: " << why;
    throw std::runtime_error(message.str());
  };
  const bool inside = (p_I_tip.array() >= 0).all() && p_I_tip.x() <= first.cols - 1 &&
                      p_I_tip.y() <= first.rows - 1;  // false for NaN
  if (!inside) refuse("outside the image");
  if (!(tool.width > 0) || tool.width > kMaxTemplateEdge - 2 * kSide)
    refuse("the tool is too wide in the image");
  const int length = std::clamp(roi - 2 * kTemplateReach, 12, kMaxTemplateEdge);
  TipTemplate tip;
  for (const double beyond : {-kBeforeTip, kBeyondTip}) {
    const cv::Rect window = WindowAt(p_I_tip, d_I, tool.width, length, beyond, first.size());
    if (std::min(window.width, window.height) < kMinTemplateEdge) {
      refuse("too little of the tool is in the image");
    }
    const double radius = beyond < 0 ? tool.radius : 0;
    tip = CutTemplate(first, format, window, p_I_tip, d_I, {tool.width, radius});
    if (LocatesAlong(tip, d_I, tool.width)) break;
  }
  if (!HasContrast(tip.pixels)) refuse("no contrast");
  return tip;
}

}  // namespace palpate
