#include "tests/campaigns/robustness/paint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <random>
#include <span>
#include <string>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "slave/capture/codecs/codecs.h"

namespace palpate::robustness {
namespace {

using Eigen::Vector2d;

constexpr double kWhite = 255;
constexpr double kCover = 140;  // grey level of covers; differs from tool, background and object

cv::Point2f At(const Vector2d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y())};
}
Vector2d Across(const View& view) {
  return {-view.shaft_I.y(), view.shaft_I.x()};
}
Vector2d MiddleOf(const cv::Mat& image) {
  return {0.5 * (image.cols - 1), 0.5 * (image.rows - 1)};
}
double Radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}
Vector2d Along(double degrees) {
  return {std::cos(Radians(degrees)), std::sin(Radians(degrees))};
}

// Returns a random generator seeded for this image.
std::mt19937_64 RandomOf(const Moment& moment, std::uint64_t what) {
  return std::mt19937_64{(moment.index * 2 + static_cast<std::uint64_t>(moment.side)) * 1000 +
                         what};
}

// Fills a polygon with anti-aliased edges. Its corners are rounded to 1/16 pixel.
void FillPolygon(cv::Mat& image, std::span<const Vector2d> corners, double grey) {
  constexpr int kShift = 4;
  std::vector<cv::Point> points;
  for (const Vector2d& p : corners) {
    points.emplace_back(static_cast<int>(std::lround(p.x() * (1 << kShift))),
                        static_cast<int>(std::lround(p.y() * (1 << kShift))));
  }
  cv::fillConvexPoly(image, points, cv::Scalar(grey), cv::LINE_AA, kShift);
}

void FillDisc(cv::Mat& image, const Vector2d& at, double radius, double grey) {
  constexpr int kShift = 4;
  const auto fixed = [](double x) { return static_cast<int>(std::lround(x * (1 << kShift))); };
  cv::circle(image, {fixed(at.x()), fixed(at.y())}, fixed(radius), cv::Scalar(grey), -1,
             cv::LINE_AA, kShift);
}

// A bar of `width` from `a` to `b`.
void FillBar(cv::Mat& image, const Vector2d& a, const Vector2d& b, double width, double grey) {
  const Vector2d way = (b - a).normalized();
  const Vector2d half = 0.5 * width * Vector2d(-way.y(), way.x());
  FillPolygon(image, std::array<Vector2d, 4>{a - half, a + half, b + half, b - half}, grey);
}

// `light`: CV_32F, 1: as it was.
void Relight(cv::Mat& image, const cv::Mat& light) {
  cv::multiply(image, light, image, 1, CV_8U);
}

// Resamples the image: pixel p comes from p_from = linear (p - centre) + centre + by.
void Resample(cv::Mat& image, const Eigen::Matrix2d& linear, const Vector2d& by) {
  const Vector2d middle = MiddleOf(image);
  const Vector2d offset = middle - linear * middle + by;
  const cv::Mat from = (cv::Mat_<double>(2, 3) << linear(0, 0), linear(0, 1), offset.x(),
                        linear(1, 0), linear(1, 1), offset.y());
  cv::Mat moved;
  cv::warpAffine(image, moved, from, image.size(), cv::INTER_CUBIC | cv::WARP_INVERSE_MAP,
                 cv::BORDER_REPLICATE);
  image = moved;
}
void Shift(cv::Mat& image, const Vector2d& by) {
  Resample(image, Eigen::Matrix2d::Identity(), -by);
}

// The light field is computed for the first image and reused for all images of the same size.
Paint WithLight(std::function<cv::Mat(const cv::Size&)> make) {
  return [make = std::move(make), kept = std::make_shared<cv::Mat>()](const View&, cv::Mat& image) {
    if (kept->size() != image.size()) *kept = make(image.size());
    Relight(image, *kept);
  };
}

// Standard normal noise, larger than an image; each image uses another part of it.
const cv::Mat& NoiseBank(const cv::Size& size) {
  constexpr int kMargin = 256;
  static cv::Mat bank;
  if (bank.cols < size.width + kMargin || bank.rows < size.height + kMargin) {
    bank.create(size.height + kMargin, size.width + kMargin, CV_32F);
    cv::RNG(7).fill(bank, cv::RNG::NORMAL, 0, 1);
  }
  return bank;
}

}  // namespace

