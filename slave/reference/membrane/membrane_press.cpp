// Interpolates between the solved depths of a press, and between presses.
#include <algorithm>
#include <array>
#include <complex>
#include <cstddef>

#include "slave/reference/membrane/pressed_membrane.h"

namespace palpate::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Returns the first of the two depth steps around `depth`.
std::size_t Below(const MembranePress& press, double depth) {
  const auto above = std::ranges::upper_bound(
      press.depth_steps, depth, {}, [](const auto& depth_step) { return depth_step->depth; });
  const auto index = static_cast<std::size_t>(above - press.depth_steps.begin());
  return std::clamp<std::size_t>(index, 1, press.depth_steps.size() - 1) - 1;
}

double Chord(const MembranePress& press, std::size_t i) {
  const MembraneDepthStep &a = *press.depth_steps[i], &b = *press.depth_steps[i + 1];
  return (b.force - a.force) / (b.depth - a.depth);
}

// Returns a depth step; for i < 0 the pulling one, which is its negative by symmetry.
double DepthOf(const MembranePress& press, int i) {
  return i < 0 ? -DepthOf(press, -i) : press.depth_steps[static_cast<std::size_t>(i)]->depth;
}
double ForceOf(const MembranePress& press, int i) {
  return i < 0 ? -ForceOf(press, -i) : press.depth_steps[static_cast<std::size_t>(i)]->force;
}

// Returns the slope at a depth step: that of the polynomial through it and up to two depth steps on
// either side.
double Slope(const MembranePress& press, std::size_t depth_step) {
  const int at = static_cast<int>(depth_step),
            last = static_cast<int>(press.depth_steps.size()) - 1;
  const int first = std::max(at - 2, -last), end = std::min(at + 2, last);
  double slope = 0;
  for (int i = first; i <= end; ++i) {
    if (i == at) continue;
    const double from_at = DepthOf(press, i) - DepthOf(press, at);
    double weight = 1 / from_at;  // Lagrange's polynomial of depth step i, its slope at this one
    for (int j = first; j <= end; ++j) {
      if (j == i || j == at) continue;
      weight *= (DepthOf(press, at) - DepthOf(press, j)) / (DepthOf(press, i) - DepthOf(press, j));
    }
    slope += weight * (ForceOf(press, i) - ForceOf(press, at));
  }
  return slope;
}

// Fritsch and Carlson 1980: a cubic stays monotone if its slopes at the ends are of the chord's
// sign and at most three times as steep.
double Limited(double slope, double chord) {
  const double share = chord == 0 ? 0 : std::clamp(slope / chord, 0.0, 3.0);
  return share * chord;
}

// Returns the interpolation weights of the depth steps from one before `below` to two after it, at
// the fraction t between `below` and the next one. The cubic has at either end the slope of the
// parabola through that depth step and its neighbours (at the first and the last depth step,
// through the three nearest).

using Weights = std::array<double, 4>;

void AddSlope(const MembranePress& press, int at, int below, double factor, Weights* weights) {
  const int last = static_cast<int>(press.depth_steps.size()) - 1;
  const int first = std::clamp(at - 1, 0, std::max(0, last - 2)), end = std::min(first + 2, last);
  for (int i = first; i <= end; ++i) {
    if (i == at) continue;
    double slope = 1 / (DepthOf(press, i) - DepthOf(press, at));
    for (int j = first; j <= end; ++j) {
      if (j == i || j == at) continue;
      slope *= (DepthOf(press, at) - DepthOf(press, j)) / (DepthOf(press, i) - DepthOf(press, j));
    }
    (*weights)[static_cast<std::size_t>(i - below + 1)] += factor * slope;
    (*weights)[static_cast<std::size_t>(at - below + 1)] -= factor * slope;
  }
}

