// Messages of palpate.v1's devices.proto to drivers and about them.
#include "shared/wire/fields.h"
#include "slave/service/messages.h"

namespace palpate {

void ToProto(const ArmHealth& health, v1::ArmStatus* message) {
  message->set_driver_name(health.driver);
  message->set_fault(health.fault);
  if (health.lag) message->set_lag(*health.lag);
  if (health.scale) message->set_scale(*health.scale);
  message->set_reports(health.reports);
  message->set_rate(health.rate);
}

void ToProto(const CameraHealth& health, v1::CameraStatus* message) {
  message->set_trouble(health.trouble);
  message->set_taken(health.taken);
  message->set_dropped(health.dropped);
  message->set_skew(health.skew);
}

void ToProto(const ArmAim& aim, Time now, v1::ArmTarget* message) {
  message->Clear();
  message->set_sequence(aim.sequence);
  ToProto(now, message->mutable_sent_at());
  const auto motion = static_cast<int>(aim.motion) + v1::ArmTarget::MOTION_FOLLOW;
  message->set_motion(static_cast<v1::ArmTarget::Motion>(motion));
  ToProto(aim.p_S_tip, message->mutable_p_s_tip());
  ToProto(aim.velocity, message->mutable_velocity());
  ToProto(aim.R_S_tool, message->mutable_orientation());
  if (aim.echo) ToProto(*aim.echo, message->mutable_echo());
}

}  // namespace palpate
