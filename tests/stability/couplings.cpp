#include "tests/stability/couplings.h"

#include <cmath>
#include <utility>

namespace palpate {

double Controlled::Step(double x, double v) {
  constexpr double kSlew = 200;  // [N/s]
  control_.Observe({x, 0, 0}, {-shown_, 0, 0}, kTick);
  const Eigen::Vector3d wanted(-Bare::Step(x, v), 0, 0), v_M(v, 0, 0);
  shown_ = -control_.Afford(control_.Apply(wanted, v_M, kTick), v_M, kSlew).x();
  return shown_;
}

Modelled::Modelled(double stiffness, std::size_t delay_ticks) : Coupling(stiffness, delay_ticks) {
  LocalModel model;
  model.normal = {-1, 0, 0};
  model.stiffness(0, 0) = stiffness;
  model.valid_radius = 1;
  model.revision = 1;
  contact_.Take(model, -1);
}

double Modelled::Step(double x, double) {
  t_ += kTick;
  return -contact_.ForceAt({x, 0, 0}, t_).x();
}

double Waves::Step(double x, double v) {
  if (!std::exchange(begun_, true)) x_tool_ = x;
  const double root = std::sqrt(2 * b_);
  const double f = b_ * v - root * w_, u = root * v - w_;
  const double u_tool = up_.Pass(u);
  // Free of the wall at the tick's end, or in it.
  double v_tool = root * u_tool / (2 * b_);
  if (x_tool_ + v_tool * kTick > 0) v_tool = (root * u_tool - K_ * x_tool_) / (2 * b_ + K_ * kTick);
  x_tool_ += v_tool * kTick;
  const double f_tool = WallAt(x_tool_) + b_ * v_tool, w_tool = u_tool - root * f_tool / b_;
  w_ = down_.Pass(w_tool);
  kept_ += (f * v - f_tool * v_tool) * kTick;
  return f;
}

}  // namespace palpate
