// What a device renders stably at its rate, and which setting asks for more.
//
// A spring that is sampled with the period T and held is passive if the physical damping b of
// device and operator dissipates the energy that it leaks (Colgate & Schenkel 1994; the time t_d
// delays the force, a virtual damping of the spring is not used):
//
//   K < b / (T / 2 + t_d)
//
//   local         T: tick, or period of the device if it is longer;      t_d = 0
//   hold          T: sample period of the slave;                         t_d: one way of the link
//   interpolate   the same, delayed by another sample period
//
// The stiffness at the device is position scale x force scale x stiffness at the tool.
#pragma once

#include <limits>
#include <optional>
#include <string>

#include "master/haptics/render_mode.h"
#include "master/haptics/tick_record.h"

namespace palpate {

// What of it depends on device and session.
struct RenderedRate {
  double device_stiffness = std::numeric_limits<double>::infinity();  // by its maker [N/m]
  double device_rate = 0;                                             // [Hz]; 0: unknown
  double sensor_rate = 0;                                             // [Hz]; 0: unknown
};

// The largest stiffness at the device in `mode` [N/m]. `one_way`: delay of the link [s].
double StableStiffness(RenderMode mode, const RenderedRate& rate, double one_way);

// Compares each tick's stiffness with it, and reports a setting once.
class StiffnessNotice {
 public:
  // `limit`: the stiffness that `local` leaves to the contact [N/m].
  StiffnessNotice(const RenderedRate& rate, double limit) : rate_(rate), limit_(limit) {}

  // A sentence that names the key to change; empty: nothing new.
  std::string Check(const TickRecord& tick);

 private:
  RenderedRate rate_;
  double limit_;
  double noticed_scales_ = 0;  // product of the scales [-]
  std::optional<RenderMode> noticed_mode_;
};

}  // namespace palpate