Paint All(std::vector<Paint> paints) {
  return [paints = std::move(paints)](const View& view, cv::Mat& image) {
    for (const Paint& paint : paints) paint(view, image);
  };
}

Paint OnSide(int side, Paint paint) {
  return [side, paint = std::move(paint)](const View& view, cv::Mat& image) {
    if (view.side == side) paint(view, image);
  };
}

Paint From(When when, Paint paint) {
  return [when, paint = std::move(paint)](const View& view, cv::Mat& image) {
    if (IsSo(when, view)) paint(view, image);
  };
}

Paint Flicker(double strength) {
  return [strength](const View& view, cv::Mat& image) {
    // One light for both cameras. Incommensurable with the images, like mains light.
    const double gain = 1 + strength * std::sin(2.4 * static_cast<double>(view.index));
    image.convertTo(image, CV_8U, gain);
  };
}

Paint Vignette(double fall) {
  return WithLight([fall](const cv::Size& size) {
    cv::Mat light(size, CV_32F);
    const Vector2d middle = MiddleOf(light);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const double r = (Vector2d(x, y) - middle).squaredNorm() / middle.squaredNorm();
        light.at<float>(y, x) = static_cast<float>(1 - fall * r);
      }
    }
    return light;
  });
}

Paint Gain(double factor) {
  return [factor](const View&, cv::Mat& image) { image.convertTo(image, CV_8U, factor); };
}

Paint Gamma(double exponent) {
  cv::Mat table(1, 256, CV_8U);
  for (int i = 0; i < 256; ++i) {
    table.at<std::uint8_t>(i) =
        cv::saturate_cast<std::uint8_t>(kWhite * std::pow(i / kWhite, exponent));
  }
  return [table](const View&, cv::Mat& image) { cv::LUT(image, table, image); };
}

Paint Shadow(double depth) {
  return [depth](const View& view, cv::Mat& image) {
    constexpr double kHalfWidth = 50, kEdge = 6, kWanders = 60;  // [px]
    const double place = view.tip_I.x() - kWanders + 2 * kWanders * view.share();
    cv::Mat row(1, image.cols, CV_32F);
    for (int x = 0; x < image.cols; ++x) {
      const double inside = (kHalfWidth - std::abs(x - place)) / kEdge;
      row.at<float>(x) = static_cast<float>(1 - depth / (1 + std::exp(-inside)));
    }
    Relight(image, cv::repeat(row, image.rows, 1));
  };
}

Paint GlintOnTip(double radius) {
  return GlintOnShaft(radius, radius);
}

Paint GlintOnShaft(double radius, double along) {
  return [=](const View& view, cv::Mat& image) {
    FillDisc(image, view.tip_I + along * view.shaft_I, radius, kWhite);
  };
}

Paint GlintStanding(double radius, double along) {
  return [=](const View& view, cv::Mat& image) {
    FillDisc(image, view.pressed_I + along * view.shaft_I, radius, kWhite);
  };
}

Paint Wire(double width, double degrees, double off, double grey) {
  return [=](const View& view, cv::Mat& image) {
    constexpr double kFar = 2000;  // [px]
    const Vector2d through = view.pressed_I + off * view.shaft_I;
    FillBar(image, through - kFar * Along(degrees), through + kFar * Along(degrees), width, grey);
  };
}

Paint CoveredSide(double share) {
  return [share](const View& view, cv::Mat& image) {
    constexpr double kFar = 2000, kBeyond = 4;  // [px]
    const double width = share * view.width + kBeyond;
    const Vector2d middle = view.tip_I + (0.5 * view.width + kBeyond - 0.5 * width) * Across(view);
    FillBar(image, middle, middle + kFar * view.shaft_I, width, kCover);
  };
}

Paint CoveredPiece(double from, double to) {
  return [=](const View& view, cv::Mat& image) {
    const Vector2d& tip = view.pressed_I;
    FillBar(image, tip + from * view.shaft_I, tip + to * view.shaft_I, 3 * view.width, kCover);
  };
}

Paint Hand(double reach, When when) {
  return From(when, [=](const View& view, cv::Mat& image) {
    constexpr double kRadius = 90;  // [px]
    FillDisc(image,
             view.pressed_I + (kRadius - reach) * view.shaft_I + 0.5 * kRadius * Across(view),
             kRadius, 165);
  });
}

Paint Patches(std::vector<Vector2d> at_I, double radius, double grey) {
  return [at_I = std::move(at_I), radius, grey](const View&, cv::Mat& image) {
    for (const Vector2d& at : at_I) FillDisc(image, at, radius, grey);
  };
}