Weights WeightsAt(const MembranePress& press, std::size_t below, double t) {
  const int i = static_cast<int>(below);
  const double h = DepthOf(press, i + 1) - DepthOf(press, i), u = 1 - t;
  Weights weights{0, u * u * (1 + 2 * t), t * t * (1 + 2 * u), 0};
  AddSlope(press, i, i, h * t * u * u, &weights);
  AddSlope(press, i + 1, i, -h * t * t * u, &weights);
  return weights;
}

// Maps a point of the rotated disc (tool on the x axis at `p`) to the press solved at `q`.
Vector2d Carried(const Vector2d& point, double p, double q, double rim) {
  if (p == q) return point;
  const double m = (p - q) * rim / (rim * rim - p * q);
  const std::complex<double> z(point.x() / rim, point.y() / rim);
  const std::complex<double> w = (z - m) / (1.0 - m * z);
  return rim * Vector2d(w.real(), w.imag());
}

}  // namespace

double ForceAt(const MembranePress& press, double depth) noexcept {
  if (press.depth_steps.size() < 2 || !(depth > 0)) return 0;
  const std::size_t i = Below(press, depth);
  const MembraneDepthStep &a = *press.depth_steps[i], &b = *press.depth_steps[i + 1];
  const double h = b.depth - a.depth, t = (depth - a.depth) / h, u = 1 - t;
  const double chord = Chord(press, i);
  if (t > 1) return b.force + (depth - b.depth) * chord;
  const double at_a = Limited(Slope(press, i), chord), at_b = Limited(Slope(press, i + 1), chord);
  return u * u * ((1 + 2 * t) * a.force + t * h * at_a) +
         t * t * ((1 + 2 * u) * b.force - u * h * at_b);
}

Vector3d DisplacementAt(const MembranePress& press, const Vector2d& p_O, double depth) noexcept {
  MembraneFace::Stencil stencil;
  if (press.depth_steps.size() < 2 || !(depth > 0) || !press.face->Find(p_O, &stencil)) {
    return Vector3d::Zero();
  }
  const std::size_t i = Below(press, depth);
  const double from = press.depth_steps[i]->depth, to = press.depth_steps[i + 1]->depth;
  const Weights weights = WeightsAt(press, i, std::min((depth - from) / (to - from), 1.0));
  Vector3d displacement = Vector3d::Zero();
  for (std::size_t r = 0; r < weights.size(); ++r) {
    if (weights[r] == 0) continue;  // also zero if there is no such depth step
    const MembraneDepthStep& depth_step = *press.depth_steps[i + r - 1];
    for (std::size_t k = 0; k < stencil.nodes.size(); ++k) {
      const auto n = static_cast<std::size_t>(stencil.nodes[k]);
      displacement +=
          weights[r] * stencil.weights[k] * depth_step.displacements_O[n].cast<double>();
    }
  }
  return displacement;
}

double ForceOf(const Indentation& indentation) noexcept {
  double force = 0;
  for (const Indentation::Part& part : indentation.parts) {
    if (part.press && part.share > 0) force += part.share * ForceAt(*part.press, indentation.depth);
  }
  return force;
}

Vector3d DisplacementOf(const Indentation& indentation, const Vector2d& p_O) noexcept {
  if (!(p_O.norm() < indentation.rim)) return Vector3d::Zero();
  const double p = indentation.place_O.norm();
  const Vector2d axis = p > 0 ? Vector2d(indentation.place_O / p) : Vector2d(1, 0);
  const Vector2d across(-axis.y(), axis.x());
  const Vector2d turned(axis.dot(p_O), across.dot(p_O));
  Vector3d u = Vector3d::Zero();
  for (const Indentation::Part& part : indentation.parts) {
    if (!part.press || !(part.share > 0)) continue;
    u += part.share * DisplacementAt(*part.press, Carried(turned, p, part.radius, indentation.rim),
                                     indentation.depth);
  }
  Vector3d u_O;
  u_O << u.x() * axis + u.y() * across, u.z();
  return u_O;
}

}  // namespace palpate::simulation
