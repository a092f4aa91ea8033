#include "master/haptics/stable_stiffness.h"

#include <algorithm>
#include <chrono>

#include "master/haptics/force_chain.h"
#include "master/haptics/periodic.h"
#include "shared/text/text.h"

namespace palpate {

double StableStiffness(RenderMode mode, const RenderedRate& rate, double one_way) {
  const double tick = std::chrono::duration<double>(kHapticPeriod).count();
  double period = rate.device_rate > 0 ? std::max(tick, 1 / rate.device_rate) : tick;
  double delay = 0;
  if (mode != RenderMode::kLocal && rate.sensor_rate > 0) {
    period = std::max(period, 1 / rate.sensor_rate);
    delay = one_way + (mode == RenderMode::kInterpolate ? period : 0);
  }
  const double passive = PassivityControl::kPhysicalDamping / (period / 2 + delay);
  return std::min(rate.device_stiffness, passive);
}

std::string StiffnessNotice::Check(const TickRecord& tick) {
  const double scales = tick.position_scale * tick.force_scale;
  const double stiffness = scales * tick.model_stiffness;
  double stable = StableStiffness(tick.render, rate_, tick.round_trip / 2);
  const bool is_local = tick.render == RenderMode::kLocal;
  if (is_local) stable = std::min(stable, limit_);
  if (!(stiffness > stable) || (noticed_scales_ == scales && noticed_mode_ == tick.render))
    return {};
  noticed_scales_ = scales;
  noticed_mode_ = tick.render;
  return Formatted(
             "operator.position_scale %.4g x operator.force_scale %.4g x %.4g N/m of the object = "
             "%.4g N/m at the device, which renders %.4g N/m stably with --render ",
             tick.position_scale, tick.force_scale, tick.model_stiffness, stiffness, stable) +
         std::string(ToString(tick.render)) +
         (is_local ? ": a stiffer contact is rendered with that. "
                   : ": the passivity control damps the excess. ") +
         Formatted("Lower operator.force_scale to %.3g, or operator.position_scale",
                   tick.force_scale * stable / stiffness) +
         (is_local ? "." : ", or use --render local.");
}

}  // namespace palpate
