#include "slave/scene/membrane_limits.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <variant>

namespace palpate {
namespace {

constexpr double kMaxThickness = 0.1, kMinThickness = 1.0 / 400;  // relative to the radius
constexpr double kMinToolWidth = 1.0 / 50, kMaxToolWidth = 1;     // relative to the radius
constexpr double kMaxModelToolWidth = 1.8;                        // relative to the radius
constexpr double kMaxPlace = 0.75;   // distance of presses from the centre, by the radius
constexpr double kMaxDepth = 0.5;    // depth of presses, by the radius
constexpr double kMaxStretch = 0.5;  // prestress by E t

// A number of metres in millimetres, to six digits.
std::string Millimetres(double length) {
  std::ostringstream text;
  text << 1e3 * length << " mm";
  return text.str();
}

}  // namespace

MembraneLimits::MembraneLimits(const Scene& scene) : scene_(scene) {
  const auto* membrane = std::get_if<MembraneGeometry>(&scene.object.geometry);
  if (membrane == nullptr) return;
  radius_ = membrane->radius;
  thickness_ = membrane->thickness;
  const auto* stereo = scene.sense.Find<StereoCameras>();
  is_simulated_ = stereo && stereo->source == StereoCameras::Source::kSimulated;
  if (is_simulated_) {
    min_width_ = std::max(thickness_, kMinToolWidth * radius_);
    max_width_ = kMaxToolWidth * radius_;
    widths_ = Millimetres(min_width_) + " to " + Millimetres(max_width_) +
              " (the thickness, at least radius / 50, to the radius)";
  } else {
    min_width_ = kMinValue;
    max_width_ = 0.999 * kMaxModelToolWidth * radius_;
    widths_ = "> 0, less than " + Millimetres(kMaxModelToolWidth * radius_) + " (1.8 radius)";
  }
}

Rule MembraneLimits::width_rule() const {
  const bool are_limits = apply() && allows_thickness();
  return are_limits ? Rule{Dimension::kLength, min_width_, max_width_, widths_}
                    : SceneKeyAt("tool.width").rule;
}

bool MembraneLimits::allows_thickness() const {
  return thickness_ <= kMaxThickness * radius_ &&
         (!is_simulated_ || thickness_ >= kMinThickness * radius_);
}

std::string MembraneLimits::thickness() const {
  const std::string most = Millimetres(kMaxThickness * radius_);
  return is_simulated_ ? Millimetres(kMinThickness * radius_) + " to " + most +
                             " (radius / 400 to radius / 10)"
                       : "> 0 to " + most + " (radius / 10)";
}

double MembraneLimits::max_prestress() const {
  return kMaxStretch * scene_.object.material.young_modulus * thickness_;
}

bool MembraneLimits::allows_prestress() const {
  return scene_.model.prestress <= max_prestress();
}

double MembraneLimits::max_press() const {
  return kMaxDepth * radius_;
}

bool MembraneLimits::allows_press() const {
  return scene_.operator_options.press_depth <= max_press();
}

std::string MembraneLimits::press() const {
  return "> 0 to " + Millimetres(max_press()) + " (radius / 2)";
}

std::string MembraneLimits::prestress() const {
  std::ostringstream text;
  text << "0 to " << max_prestress() << " N/m (half of young_modulus times thickness)";
  return text.str();
}

double MembraneLimits::reach() const {
  const double width = scene_.tool ? scene_.tool->width : 0;
  return std::max(0.0, std::min(kMaxPlace * radius_, radius_ - width));
}

bool MembraneLimits::allows_home() const {
  Eigen::Isometry3d X_SO = scene_.object.X_SO;
  X_SO.translation().head<2>() += scene_.site.misplacement;
  const Eigen::Vector3d p_O = X_SO.inverse() * scene_.manipulator.home;
  return p_O.z() > 0 && p_O.head<2>().norm() <= reach() + 1e-9 * radius_;
}

std::string MembraneLimits::home() const {
  return "a position in front of the membrane with the tool clear of the rim: at most " +
         Millimetres(reach()) + " from the axis";
}

}  // namespace palpate
