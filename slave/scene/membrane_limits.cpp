#include "slave/scene/membrane_limits.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <variant>

namespace palpate {
namespace {

constexpr double kThickest = 0.1, kThinnest = 1.0 / 400;  // by the radius
constexpr double kNarrowest = 1.0 / 50, kWidest = 1;      // by the radius
constexpr double kWidestOfModels = 1.8;                   // by the radius
constexpr double kFarthest = 0.75;    // distance of presses from the centre, by the radius
constexpr double kDeepest = 0.5;      // depth of presses, by the radius
constexpr double kMostStretch = 0.5;  // prestress by E t

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
    least_width_ = std::max(thickness_, kNarrowest * radius_);
    most_width_ = kWidest * radius_;
    widths_ = Millimetres(least_width_) + " to " + Millimetres(most_width_) +
              " (the thickness, at least radius / 50, to the radius)";
  } else {
    least_width_ = kSmallest;
    most_width_ = 0.999 * kWidestOfModels * radius_;
    widths_ = "> 0, less than " + Millimetres(kWidestOfModels * radius_) + " (1.8 radius)";
  }
}

Rule MembraneLimits::width_rule() const {
  const bool are_limits = apply() && allows_thickness();
  return are_limits ? Rule{Dimension::kLength, least_width_, most_width_, widths_}
                    : SceneKeyAt("tool.width").rule;
}

bool MembraneLimits::allows_thickness() const {
  return thickness_ <= kThickest * radius_ && (!is_simulated_ || thickness_ >= kThinnest * radius_);
}

std::string MembraneLimits::thickness() const {
  const std::string most = Millimetres(kThickest * radius_);
  return is_simulated_
             ? Millimetres(kThinnest * radius_) + " to " + most + " (radius / 400 to radius / 10)"
             : "> 0 to " + most + " (radius / 10)";
}

double MembraneLimits::most_prestress() const {
  return kMostStretch * scene_.object.material.young_modulus * thickness_;
}

bool MembraneLimits::allows_prestress() const {
  return scene_.model.prestress <= most_prestress();
}

double MembraneLimits::most_press() const {
  return kDeepest * radius_;
}

bool MembraneLimits::allows_press() const {
  return scene_.operator_options.press_depth <= most_press();
}

std::string MembraneLimits::press() const {
  return "> 0 to " + Millimetres(most_press()) + " (radius / 2)";
}

std::string MembraneLimits::prestress() const {
  std::ostringstream text;
  text << "0 to " << most_prestress() << " N/m (half of young_modulus times thickness)";
  return text.str();
}

double MembraneLimits::reach() const {
  const double width = scene_.tool ? scene_.tool->width : 0;
  return std::max(0.0, std::min(kFarthest * radius_, radius_ - width));
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
