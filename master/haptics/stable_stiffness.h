// StableStiffness is the largest stiffness that a device renders stably at its rate.
// StiffnessNotice reports the setting that exceeds it.
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

// RenderedRate holds the properties of device and session that the limit depends on.
struct RenderedRate {
  double device_stiffness = std::numeric_limits<double>::infinity();  // by its maker [N/m]
  double device_rate = 0;                                             // [Hz]; 0: unknown
  double sensor_rate = 0;                                             // [Hz]; 0: unknown
};

// Returns the largest stable stiffness at the device in `mode` [N/m]. `one_way` is the delay of the
// link [s].
double StableStiffness(RenderMode mode, const RenderedRate& rate, double one_way);

// StiffnessNotice compares the stiffness of each tick with the limit, and reports each setting
// once.
class StiffnessNotice {
 public:
  // `limit`: largest stiffness of the contact in the mode `local` [N/m].
  StiffnessNotice(const RenderedRate& rate, double limit) : rate_(rate), limit_(limit) {}

  // Returns a sentence that names the key to change; empty if there is nothing new.
  std::string Check(const TickRecord& tick);

 private:
  RenderedRate rate_;
  double limit_;
  double noticed_scales_ = 0;  // product of the scales [-]
  std::optional<RenderMode> noticed_mode_;
};

}  // namespace palpate
