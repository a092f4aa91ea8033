// Messages of palpate.v1's devices.proto: from and to drivers of cameras and arms.
#include "shared/text/text.h"
#include "shared/wire/fields.h"
#include "slave/service/messages.h"

namespace palpate {
namespace {

constexpr double kFarthest = 100;           // [m]
constexpr double kLongestDelay = 1;         // of an image [s]
constexpr std::size_t kLongestFault = 200;  // [characters]

std::optional<PushedPicture> Pushed(const v1::Image& message, std::string_view name,
                                    FieldReader* reader) {
  using Encoding = PushedPicture::Encoding;
  PushedPicture picture{
      .data = &message.data(), .width = message.width(), .height = message.height()};
  const int encoding = message.encoding();
  const bool is_known =
      encoding >= v1::Image::ENCODING_JPEG && encoding <= v1::Image::ENCODING_GREY16;
  reader->Require(is_known, std::string(name) + ".encoding = " + std::to_string(encoding),
                  "JPEG, PNG, GREY8, BGR8 or GREY16");
  if (!is_known) return std::nullopt;
  picture.encoding = static_cast<Encoding>(encoding - v1::Image::ENCODING_JPEG);
  return picture;
}

}  // namespace

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

std::optional<PushedSample> FromProto(const v1::ImageSample& message, std::string* reason) {
  FieldReader reader(reason);
  reader.Require(message.has_sensed_at(), "sensed_at is absent", "a time");
  reader.Require(message.has_image(), "image is absent", "an image");
  if (!reader.ok()) return std::nullopt;
  PushedSample sample;
  sample.sequence = message.sequence();
  sample.sensed_at = reader.Stamp("sensed_at", message.sensed_at());
  if (const auto image = Pushed(message.image(), "image", &reader)) sample.picture = *image;
  if (message.has_right()) sample.right = Pushed(message.right(), "right", &reader);
  if (message.has_right_sensed_at()) {
    sample.right_sensed_at = reader.Stamp("right_sensed_at", message.right_sensed_at());
  }
  sample.delay = reader.NonNegative("delay", message.delay(), kLongestDelay);
  if (!reader.ok()) return std::nullopt;
  return sample;
}

std::optional<ArmReading> FromProto(const v1::ArmReport& message, std::string* reason) {
  FieldReader reader(reason);
  reader.Require(message.sequence() != 0, "sequence = 0", "one above the last, from 1");
  reader.Require(message.has_measured_at(), "measured_at is absent", "a time");
  reader.Require(message.has_p_s_tip(), "p_S_tip is absent", "the position of the tool tip");
  if (!reader.ok()) return std::nullopt;
  ArmReading reading;
  reading.sequence = message.sequence();
  reading.measured_at = reader.Stamp("measured_at", message.measured_at());
  reading.p_S_tip = reader.Vector("p_S_tip", message.p_s_tip(), kFarthest);
  if (message.has_measured_force()) {
    reading.force = reader.Vector("measured_force", message.measured_force(), kMaxForce);
  }
  reading.R_S_tool = reader.Rotation("orientation", message.orientation());
  reading.at_limit = message.at_limit();
  reading.fault = Presentable(message.fault(), kLongestFault);
  if (!reader.ok()) return std::nullopt;
  return reading;
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
