#include "slave/site/camera/microscope.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "slave/site/environment/painting.h"

namespace palpate::site {
namespace {

constexpr std::uint32_t kDebrisDraw = 0x6465;  // apart from what else the seed draws
constexpr double kLeastDefocus = 0.05;         // less is none [px]

double Between(std::mt19937& random, double least, double most) {
  return least + (most - least) * static_cast<double>(random()) / 4294967296.0;
}

double Wrapped(double x, double length) {
  return x - length * std::floor(x / length);
}

}  // namespace

Microscope::Microscope(const Scene& scene, const TrueBody& body, const Eigen::Affine2d& X_IO,
                       const cv::Size& size)
    : size_(size), defocus_(scene.site.embryo->defocus), glass_(size, CV_32F, cv::Scalar(1)) {
  for (const Fixed& fixed : scene.object.fixed) {
    if (const auto* arc = std::get_if<FixedArc>(&fixed.where)) {
      PaintCapillary(*arc, 0.5 * body.larger_side(), X_IO);
    }
  }
  Scatter(*scene.site.embryo, scene.site.seed);
}

// Two walls, from the ends of the held arc outwards beyond the picture.
void Microscope::PaintCapillary(const FixedArc& arc, double radius, const Eigen::Affine2d& X_IO) {
  const Eigen::Vector2d out(std::cos(arc.centre), std::sin(arc.centre)), aside(-out.y(), out.x());
  const double length = 1e3 * radius;
  for (const double side : {-1.0, 1.0}) {
    const double grip = std::sin(std::min(arc.half_angle, 0.5 * std::numbers::pi)) * radius;
    const double from = std::sqrt(radius * radius - grip * grip);
    const double outer = grip + kWall;
    std::vector<Eigen::Vector2d> wall;
    for (const Eigen::Vector2d& p :
         {Eigen::Vector2d(from, grip), Eigen::Vector2d(length, grip),
          Eigen::Vector2d(length, outer), Eigen::Vector2d(from, outer)}) {
      wall.emplace_back(X_IO * Eigen::Vector2d(p.x() * out + side * p.y() * aside));
    }
    const cv::Rect window = WindowAround(wall, 1, size_);
    if (window.empty()) continue;
    Coverage coverage(window);
    coverage.Add(wall);
    cv::Mat alpha;
    coverage.Resolve(alpha);
    cv::Mat part = glass_(window);
    cv::scaleAdd(alpha, kGlass - 1, part, part);
  }
}

void Microscope::Scatter(const EmbryoSite& options, std::uint32_t seed) {
  std::seed_seq sequence{seed, kDebrisDraw};
  std::mt19937 random(sequence);
  for (int i = 0; i < options.debris; ++i) {
    Particle particle;
    particle.p_I = {Between(random, 0, size_.width), Between(random, 0, size_.height)};
    const double speed = Between(random, kSlowest, kFastest);
    const double heading = Between(random, 0, 2 * std::numbers::pi);
    particle.v_I = speed * Eigen::Vector2d(std::cos(heading), std::sin(heading));
    particle.radius = Between(random, 1.5, 5);
    particle.light = static_cast<float>(Between(random, 0.6, 1.1));
    debris_.push_back(particle);
  }
}

// A soft round spot.
void Microscope::Cover(const Particle& particle, cv::Mat* seen) {
  const int reach = static_cast<int>(std::ceil(2.5 * particle.radius));
  const cv::Point middle(static_cast<int>(particle.p_I.x()), static_cast<int>(particle.p_I.y()));
  const cv::Rect box = cv::Rect(middle.x - reach, middle.y - reach, 2 * reach + 1, 2 * reach + 1) &
                       cv::Rect({0, 0}, seen->size());
  for (int y = box.y; y < box.y + box.height; ++y) {
    auto* row = seen->ptr<float>(y);
    for (int x = box.x; x < box.x + box.width; ++x) {
      const double away = (Eigen::Vector2d(x, y) - particle.p_I).squaredNorm();
      const double share = std::exp(-away / (particle.radius * particle.radius));
      row[x] *= 1 - static_cast<float>(share) * (1 - particle.light);
    }
  }
}

void Microscope::Show(cv::Mat* seen) {
  cv::multiply(*seen, glass_, *seen);
  for (Particle& particle : debris_) {
    Cover(particle, seen);
    particle.p_I += particle.v_I;
    particle.p_I.x() = Wrapped(particle.p_I.x(), size_.width);
    particle.p_I.y() = Wrapped(particle.p_I.y(), size_.height);
  }
  const double phase = 2 * std::numbers::pi * static_cast<double>(pictures_++) / kFocusPeriod;
  const double sigma = defocus_ * 0.5 * (1 - std::cos(phase));
  if (sigma > kLeastDefocus) cv::GaussianBlur(*seen, *seen, {}, sigma);
}

}  // namespace palpate::site
