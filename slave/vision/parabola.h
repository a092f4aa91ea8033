// Vertex of the parabola through three equally spaced values.
#pragma once

namespace palpate {

struct Vertex {
  double offset = 0;  // from the middle value, in steps; 0 where the three lie on a line
  double value = 0;   // at the vertex
};

//   offset = (y_m - y_p) / (2 (y_m - 2 y_0 + y_p)),   value = y_0 - (y_m - y_p) offset / 4
//
// with y_0 an extremum of the three, so that |offset| <= 1/2. Real-time safe.
constexpr Vertex FitParabola(double y_m, double y_0, double y_p) noexcept {
  const double bend = y_m - 2 * y_0 + y_p;
  if (bend == 0) return {0, y_0};
  const double offset = (y_m - y_p) / (2 * bend);
  return {offset, y_0 - (y_m - y_p) * offset / 4};
}

}  // namespace palpate