Paint Defocus(double sigma) {
  return [sigma](const View&, cv::Mat& image) {
    cv::GaussianBlur(image, image, {}, sigma, sigma, cv::BORDER_REPLICATE);
  };
}

Paint MotionBlur(double length, double degrees) {
  // The kernel is a line of `length` that is a pixel wide; its values are pixel coverages.
  const int half = static_cast<int>(std::ceil(0.5 * length)) + 1;
  cv::Mat kernel(2 * half + 1, 2 * half + 1, CV_32F, cv::Scalar(0));
  constexpr int kPieces = 400;
  for (int i = 0; i < kPieces; ++i) {
    const Vector2d p = ((i + 0.5) / kPieces - 0.5) * length * Along(degrees);
    const int x = static_cast<int>(std::floor(p.x())), y = static_cast<int>(std::floor(p.y()));
    const auto fx = static_cast<float>(p.x() - x), fy = static_cast<float>(p.y() - y);
    kernel.at<float>(half + y, half + x) += (1 - fx) * (1 - fy);
    kernel.at<float>(half + y, half + x + 1) += fx * (1 - fy);
    kernel.at<float>(half + y + 1, half + x) += (1 - fx) * fy;
    kernel.at<float>(half + y + 1, half + x + 1) += fx * fy;
  }
  kernel /= cv::sum(kernel)[0];
  return [kernel](const View&, cv::Mat& image) {
    cv::Mat blurred;
    cv::filter2D(image, blurred, -1, kernel, {-1, -1}, 0, cv::BORDER_REPLICATE);
    image = blurred;
  };
}

Paint Noise(double sigma) {
  return [sigma](const View& view, cv::Mat& image) {
    const cv::Mat& bank = NoiseBank(image.size());
    auto random = RandomOf(view, 1);
    const auto from = [&](int extra) {
      return static_cast<int>(random() % static_cast<std::uint64_t>(extra));
    };
    const int x = from(bank.cols - image.cols), y = from(bank.rows - image.rows);
    cv::Mat noisy;
    image.convertTo(noisy, CV_32F);
    noisy += sigma * bank({x, y, image.cols, image.rows});
    noisy.convertTo(image, CV_8U);
  };
}

Paint Jpeg(int quality) {
  return [quality](const View&, cv::Mat& image) {
    const std::string bytes = EncodeJpeg(image, quality);
    image =
        OpenJpeg({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()})->Decode();
  };
}

Paint Bump(const Vector2d& by, When when) {
  return From(when, [by](const View&, cv::Mat& image) { Shift(image, by); });
}

Paint Shake(double sigma) {
  return [sigma](const View& view, cv::Mat& image) {
    if (view.index == 0) return;
    auto random = RandomOf(view, 2);
    std::normal_distribution<double> normal(0, sigma);
    const double x = normal(random), y = normal(random);
    Shift(image, {x, y});
  };
}

Paint Drift(const Vector2d& by) {
  return [by](const View& view, cv::Mat& image) { Shift(image, view.share() * by); };
}

Paint Zoom(double factor, When when) {
  return From(when, [factor](const View&, cv::Mat& image) {
    Resample(image, Eigen::Matrix2d::Identity() / factor, {0, 0});
  });
}

Paint Turn(double degrees, When when) {
  const Vector2d x = Along(degrees);
  Eigen::Matrix2d turn;
  turn << x.x(), -x.y(), x.y(), x.x();
  return From(when, [turn](const View&, cv::Mat& image) { Resample(image, turn, {0, 0}); });
}

Paint Barrel(double px) {
  return [px, from = std::make_shared<cv::Mat>()](const View&, cv::Mat& image) {
    if (from->size() != image.size()) {
      from->create(image.size(), CV_32FC2);
      const Vector2d middle = MiddleOf(image);
      const double k = px / (middle.norm() * middle.squaredNorm());
      for (int y = 0; y < image.rows; ++y) {
        for (int x = 0; x < image.cols; ++x) {
          const Vector2d r = Vector2d(x, y) - middle;
          const Vector2d p = middle + r * (1 + k * r.squaredNorm());
          from->at<cv::Point2f>(y, x) = At(p);
        }
      }
    }
    cv::Mat bent;
    cv::remap(image, bent, *from, cv::Mat(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    image = bent;
  };
}

}  // namespace palpate::robustness
